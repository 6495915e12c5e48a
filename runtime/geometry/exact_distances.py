"""Exact signed distances of convex shapes in batches: value, normal, and the points that are nearest to each other.

Between round shapes (spheres and capsules), and of these to boxes, by closed forms; between all others by coal. Not
measured are those so far apart that spheres around them, and boxes, say enough. Overlaps are negative; of a capsule
that passes through a box the depth is that of its axis, which is none too great.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
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
ROUNDS, BOXED, TURNED, SLOW = range(4)
"""Pairs: of round shapes, of one and a box, of a box and one, and those that coal measures."""
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
        rows = np.array([_numbers(shape) for shape in self.shapes], dtype=float).reshape(-1, 6)
        self.kind = rows[:, 0].astype(np.intp)
        self.half, self.radius, self.reach = rows[:, 1:4], rows[:, 4], rows[:, 5]

    def __len__(self) -> int:
        return len(self.shapes)

    def joined(self, other: Forms) -> Forms:
        """These, then the others."""
        both = Forms(())
        both.shapes = [*self.shapes, *other.shapes]
        both.kind, both.half = np.concatenate([self.kind, other.kind]), np.concatenate([self.half, other.half])
        both.radius, both.reach = np.concatenate([self.radius, other.radius]), np.concatenate([self.reach, other.reach])
        return both


@lru_cache(maxsize=4096)
def _numbers(shape: Shape) -> tuple[float, ...]:
    """The kind, half of the sizes, the radius and the reach of a shape."""
    reach = bounding_radius(shape)
    if shape.kind == ShapeKind.BOX:
        return BOX, *(s / 2 for s in shape.size), 0.0, reach
    if shape.kind in (ShapeKind.SPHERE, ShapeKind.CAPSULE):
        return ROUND, 0.0, 0.0, shape.size[1] / 2 if shape.kind == ShapeKind.CAPSULE else 0.0, shape.size[0], reach
    return HULL, 0.0, 0.0, 0.0, 0.0, reach


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


class Pairing:
    """N pairs of shapes, wherever these are: what is the same for all their poses."""

    def __init__(self, first: Posed, second: Posed) -> None:
        one, two = first.kind, second.kind
        self._reach, self._boxes = (first.reach, second.reach), (one == BOX, two == BOX)
        self._some = bool(self._boxes[0].any()), bool(self._boxes[1].any())
        kinds = [ROUNDS, BOXED, TURNED]
        cases = [(one == ROUND) & (two == ROUND), (one == ROUND) & (two == BOX), (one == BOX) & (two == ROUND)]
        self._kind = np.select(cases, kinds, SLOW)

    def distances(self, first: Posed, second: Posed, beyond: Array) -> Distances:
        """Their distances; of pairs that are surely farther apart than `beyond` `(N,)` metres a lower bound."""
        apart = first.position - second.position
        length = _length(apart)
        value = length - self._reach[0] - self._reach[1]
        near = (value <= beyond).nonzero()[0]
        ends = first.position.copy(), second.position.copy()
        found = Distances(value, np.zeros_like(apart), *ends, np.zeros(len(value), bool))
        for side, (box, seen) in enumerate(((first, second), (second, first))):
            boxes = near[self._boxes[side][near]] if self._some[side] else near[:0]
            if len(boxes):
                local = box[boxes].local(seen.position[boxes])
                excess = np.maximum(np.abs(local) - box.forms.half[box.form[boxes]], 0.0)
                value[boxes] = np.maximum(value[boxes], _length(excess) - self._reach[1 - side][boxes])
        near = near[value[near] <= beyond[near]]
        kinds = self._kind[near]
        for kind in sorted(set(kinds.tolist())):
            at = near[kinds == kind]
            if kind == SLOW:
                found.normal[at] = apart[at] / np.maximum(length[at], TINY)[:, None]
                _by_coal(found, at, first, second)
            elif kind == TURNED:
                _put(found, at, _to_box(second[at], first[at]), True)
            else:
                _put(found, at, (_to_box if kind == BOXED else _round)(first[at], second[at]))
        return found


def distances(first: Posed, second: Posed, beyond: Array) -> Distances:
    """The distances of N pairs; of pairs that are surely farther apart than `beyond` `(N,)` metres a lower bound."""
    return Pairing(first, second).distances(first, second, beyond)


def _put(found: Distances, at: Indices, part: Array, turned: bool = False) -> None:
    """Enter results of `axis_distances`."""
    found.value[at], found.exact[at] = part[:, 0], True
    found.normal[at] = -part[:, 1:4] if turned else part[:, 1:4]
    one, other = (found.on_second, found.on_first) if turned else (found.on_first, found.on_second)
    one[at], other[at] = part[:, 4:7], part[:, 7:10]


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _length(a: Array) -> Array:
    return np.sqrt(_dot(a, a))


def _round(first: Posed, second: Posed) -> Array:
    """Of round shapes, on their axes."""
    from .axis_distances import evaluated, round_stage

    given = np.concatenate([first.position, first.axis, second.position, second.axis], axis=1)
    return evaluated(round_stage(), given, (first.radius + second.radius)[:, None])


def _to_box(round_: Posed, box: Posed) -> Array:
    """Of round shapes, on their axes, to boxes."""
    from .axis_distances import COLUMNS, box_stage, evaluated

    turn, sizes = box.rotation.reshape(-1, 9), np.concatenate([box.half, round_.radius[:, None]], axis=1)
    found = evaluated(box_stage(), np.concatenate([round_.position, round_.axis, box.position, turn], axis=1), sizes)
    deep = (found[:, 10] < WITHIN).nonzero()[0]
    if len(deep):
        depth, *ends = _within_box(round_[deep], box[deep])
        found[deep, 0] = depth - sizes[deep, 3]
        for columns, values in zip(COLUMNS, ends, strict=True):
            found[deep, columns] = values
    return found


def _within_box(round_: Posed, box: Posed) -> tuple[Array, Array, Array, Array]:
    """Of axes that go through boxes: how far they are from being outside `(N,)`, less than 0, the normals and the
    nearest points."""
    half, axis = box.half, round_.axis
    start, way = box.local(round_.position - axis), 2.0 * (axis[:, None, :] @ box.rotation)[:, 0]
    point = start + _deepest(start, way, half)[:, None] * way
    excess, rows = np.abs(point) - half, np.arange(len(half))
    side = excess.argmax(axis=1)
    normal, nearest = np.zeros_like(point), point.copy()
    normal[rows, side] = np.where(point[rows, side] < 0.0, -1.0, 1.0)
    nearest[rows, side] = normal[rows, side] * half[rows, side]
    seen = np.stack([normal, point, nearest], axis=1) @ box.rotation.transpose(0, 2, 1)
    return excess[rows, side], seen[:, 0], seen[:, 1] + box.position, seen[:, 2] + box.position


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
