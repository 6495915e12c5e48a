"""How far what stands on something does so around its middle."""

from __future__ import annotations

from ..ir import Effector, Module, Problem, Shape, ShapeKind
from .structure import driven


def driven_away(found: tuple[Module, Effector]) -> bool:
    """Whether an end carries a planar joint: what stands on it stands where that is."""
    return driven(found[0].type, found[1].joint) != found[1].joint


def foot_radius(problem: Problem, name: str) -> float:
    """How far from where an end or a body stands it tips: half the smaller side of its shape, seen from above; of what
    carries a planar joint, of the largest part on that."""
    found = problem.world.effector(name)
    if found is not None and driven_away(found):
        node = driven(found[0].type, found[1].joint)
        return max([_half(k.shape) for k in found[0].type.links if k.joint == node], default=0.0)
    shape = found[1].shape if found is not None else problem.world.bodies[name].shape
    return 0.0 if shape is None else _half(shape)


def _half(shape: Shape) -> float:
    if shape.kind == ShapeKind.BOX:
        return min(shape.size[0], shape.size[1]) / 2.0
    if shape.kind == ShapeKind.CONVEX:
        return min(max(shape.size[k::3]) - min(shape.size[k::3]) for k in (0, 1)) / 2.0
    return shape.size[0]
