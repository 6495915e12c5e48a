"""Effectors that can touch nothing: their shape lies inside that of a link which always moves with it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product

from .. import ir
from ..extents import box_sides
from ..poses import compose, inverse, position

Ball = tuple[ir.Vec3, float]
"""A centre and a radius, metres."""
STILL = 1e-9
_ALONG = [d for d in product((-1, 0, 1), repeat=3) if any(d)]
DEEP = 1e-3
"""Metres: what the verifier forgives as an overlap is no obstacle to touch either (`penetration_m`)."""


def sunken(module: ir.ModuleType) -> Iterator[tuple[ir.Effector, float, bool]]:
    """The effectors all of whose shape, or the point of it that is farthest along its normal, lies more than `DEEP`
    below the surface of a link, how deep at least, and whether it is all of it. Of an end that no joint moves, such as
    the foot of an arm, only all of it counts."""
    for effector in module.effectors:
        if effector.shape is None:
            continue
        balls = balls_of(effector.shape)
        frame: int | None = effector.joint
        place = effector.placement
        while frame is not None:
            links = [link for link in module.links if link.joint == frame]
            depth = max((_depth(link, place, balls) for link in links), default=0.0)
            foremost = _foremost(effector.shape)
            ahead = max((_depth(link, place, foremost) for link in links if frame == effector.joint >= 0), default=0.0)
            if max(depth, ahead) > DEEP:
                yield effector, max(depth, ahead), depth > DEEP
                break
            frame, place = _outwards(module, effector.shape, frame, place)


def _outwards(
    module: ir.ModuleType, shape: ir.Shape, frame: int, place: ir.Pose
) -> tuple[int | None, ir.Pose]:
    """The frame before a joint, where a ball on the axis about which it turns stays in the same place."""
    if frame < 0 or shape.kind != ir.ShapeKind.SPHERE:
        return None, place
    joint = module.joints[frame]
    along = sum(a * p for a, p in zip(joint.axis, position(place), strict=True))
    aside = math.dist(position(place), [along * a for a in joint.axis])
    if joint.kind != ir.JointKind.REVOLUTE or aside > STILL:
        return None, place
    return joint.parent, compose(joint.placement, place)


def _foremost(shape: ir.Shape) -> list[Ball]:
    """The points of a shape that are farthest along z, its outward normal, one of each part that is; these are over the
    middle of the part."""
    tops = [(part.at, max(at[2] + radius for at, radius in balls_of(part.shape))) for part in shape.solids]
    highest = max(at[2] + top for at, top in tops)
    return [((at[0], at[1], highest), 0.0) for at, top in tops if at[2] + top > highest - STILL]


def balls_of(shape: ir.Shape) -> list[Ball]:
    """Balls whose hull holds a shape."""
    if shape.parts:
        return [(_sum(at, part.at), radius) for part in shape.parts for at, radius in balls_of(part.shape)]
    match shape.kind:
        case ir.ShapeKind.SPHERE:
            return [((0.0, 0.0, 0.0), shape.size[0])]
        case ir.ShapeKind.CAPSULE:
            return [((0.0, 0.0, side * shape.size[1] / 2), shape.size[0]) for side in (-1, 1)]
        case _:
            x, y, z = (side / 2 for side in box_sides(shape))
            return [((a * x, b * y, c * z), 0.0) for a, b, c in product((-1, 1), repeat=3)]


def _sum(a: ir.Vec3, b: ir.Vec3) -> ir.Vec3:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _depth(link: ir.Link, place: ir.Pose, balls: Sequence[Ball]) -> float:
    """How far below the surface of a link, which is convex, all balls of an end at `place` lie; below 0 where one is
    out of it."""
    inside = compose(inverse(link.placement), place)
    found = [(position(compose(inside, (*at, 0.0, 0.0, 0.0, 1.0))), radius) for at, radius in balls]
    if link.shape.kind != ir.ShapeKind.CONVEX:
        return min(below(link.shape, at) - radius for at, radius in found)
    depth = min(_below_sides(link.shape.size, at) - radius for at, radius in found)
    return depth if depth <= DEEP else min(_below_faces(link.shape, at) - radius for at, radius in found)


def below(shape: ir.Shape, point: ir.Vec3) -> float:
    """How far a point lies below the surface of a shape; of a hull nothing is said."""
    x, y, z = point
    size = shape.size
    match shape.kind:
        case ir.ShapeKind.SPHERE:
            return size[0] - math.hypot(x, y, z)
        case ir.ShapeKind.CAPSULE:
            return size[0] - math.hypot(x, y, max(abs(z) - size[1] / 2, 0.0))
        case ir.ShapeKind.CYLINDER:
            return min(size[0] - math.hypot(x, y), size[1] / 2 - abs(z))
        case ir.ShapeKind.BOX:
            return min(side / 2 - abs(at) for side, at in zip(size, point, strict=True))
        case _:
            return -math.inf


def _below_sides(corners: Sequence[float], point: ir.Vec3) -> float:
    """How far a point lies below the planes around a hull along some directions: no less than below its surface. Most
    ends are out of their links, which this tells without a library."""
    found = math.inf
    for x, y, z in _ALONG:
        top = max(x * a + y * b + z * c for a, b, c in zip(corners[::3], corners[1::3], corners[2::3], strict=True))
        found = min(found, (top - x * point[0] - y * point[1] - z * point[2]) / math.hypot(x, y, z))
    return found


def _below_faces(shape: ir.Shape, point: ir.Vec3) -> float:
    import numpy as np

    from ..hulls import hull

    return -float(hull(shape).distance(np.array(point)))
