"""Shapes of links for which the shape of an effector stands: what a file has at a foot or a fingertip, where the
program says again what that end is. Both would touch the ground, and the body around a mesh is larger than the mesh."""

from __future__ import annotations

from collections.abc import Sequence

from .. import ir
from ..poses import compose, inverse, part_pose, position
from .sunken_ends import balls_of, below

ALIKE = 1e-3
"""Metres by which a shape may stand out of the effector's and still be the same: what the verifier forgives as an
overlap (`penetration_m`)."""
COARSE, MOST = 0.13, 3e-3
"""The corners of a body of 26 faces around a ball stand out of it by 0.128 of its radius. Of a convex body so much is
forgiven, as a share of the effector's least half size, but no more than so many metres."""


def covers(effector: ir.Effector, link: ir.Link) -> bool:
    """Whether a link's shape moves with an effector and lies in its shape, but for what coarse bodies stand out."""
    if effector.shape is None or effector.joint != link.joint:
        return False
    return any(_holds(part.shape, part_pose(effector.placement, part), link) for part in effector.shape.solids)


def _holds(shape: ir.Shape, placement: ir.Pose, link: ir.Link) -> bool:
    """Whether a link's shape lies in a convex shape."""
    room = ALIKE
    if link.shape.kind == ir.ShapeKind.CONVEX:
        room = max(room, min(MOST, COARSE * _half(shape)))
    inside = compose(inverse(placement), link.placement)
    return all(
        below(shape, position(compose(inside, (*at, 0.0, 0.0, 0.0, 1.0)))) - radius >= -room
        for at, radius in _points(link.shape)
    )


def _half(shape: ir.Shape) -> float:
    """The radius of a round shape, half the least side of a box."""
    return min(shape.size) / 2 if shape.kind == ir.ShapeKind.BOX else shape.size[0]


def _points(shape: ir.Shape) -> Sequence[tuple[ir.Vec3, float]]:
    """Balls whose hull is a shape, or holds it."""
    if shape.kind != ir.ShapeKind.CONVEX:
        return balls_of(shape)
    x, y, z = (shape.size[i::3] for i in range(3))
    return [(corner, 0.0) for corner in zip(x, y, z, strict=True)]
