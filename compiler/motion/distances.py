"""Symbolic measures of shapes: gap, highest and lowest point, inclusion, as CasADi expressions in metres."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import casadi as ca
import numpy as np

from ...langs.frozen import dataclass
from ..hulls import Array, Hull, hull, top_edges
from ..ir import Shape, ShapeKind, SolidPart
from ..physics.masses import DENSITY, parts_volume
from .kinematics import Expression, Frame, axis, compose, unrotate

SMOOTH = 1e-10
"""Squared metres under the roots: keeps their derivatives finite where a distance is zero."""

PARALLEL = 1e-6
"""Squared sine below which two edges count as parallel and give no separating axis."""

NEAR = 1e-8
"""Squared metres below which two points count as one, and show no way."""

PROJECTIONS = 8
"""How often points are projected on both shapes. Of random pairs of 4 to 60 cm, up to 2 cm apart, gaps of capsules to
capsules and boxes are then exact to 0.4 mm (without, 38 mm), those of cylinders for the half to 1 µm, for 95 % to 3 mm
(20 mm)."""

MANY_FACES, FEWER_PROJECTIONS = 50, 3
"""On convex bodies of more triangles points are projected less often: each time takes 30 terms for each of them."""

SIZES = {ShapeKind.BOX: 3, ShapeKind.SPHERE: 1, ShapeKind.CAPSULE: 2, ShapeKind.CYLINDER: 2}
"""How many numbers describe each kind of shape that is not given as a whole, in the order of `ir.Shape.size`."""

NOWHERE = -1.0
"""Metres: how far anything is inside a top that is only an edge or a point."""


@dataclass(frozen=True, slots=True)
class DistanceShape:
    """A shape at a symbolic frame. `size` and `parts` as in `ir.Shape`; an object without a shape is a sphere of
    radius 0."""

    frame: Frame
    kind: ShapeKind
    size: Sequence[Expression]
    balance: Callable[[], tuple[Expression, Expression]] | None = None
    """Mass and centre of mass of the whole module that the shape belongs to; None for a body that states no mass."""
    parts: tuple[SolidPart, ...] = ()

    @property
    def solids(self) -> list[DistanceShape]:
        """The convex shapes that it is made of; the first bears what stands on it."""
        if not self.parts:
            return [self]
        return [
            DistanceShape(compose(self.frame, part.placement), part.shape.kind, part.shape.size) for part in self.parts
        ]


def _length(v: Expression) -> Expression:
    return ca.sqrt(ca.dot(v, v) + SMOOTH)


def _largest(items: Sequence[Expression]) -> Expression:
    result = items[0]
    for item in items[1:]:
        result = ca.fmax(result, item)
    return result


def rounded_box_distance(excess: Sequence[Expression]) -> Expression:
    """Signed distance to a box from how far a point is beyond its sides along each axis."""
    outside = ca.vertcat(*[ca.fmax(e, 0) for e in excess])
    return _length(outside) + ca.fmin(_largest(excess), 0)


def _hull(solid: DistanceShape) -> Hull:
    """The planes and corners of a convex solid, the sizes of which are always plain numbers."""
    return hull(Shape(ShapeKind.CONVEX, tuple(float(s) for s in solid.size)))


def _hull_distance(body: Hull, point: Expression) -> Expression:
    """Signed distance of a point (3,) to a convex body, both in its frame. Outside, the nearest point lies in the face
    above which the point is, or else on the nearest edge."""
    distance = -_largest([-_length(point - _on_edge(body, edge, point)) for edge in _edges(body)])
    for height, above, _ in _faces_below(body, point):
        distance = ca.if_else(above, height, distance)
    deepest = _height(body, point)
    return ca.if_else(deepest < 0, deepest, distance)


def _on_hull(body: Hull, point: Expression) -> Expression:
    """The nearest point (3,) of a convex body, in its frame."""
    first, *others = (_on_edge(body, edge, point) for edge in _edges(body))
    nearest, least = first, ca.sumsqr(point - first)
    for found in others:
        squared = ca.sumsqr(point - found)
        nearest, least = ca.if_else(squared < least, found, nearest), ca.fmin(squared, least)
    for height, above, normal in _faces_below(body, point):
        nearest = ca.if_else(above, point - height * normal, nearest)
    return ca.if_else(_height(body, point) < 0, point, nearest)


def _height(body: Hull, point: Expression) -> Expression:
    """How high a point is above the plane of the face that it is highest above."""
    return _largest([ca.dot(ca.SX(n), point) - d for n, d in zip(body.normals, body.offsets, strict=True)])


def _edges(body: Hull) -> list[tuple[int, int]]:
    """The two corners of each edge of the triangles."""
    ends = (edge for a, b, c in body.triangles.tolist() for edge in ((a, b), (b, c), (c, a)))
    return sorted({(min(edge), max(edge)) for edge in ends})


def _on_edge(body: Hull, edge: tuple[int, int], point: Expression) -> Expression:
    """The nearest point (3,) of an edge."""
    start = body.corners[edge[0]]
    along = body.corners[edge[1]] - start
    return start + ca.fmin(ca.fmax(ca.dot(ca.SX(along / (along @ along)), point - start), 0), 1) * along


def _faces_below(body: Hull, point: Expression) -> Iterator[tuple[Expression, Expression, Array]]:
    """Of each triangle how high a point is above its plane, whether it is right above the triangle itself, and the
    outward normal (3,)."""
    for triangle in body.triangles.tolist():
        corners = body.corners[triangle]
        across = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal = across / np.linalg.norm(across)
        height = ca.dot(ca.SX(normal), point - corners[0])
        above = height >= 0
        for k in range(3):
            side = np.cross(corners[(k + 1) % 3] - corners[k], normal)
            above = ca.logic_and(above, ca.dot(ca.SX(side), point - corners[k]) <= 0)
        yield height, above, normal


def _point_gap(point: Expression, solid: DistanceShape) -> Expression:
    """Signed distance of a point (3,) to the surface of a shape."""
    if solid.kind == ShapeKind.SPHERE:
        return _length(point - solid.frame.position) - solid.size[0]
    local = unrotate(solid.frame.quaternion, point - solid.frame.position)
    if solid.kind == ShapeKind.CONVEX:
        return _hull_distance(_hull(solid), local)
    if solid.kind == ShapeKind.BOX:
        return rounded_box_distance([ca.fabs(local[i]) - solid.size[i] / 2 for i in range(3)])
    radius, half = solid.size[0], solid.size[1] / 2
    if solid.kind == ShapeKind.CAPSULE:
        beyond = local[2] - ca.fmin(ca.fmax(local[2], -half), half)
        return _length(ca.vertcat(local[0], local[1], beyond)) - radius
    return rounded_box_distance([_length(local[:2]) - radius, ca.fabs(local[2]) - half])


def extent(solid: DistanceShape, direction: Expression) -> Expression:
    """How far the shape reaches from its centre along a unit direction (3,)."""
    along = [ca.dot(direction, axis(solid.frame.quaternion, letter)) for letter in "xyz"]
    if solid.kind == ShapeKind.CONVEX:
        local = ca.vertcat(*along)
        return _largest([ca.dot(ca.SX(corner), local) for corner in _hull(solid).corners])
    if solid.kind == ShapeKind.SPHERE:
        return solid.size[0]
    if solid.kind == ShapeKind.BOX:
        return sum(ca.fabs(along[i]) * solid.size[i] / 2 for i in range(3))
    radius, straight = solid.size[0], ca.fabs(along[2]) * solid.size[1] / 2
    if solid.kind == ShapeKind.CAPSULE:
        return straight + radius
    squared = along[0] ** 2 + along[1] ** 2
    return straight + radius * squared / ca.sqrt(squared + SMOOTH)


def _separation(a: DistanceShape, b: DistanceShape) -> Expression:
    """Largest separation along candidate axes: for boxes zero exactly when they touch, and never above the true
    distance. Of other shapes, which touch along other axes too, also along the way between points that come near to
    the nearest ones. Ericson, Real-Time Collision Detection, section 4.4."""
    offset = b.frame.position - a.frame.position

    def along(direction: Expression) -> Expression:
        return ca.fabs(ca.dot(offset, direction)) - extent(a, direction) - extent(b, direction)

    if ShapeKind.CONVEX in (a.kind, b.kind):
        return ca.fmax(_faces_apart(a, b), _way_apart(a, b))
    axes_a = [axis(a.frame.quaternion, letter) for letter in "xyz"]
    axes_b = [axis(b.frame.quaternion, letter) for letter in "xyz"]
    gaps = [along(direction) for direction in axes_a + axes_b]
    for first in axes_a:
        for second in axes_b:
            edge = ca.cross(first, second)
            squared = ca.dot(edge, edge)
            gaps.append(ca.if_else(squared < PARALLEL, -1e3, along(edge / ca.sqrt(squared + SMOOTH))))
    if (a.kind, b.kind) != (ShapeKind.BOX, ShapeKind.BOX):
        gaps.append(_way_apart(a, b))
    return _largest(gaps)


def _apart(a: DistanceShape, b: DistanceShape, direction: Expression) -> Expression:
    """How far `b` begins behind the end of `a` along a unit direction (3,): never more than their distance."""
    return ca.dot(b.frame.position - a.frame.position, direction) - extent(a, direction) - extent(b, -direction)


def _way_apart(a: DistanceShape, b: DistanceShape) -> Expression:
    """The separation along the way between two points near to each other; where these meet, very little."""
    way = _way_between(a, b)
    squared = ca.dot(way, way)
    return ca.if_else(squared < NEAR, -1e3, _apart(a, b, way / ca.sqrt(squared + SMOOTH)))


def _way_between(a: DistanceShape, b: DistanceShape) -> Expression:
    """From a point of `a` to one of `b` (3,), which projections on the two in turn bring near to each other; with
    momentum, as flat things do so slowly (Nesterov 1983)."""
    one = before = a.frame.position
    other = b.frame.position
    faces = max(len(_hull(s).triangles) if s.kind == ShapeKind.CONVEX else 0 for s in (a, b))
    for k in range(PROJECTIONS if faces <= MANY_FACES else FEWER_PROJECTIONS):
        ahead = one + k / (k + 3) * (one - before)
        other = _projected(b, ahead)
        one, before = _projected(a, other), one
    return other - one


def _projected(solid: DistanceShape, point: Expression) -> Expression:
    """The nearest point (3,) of a solid, of a capsule of its axis."""
    local = unrotate(solid.frame.quaternion, point - solid.frame.position)
    found: Sequence[Expression]
    if solid.kind == ShapeKind.CONVEX:
        found = ca.vertsplit(_on_hull(_hull(solid), local))
    elif solid.kind == ShapeKind.BOX:
        found = [ca.fmin(ca.fmax(local[i], -solid.size[i] / 2), solid.size[i] / 2) for i in range(3)]
    else:
        share = 0.0 if solid.kind == ShapeKind.CAPSULE else ca.fmin(1, solid.size[0] / _length(local[:2]))
        height = ca.fmin(ca.fmax(local[2], -solid.size[1] / 2), solid.size[1] / 2)
        found = [share * local[0], share * local[1], height]
    letters = (axis(solid.frame.quaternion, letter) for letter in "xyz")
    return solid.frame.position + sum(c * letter for c, letter in zip(found, letters, strict=True))


def _faces_apart(a: DistanceShape, b: DistanceShape) -> Expression:
    """Largest separation along the outward normals of both shapes' faces, and of the axes of shapes without: zero or
    less when they touch, and never above the true distance."""
    gaps = []
    for one, other in ((a, b), (b, a)):
        letters = [axis(one.frame.quaternion, letter) for letter in "xyz"]
        normals = _hull(one).normals if one.kind == ShapeKind.CONVEX else np.vstack([np.eye(3), -np.eye(3)])
        for normal in normals.tolist():
            direction = sum(c * letter for c, letter in zip(normal, letters, strict=True))
            gaps.append(_apart(one, other, direction))
    return _largest(gaps)


def gap(a: DistanceShape, b: DistanceShape) -> Expression:
    """Signed distance between two shapes, negative when they overlap. Exact when one is a sphere."""
    return -_largest([-_convex_gap(one, other) for one in a.solids for other in b.solids])


def _convex_gap(a: DistanceShape, b: DistanceShape) -> Expression:
    if a.kind == ShapeKind.SPHERE:
        return _point_gap(a.frame.position, b) - a.size[0]
    if b.kind == ShapeKind.SPHERE:
        return _point_gap(b.frame.position, a) - b.size[0]
    return _separation(a, b)


def top(solid: DistanceShape) -> Expression:
    """Height of the highest point; of several parts, of that on which things stand."""
    bearer = solid.solids[0]
    return bearer.frame.position[2] + extent(bearer, ca.SX([0, 0, 1]))


def bottom(solid: DistanceShape) -> Expression:
    """Height of the lowest point."""
    return solid.frame.position[2] - extent(solid, ca.SX([0, 0, -1]))


def inside(solid: DistanceShape, surface: DistanceShape) -> Expression:
    """How far the centre of `solid` is inside the four sides of the top face of `surface`, in the axes of
    `surface` (4,); for a round surface four times the distance to its rim, for a convex one to a quarter of its edges
    each."""
    surface = surface.solids[0]
    local = unrotate(surface.frame.quaternion, solid.frame.position - surface.frame.position)
    if surface.kind == ShapeKind.BOX:
        x, y = surface.size[0] / 2, surface.size[1] / 2
        return ca.vertcat(x - local[0], x + local[0], y - local[1], y + local[1])
    if surface.kind == ShapeKind.CONVEX:
        normals, offsets = top_edges(Shape(ShapeKind.CONVEX, tuple(float(s) for s in surface.size)))
        within = [d - ca.dot(ca.SX(n), local[:2]) for n, d in zip(normals, offsets, strict=True)]
        quarters = [within[len(within) * k // 4 :][: max(1, len(within) // 4 + 1)] for k in range(4)]
        return ca.vertcat(*[-_largest([-w for w in quarter]) if quarter else NOWHERE for quarter in quarters])
    return ca.repmat(surface.size[0] - _length(local[:2]), 4, 1)


def radius(solid: DistanceShape) -> Expression:
    """Radius of a sphere, or of the sphere around another shape."""
    if solid.kind == ShapeKind.SPHERE:
        return ca.SX(solid.size[0])
    if solid.kind == ShapeKind.BOX:
        return ca.sqrt(sum(s**2 for s in solid.size)) / 2
    if solid.kind == ShapeKind.CONVEX:
        return ca.SX(_hull(solid).radius)
    if solid.kind == ShapeKind.CAPSULE:
        return solid.size[0] + solid.size[1] / 2
    return ca.sqrt(solid.size[0] ** 2 + (solid.size[1] / 2) ** 2)


def mass(solid: DistanceShape) -> Expression:
    """Kilograms of a solid shape at the density of water."""
    if solid.parts:
        return ca.SX(DENSITY * parts_volume(solid.parts))
    size = solid.size
    if solid.kind == ShapeKind.CONVEX:
        return ca.SX(DENSITY * _hull(solid).volume)
    if solid.kind == ShapeKind.BOX:
        return DENSITY * size[0] * size[1] * size[2]
    ball = 4.0 / 3.0 * math.pi * size[0] ** 3
    if solid.kind == ShapeKind.SPHERE:
        return ca.SX(DENSITY * ball)
    straight = math.pi * size[0] ** 2 * size[1]
    return DENSITY * (straight + ball if solid.kind == ShapeKind.CAPSULE else straight)


PAIRS: dict[str, Callable[[DistanceShape, DistanceShape], Expression]] = {"gap": gap, "inside": inside}
SINGLES: dict[str, Callable[[DistanceShape], Expression]] = {"top": top, "bottom": bottom, "radius": radius}
