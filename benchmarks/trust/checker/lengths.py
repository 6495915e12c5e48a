"""The lengths that conditions ask for, in a scene whose frames are given. Metres.

`reach` is what docs/language.md calls "how far apart two effectors can be": the lengths of the placements on the way
between them, with the full travel of prismatic joints, and between docked modules both radii.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tamplang.compiler import ir

from .shapes import Solid, distance, solid_of

Matrix = NDArray[np.float64]
Placed = tuple[Solid, Matrix]


class Lengths:
    """`shapes` are those of every object with their places: a body's, an effector's, all of a module's."""

    def __init__(self, world: ir.World, shapes: Mapping[str, list[Placed]]) -> None:
        self.world, self.shapes = world, shapes
        self._known: dict[tuple[Any, ...], float] = {}

    def distance(self, one: str, other: str) -> float:
        key = ("distance", one, other)
        if key not in self._known:
            pairs = [(a, b) for a in self.shapes.get(one, []) for b in self.shapes.get(other, [])]
            self._known[key] = max(0.0, min((distance(a, b) for a, b in pairs), default=0.0))
        return self._known[key]

    def stride(self, one: str, other: str, inset: float) -> float:
        key = ("stride", one, other, inset)
        if key not in self._known:
            pairs = [(a, b) for a in self.shapes.get(one, []) for b in self.shapes.get(other, [])]
            tops = [distance(_top(a, inset), _top(b, inset)) for a, b in pairs]
            self._known[key] = max(0.0, min(tops, default=0.0))
        return self._known[key]

    def radius(self, name: str) -> float:
        shapes = self.shapes.get(name, [])
        return shapes[0][0].around if len(shapes) == 1 else 0.0

    def reach(self, start: str, end: str) -> float:
        module, _, first = start.rpartition(".")
        if end.rpartition(".")[0] != module:
            raise ValueError(f"{start} and {end} are not of one module")
        return _way(self.world.modules[module].type, first, end.rpartition(".")[2])

    def chain_reach(self, chain: ir.Chain) -> float:
        total = sum(self.reach(enter, leave) for _, enter, leave in chain.modules)
        docked = zip(chain.modules, chain.modules[1:], strict=False)
        return total + sum(self.radius(a[2]) + self.radius(b[1]) for a, b in docked)


def _way(kind: ir.ModuleType, start: str, end: str) -> float:
    """The lengths of the placements between two effectors, up to the joint that carries both."""

    def upwards(name: str) -> dict[int, tuple[NDArray[np.float64], float]]:
        effector = kind.effector(name)
        joint, point, gone = effector.joint, np.array(effector.placement[:3]), 0.0
        found = {joint: (point, gone)}
        while joint >= 0:
            record = kind.joints[joint]
            gone += float(np.linalg.norm(point))
            if record.kind == "prismatic":
                gone += max(abs(record.lower), abs(record.upper))
            joint, point = record.parent, np.array(record.placement[:3])
            found[joint] = (point, gone)
        return found

    first, second = upwards(start), upwards(end)
    common = max(set(first) & set(second))
    (one, way), (other, back) = first[common], second[common]
    return way + back + float(np.linalg.norm(one - other))


def _top(placed: Placed, inset: float) -> Placed:
    """The upper face of a box, or of the box around a convex shape, shrunk; the highest point of any other shape."""
    solid, frame = placed
    if solid.kind in ("box", "convex"):
        sides = np.array(solid.sides)
        axis = int(np.argmax(np.abs(frame[2, :3])))
        centre = np.zeros(4)
        centre[3], centre[axis] = 1.0, math.copysign(sides[axis] / 2, frame[2, axis])
        sides = np.maximum(sides - 2 * inset, 0.0)
        sides[axis] = 0.0
        moved = frame.copy()
        moved[:, 3] = frame @ centre
        return solid_of("box", [float(max(s, 1e-6)) for s in sides]), moved
    moved = np.eye(4)
    moved[:3, 3] = frame[:3, 3]
    moved[2, 3] += solid.rise(frame)
    return solid_of("sphere", [1e-6]), moved
