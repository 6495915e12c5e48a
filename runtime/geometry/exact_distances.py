"""Exact signed distances of convex shapes in batches: value, normal, and the points that are nearest to each other.

Between round shapes (spheres and capsules), and of these to boxes, by closed forms; between all others by coal. Not
measured are those so far apart that spheres around them, and boxes, say enough. Overlaps are negative; of a capsule
that passes through a box the depth is that of its axis, which is none too great.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...compiler.hulls import convex_geometry
from ...compiler.ir import Shape, ShapeKind
from ...compiler.motion.collision import bounding_radius
from ...langs.frozen import dataclass
from ..native import load_coal
from ..skeleton import Array
from .transforms import rotate

Indices = NDArray[np.intp]
ROUND, BOX, HULL = range(3)
TINY = 1e-12
WITHIN = 1e-9
"""Metres: an axis that comes nearer to a box goes through it."""
GRID, ROUNDS = np.linspace(-0.5, 0.5, 17), 4
"""Where along an axis its deepest point is looked for, and how often, ever nearer."""
THINNEST = 1e-6
"""Metres: coal is given nothing thinner."""


@cache
def coal_geometry(shape: Shape) -> Any:
    """A shape for coal. Raises MissingLibrary."""
    coal = load_coal()
    if shape.kind == ShapeKind.CONVEX:
        return convex_geometry(shape)
    makers = {ShapeKind.BOX: coal.Box, ShapeKind.SPHERE: coal.Sphere,
              ShapeKind.CAPSULE: coal.Capsule, ShapeKind.CYLINDER: coal.Cylinder}  # fmt: skip
    return makers[shape.kind](*(max(s, THINNEST) for s in shape.size))


class Forms:
    """Different shapes as numbers: `kind` `(S,)`; `half` `(S, 3)`, half the sizes of a box, of a round shape half its
    axis along z; the `radius` `(S,)` by which that grows; `reach` `(S,)` of the sphere around the centre."""

    def __init__(self, shapes: Sequence[Shape]) -> None:
        self.shapes = list(shapes)
        self.kind = np.full(len(shapes), HULL, dtype=np.intp)
        self.half = np.zeros((len(shapes), 3))
        self.radius = np.zeros(len(shapes))
        self.reach = np.array([bounding_radius(s) for s in shapes], dtype=float)
        for k, shape in enumerate(shapes):
            if shape.kind == ShapeKind.BOX:
                self.kind[k], self.half[k] = BOX, [s / 2 for s in shape.size]
            elif shape.kind in (ShapeKind.SPHERE, ShapeKind.CAPSULE):
                self.kind[k], self.radius[k] = ROUND, shape.size[0]
                self.half[k, 2] = shape.size[1] / 2 if shape.kind == ShapeKind.CAPSULE else 0.0

    def __len__(self) -> int:
        return len(self.shapes)

    def joined(self, other: Forms) -> Forms:
        """These, then the others."""
        both = Forms(())
        both.shapes = [*self.shapes, *other.shapes]
        both.kind, both.half = np.concatenate([self.kind, other.kind]), np.concatenate([self.half, other.half])
        both.radius, both.reach = np.concatenate([self.radius, other.radius]), np.concatenate([self.reach, other.reach])
        return both


@dataclass(frozen=True, slots=True)
class Posed:
    """N shapes `form` `(N,)` of `forms` with their centres `(N, 3)` and rotations `(N, 3, 3)` in the world; of round
    shapes only the z-axis counts."""

    forms: Forms
    form: Indices
    position: Array
    rotation: Array

    def __getitem__(self, chosen: Indices) -> Posed:
        return Posed(self.forms, self.form[chosen], self.position[chosen], self.rotation[chosen])

    @property
    def kind(self) -> Indices:
        return np.asarray(self.forms.kind[self.form])

    @property
    def half(self) -> Array:
        return np.asarray(self.forms.half[self.form])

    @property
    def radius(self) -> Array:
        return np.asarray(self.forms.radius[self.form])

    def frames(self) -> Array:
        """The rotations (N, 3, 3), in full for round shapes too (Duff et al., Building an Orthonormal Basis, Revisited,
        2017). Of those that know no axis, any."""
        x, y, z = (self.rotation[:, row, 2] for row in range(3))
        z = np.where((x == 0.0) & (y == 0.0) & (z == 0.0), 1.0, z)
        sign = np.copysign(1.0, z)
        a = -1.0 / (sign + z)
        full = np.stack([
            1.0 + sign * x * x * a, x * y * a, x,
            sign * x * y * a, sign + y * y * a, y,
            -sign * x, -y, z,
        ], axis=1).reshape(-1, 3, 3)  # fmt: skip
        return np.where((self.kind == ROUND)[:, None, None], full, self.rotation)

    @property
    def reach(self) -> Array:
        return np.asarray(self.forms.reach[self.form])

    @property
    def axis(self) -> Array:
        """From the centre to the end of the axis `(N, 3)` of round shapes."""
        return np.asarray(self.rotation[:, :, 2] * self.half[:, 2:])

    def local(self, points: Array) -> Array:
        """Points `(N, 3)` of the world in the frames of the shapes."""
        return np.asarray(((points - self.position)[:, None, :] @ self.rotation)[:, 0])


def posed_at(forms: Forms, form: int, poses: Array) -> Posed:
    """One of the shapes at poses `(N, 7)`."""
    turned = rotate(poses[:, None, 3:], np.eye(3)[None]).transpose(0, 2, 1)
    return Posed(forms, np.full(len(poses), form), poses[:, :3], turned)


@dataclass(frozen=True, slots=True)
class Distances:
    """Signed distances `(N,)` in metres; unit normals `(N, 3)` from the second shapes to the first ones; the points
    `(N, 3)` in the world that are nearest to each other, of round shapes on their axes. `exact` `(N,)`: no bound."""

    value: Array
    normal: Array
    on_first: Array
    on_second: Array
    exact: NDArray[np.bool_]

    def part(self, chosen: slice) -> Distances:
        """Those of some pairs."""
        return Distances(
            self.value[chosen], self.normal[chosen], self.on_first[chosen], self.on_second[chosen], self.exact[chosen]
        )


def distances(first: Posed, second: Posed, beyond: Array) -> Distances:
    """The distances of N pairs; of pairs that are surely farther apart than `beyond` `(N,)` metres a lower bound."""
    apart = first.position - second.position
    length = _length(apart)
    reach, other = first.reach, second.reach
    value = length - reach - other
    near = np.flatnonzero(value <= beyond)
    for box, seen, ball in ((second, first, reach), (first, second, other)):
        boxes = near[box.forms.kind[box.form[near]] == BOX]
        if len(boxes):
            half = box.forms.half[box.form[boxes]]
            away = seen.position[boxes] - box.position[boxes]
            excess = np.abs((away[:, None, :] @ box.rotation[boxes])[:, 0]) - half
            value[boxes] = np.maximum(value[boxes], _length(np.maximum(excess, 0.0)) - ball[boxes])
    near = near[value[near] <= beyond[near]]
    found = Distances(value, np.zeros_like(apart), first.position, second.position, np.zeros(len(value), bool))
    if not len(near):
        return found
    found = Distances(value, found.normal, first.position.copy(), second.position.copy(), found.exact)
    one, two = first.forms.kind[first.form[near]], second.forms.kind[second.form[near]]
    for chosen, turned in ((near[(one == ROUND) & (two == ROUND)], None), (near[(one == ROUND) & (two == BOX)], False),
                           (near[(one == BOX) & (two == ROUND)], True)):  # fmt: skip
        if len(chosen):
            a, b = first[chosen], second[chosen]
            part = _round(a, b) if turned is None else _to_box(b, a) if turned else _to_box(a, b)
            _put(found, chosen, part, bool(turned))
    rest = near[(one == HULL) | (two == HULL) | ((one == BOX) & (two == BOX))]
    if len(rest):
        found.normal[rest] = apart[rest] / np.maximum(length[rest], TINY)[:, None]
        _by_coal(found, rest, first, second)
    return found


def _put(found: Distances, at: Indices, part: Distances, turned: bool = False) -> None:
    found.value[at], found.exact[at] = part.value, part.exact
    found.normal[at] = -part.normal if turned else part.normal
    found.on_first[at], found.on_second[at] = (
        (part.on_second, part.on_first) if turned else (part.on_first, part.on_second)
    )


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _length(a: Array) -> Array:
    return np.sqrt(_dot(a, a))


def _round(first: Posed, second: Posed) -> Distances:
    """Of the axes of round shapes (Ericson, Real-Time Collision Detection, section 5.1.9), less both radii."""
    u, v = 2.0 * first.axis, 2.0 * second.axis
    start, other = first.position - 0.5 * u, second.position - 0.5 * v
    way = start - other
    uu, vv, uv, uw, vw = _dot(u, u), _dot(v, v), _dot(u, v), _dot(u, way), _dot(v, way)
    across = uu * vv - uv * uv
    s = np.where(across > TINY * uu * vv + TINY, (uv * vw - uw * vv) / np.maximum(across, TINY), 0.5)
    s = np.clip(s, 0.0, 1.0)
    t = np.where(vv > TINY, (uv * s + vw) / np.maximum(vv, TINY), 0.0)
    beyond = (t < 0.0) | (t > 1.0)
    t = np.clip(t, 0.0, 1.0)
    s = np.where(beyond | (vv <= TINY), np.clip((uv * t - uw) / np.maximum(uu, TINY), 0.0, 1.0), s)
    p, q = start + s[:, None] * u, other + t[:, None] * v
    apart = p - q
    length = _length(apart)
    normal = np.where(length[:, None] > TINY, apart / np.maximum(length, TINY)[:, None], (0.0, 0.0, 1.0))
    return Distances(length - first.radius - second.radius, normal, p, q, np.ones(len(p), bool))


def _to_box(round_: Posed, box: Posed) -> Distances:
    """Of the axes of round shapes to boxes, less their radii. The slope of half the squared distance along an axis is
    piecewise linear and grows: it is zero between two of the places where the axis passes a plane of the box."""
    half, axis = box.half, round_.axis
    start = box.local(round_.position - axis)
    way = 2.0 * (axis[:, None, :] @ box.rotation)[:, 0]
    share = np.zeros(len(start))
    long = np.flatnonzero(np.abs(way).max(axis=1) > TINY)
    if len(long):
        share[long] = _nearest(start[long], way[long], half[long])
    point = start + share[:, None] * way
    clamped = np.clip(point, -half, half)
    apart = point - clamped
    length = _length(apart)
    normal = apart / np.maximum(length, TINY)[:, None]
    deep = np.flatnonzero(length < WITHIN)
    if len(deep):
        share[deep] = _deepest(start[deep], way[deep], half[deep])
        point[deep] = start[deep] + share[deep, None] * way[deep]
        excess = np.abs(point[deep]) - half[deep]
        side = excess.argmax(axis=1)
        rows = np.arange(len(deep))
        length[deep], normal[deep] = excess[rows, side], 0.0
        sign = np.where(point[deep, side] < 0.0, -1.0, 1.0)
        normal[deep, side] = sign
        clamped[deep] = point[deep]
        clamped[deep, side] = sign * half[deep, side]
    turn = box.rotation.transpose(0, 2, 1)
    outward, p, q = ((local[:, None, :] @ turn)[:, 0] for local in (normal, point, clamped))
    value = length - round_.radius
    return Distances(value, outward, p + box.position, q + box.position, np.ones(len(p), bool))


def _nearest(start: Array, way: Array, half: Array) -> Array:
    """The shares `(N,)` of ways at which points are nearest to boxes around the origin; where there are many, the
    middle of these."""
    safe = np.where(np.abs(way) > TINY, way, TINY)
    planes = np.concatenate([(half - start) / safe, (-half - start) / safe], axis=1)
    shares = np.concatenate([planes, np.zeros((len(way), 1)), np.ones((len(way), 1))], axis=1)
    shares = np.sort(np.clip(shares, 0.0, 1.0), axis=1)
    points = start[:, None] + shares[:, :, None] * way[:, None]
    excess = points - np.clip(points, -half[:, None], half[:, None])
    slope = (excess * way[:, None]).sum(axis=2)
    level = 1e-10 * (way * way).sum(axis=1, keepdims=True)
    return 0.5 * (_crossing(shares, slope, -level) + _crossing(shares, slope, level))


def _crossing(shares: Array, slope: Array, level: Array) -> Array:
    """Where slopes `(N, 8)` that grow pass a level `(N, 1)`: the first share, the last, or between two."""
    after = (slope < level).sum(axis=1)
    rows = np.arange(len(shares))
    low, high = np.maximum(after - 1, 0), np.minimum(after, shares.shape[1] - 1)
    rise = slope[rows, high] - slope[rows, low]
    part = np.where(rise > 0.0, (level[:, 0] - slope[rows, low]) / np.where(rise > 0.0, rise, 1.0), 0.0)
    return np.asarray(shares[rows, low] + np.clip(part, 0.0, 1.0) * (shares[rows, high] - shares[rows, low]))


def _deepest(start: Array, way: Array, half: Array) -> Array:
    """The shares `(N,)` of ways at which points are deepest in boxes: their depth is concave along a line."""
    middle, width = np.full(len(start), 0.5), 1.0
    for _ in range(ROUNDS):
        shares = np.clip(middle[:, None] + width * GRID, 0.0, 1.0)
        points = start[:, None] + shares[:, :, None] * way[:, None]
        best = (np.abs(points) - half[:, None]).max(axis=2).argmin(axis=1)
        middle, width = shares[np.arange(len(shares)), best], width / 8.0
    return middle


def _by_coal(found: Distances, pairs: Indices, first: Posed, second: Posed) -> None:
    """Measure some pairs. Where coal knows no number, as it sometimes does deep within, the bound stays."""
    coal = load_coal()
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    sides = [(side.forms.shapes, side.form.tolist(), side.frames(), side.position, side.radius)
             for side in (first[pairs], second[pairs])]  # fmt: skip
    for i, k in enumerate(pairs.tolist()):
        one, other = (
            (coal_geometry(shapes[form[i]]), coal.Transform3s(rotation[i], position[i]))
            for shapes, form, rotation, position, _ in sides
        )
        result = coal.DistanceResult()
        value = coal.distance(*one, *other, request, result)
        if np.isfinite(value) and np.isfinite(result.normal).all():
            normal = -result.normal
            found.value[k], found.normal[k], found.exact[k] = value, normal, True
            found.on_first[k] = result.getNearestPoint1() + sides[0][4][i] * normal
            found.on_second[k] = result.getNearestPoint2() - sides[1][4][i] * normal
