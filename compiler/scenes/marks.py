"""Marks: sheets that lie flat on what never moves, and never move themselves. Nothing collides with them, as it would
with what bears them."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Set

from .. import ir
from ..extents import box_sides, corners
from ..poses import orientation, position, rotate
from .check_start import TOLERANCE

REGION = "region"
"""The built-in type of what is only a place."""
ROUNDING = 1e-6
RIM = 16
"""Points on a rim."""


def with_marks(
    bodies: Mapping[str, ir.Body], courses: Set[str], types: Mapping[str, str | None]
) -> dict[str, ir.Body]:
    """The bodies, with those told apart that collide with nothing: regions, and marks. `courses` names what moves by
    itself."""
    still = [b for b in bodies.values() if not b.movable and b.name not in courses]
    found = dict(bodies)
    for body in bodies.values():
        if is_region(body.type, types):
            found[body.name] = dataclasses.replace(body, collides=False)
    bearers = [b for b in still if found[b.name].collides]
    for body in bearers:
        if min(box_sides(body.shape)) <= TOLERANCE + ROUNDING and any(
            _flat_on(body, other) for other in bearers if other is not body and max(box_sides(other.shape)) > TOLERANCE
        ):
            found[body.name] = dataclasses.replace(body, collides=False)
    return found


def is_region(type_: str | None, types: Mapping[str, str | None]) -> bool:
    """Whether things of a type are only places."""
    while type_ is not None and type_ != REGION:
        type_ = types.get(type_)
    return type_ is not None


def _flat_on(body: ir.Body, other: ir.Body) -> bool:
    """Whether no corner of a body is farther than the tolerance from another one, which is thicker."""
    if min(box_sides(other.shape)) <= min(box_sides(body.shape)):
        return False
    at, near = position(body.pose), TOLERANCE + ROUNDING
    corners = [_sum(at, rotate(orientation(body.pose), corner)) for corner in _outermost(body.shape)]
    if any(_from_box(corner, other) > near for corner in corners):
        return False
    if other.shape.kind == ir.ShapeKind.BOX and not other.shape.parts:
        return True
    # NumPy, which that loads, is slow to load: plain arithmetic tells of most things.
    from ..symbolic.geometry import Placed, shape_distance

    point = ir.Shape(ir.ShapeKind.SPHERE, (0.0,))
    for corner in corners:
        placed = Placed(point, (*corner, 0.0, 0.0, 0.0, 1.0))
        if shape_distance(placed, Placed(other.shape, other.pose)) > near:
            return False
    return True


def _from_box(point: ir.Vec3, body: ir.Body) -> float:
    """How far a point of the world is from the box around a body along its own axes, metres; 0 within."""
    x, y, z, w = orientation(body.pose)
    x0, y0, z0 = position(body.pose)
    local = rotate((-x, -y, -z, w), (point[0] - x0, point[1] - y0, point[2] - z0))
    return math.hypot(*(max(abs(v) - side / 2.0, 0.0) for v, side in zip(local, box_sides(body.shape), strict=True)))


def _sum(one: ir.Vec3, other: ir.Vec3) -> ir.Vec3:
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]


def _outermost(shape: ir.Shape) -> list[ir.Vec3]:
    """The corners of a shape in its own frame; of a cylinder points on its rims, of others the corners around it."""
    if shape.kind == ir.ShapeKind.CONVEX:
        return list(corners(shape))
    x, y, z = (side / 2 for side in box_sides(shape))
    if shape.kind == ir.ShapeKind.CYLINDER:
        turns = [math.tau * k / RIM for k in range(RIM)]
        return [(x * math.cos(t), y * math.sin(t), height) for t in turns for height in (-z, z)]
    return list(itertools.product((-x, x), (-y, y), (-z, z)))
