"""How far modules and chains of them reach at most. Metres."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..ir import Module, ModuleType, Shape, ShapeKind
from ..poses import position


def path_length(module: ModuleType, start: str, end: str) -> float:
    """Upper bound in metres on the distance of two effectors of a module: lengths of the placements on the way between
    them, with the full travel of prismatic joints."""

    def climb(name: str) -> list[tuple[int, tuple[float, float, float], float]]:
        effector = module.effector(name)
        at, point, travel = effector.joint, position(effector.placement), 0.0
        steps = [(at, point, 0.0)]
        while at >= 0:
            joint = module.joints[at]
            travel += math.hypot(*point)
            travel += joint.slide
            at, point = joint.parent, position(joint.placement)
            steps.append((at, point, travel))
        return steps

    first, second = climb(start), {at: (point, travel) for at, point, travel in climb(end)}
    for at, point, travel in first:
        if at in second:
            other, rest = second[at]
            return travel + rest + math.dist(point, other)
    return math.inf


def longest_chain(modules: Iterable[Module], count: int, more: int = 0) -> float:
    """No chain of `count` of the modules, and of `more` others like those that reach farthest, reaches farther."""
    lengths = []
    for module in modules:
        ends = module.type.effectors
        radii = [end_radius(module.type, e.name) for e in ends] or [0.0]
        longest = max((path_length(module.type, a.name, b.name) for a in ends for b in ends), default=0.0)
        lengths.append((longest + 2 * max(radii), min(radii)))
    thinnest = min((thin for _, thin in lengths), default=0.0)
    wholes = sorted((whole for whole, _ in lengths), reverse=True)
    return sum((wholes[:1] * more + wholes)[: count + more]) - 2 * thinnest


def end_radius(module: ModuleType, effector: str) -> float:
    """The radius of an effector; 0 without shape."""
    shape = module.effector(effector).shape
    return 0.0 if shape is None else shape_radius(shape)


def shape_radius(shape: Shape) -> float:
    """The radius of a round shape, of the sphere around another one."""
    if shape.kind == ShapeKind.CONVEX:
        return max(math.hypot(*shape.size[i : i + 3]) for i in range(0, len(shape.size), 3))
    return shape.size[0] if shape.kind != ShapeKind.BOX else math.hypot(*shape.size) / 2
