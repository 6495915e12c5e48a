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

from ...compiler.distinct import distinct
from ...compiler.hulls import convex_geometry
from ...compiler.ir import Shape, ShapeKind
from ...compiler.motion.collision import bounding_radius
from ...langs.frozen import dataclass
from ..native import load_coal
from ..skeleton import Array
from .transforms import rotate

Indices = NDArray[np.intp]
ROUND, BOX, HULL = range(3)
PAIRS_ROUND, PAIRS_BOXED, PAIRS_SLOW = range(3)
"""Pairs: of round shapes, of one and a box, and those that coal measures."""
TINY = 1e-12
WITHIN = 1e-9
"""Metres: an axis that comes nearer to a box goes through it."""
SIDES = np.triu_indices(6, 1)
"""Every two sides of a box."""
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
    """N pairs of shapes among those of a table, wherever these are: what is the same for all their poses."""

    def __init__(self, forms: Forms, form: Indices, first: Indices, second: Indices) -> None:
        """The table holds shapes `form` `(Q,)` of `forms`; `first` and `second` `(N,)` are places in it."""
        self._forms, self._form, self._first, self._second = forms, form, first, second
        one, two = forms.kind[form[first]], forms.kind[form[second]]
        self._apart = forms.reach[form[first]] + forms.reach[form[second]]
        self._boxes = [
            (is_box, box, forms.half[form[box]], forms.reach[form[other]])
            for is_box, box, other in ((one == BOX, first, second), (two == BOX, second, first)) if is_box.any()
        ]  # fmt: skip
        cases = [(one == ROUND) & (two == ROUND), (one == ROUND) & (two == BOX), (one == BOX) & (two == ROUND)]
        self._turned = cases[2]
        self._kind = np.select(cases, [PAIRS_ROUND, PAIRS_BOXED, PAIRS_BOXED], PAIRS_SLOW)
        self._kinds = distinct(self._kind).tolist()
        self._rounds = np.where(cases[2], second, first), np.where(cases[2], first, second)
        both = forms.radius[form[first]] + forms.radius[form[second]]
        self._sizes = np.concatenate([forms.half[form[self._rounds[1]]], both[:, None]], axis=1)
        self._along = forms.half[form, 2:]

    def distances(self, position: Array, rotation: Array, beyond: Array) -> Distances:
        """Their distances where the shapes of the table have these centres `(Q, 3)` and rotations `(Q, 3, 3)`; of
        pairs that are surely farther apart than `beyond` `(N,)` metres a lower bound."""
        found = np.zeros((len(self._first), 10))
        ends = found[:, 4:7], found[:, 7:10]
        ends[0][:], ends[1][:] = position[self._first], position[self._second]
        apart = ends[0] - ends[1]
        length = _length(apart)
        value = length - self._apart
        near = (value <= beyond).nonzero()[0]
        for is_box, box, half, reach in self._boxes:
            boxes = near[is_box[near]]
            if len(boxes):
                local = (apart[boxes][:, None, :] @ rotation[box[boxes]])[:, 0]
                excess = np.maximum(np.abs(local) - half[boxes], 0.0)
                value[boxes] = np.maximum(value[boxes], _length(excess) - reach[boxes])
        near = near[value[near] <= beyond[near]]
        found[:, 0] = value
        exact = np.zeros(len(value), bool)
        kinds = self._kind[near]
        for kind in self._kinds:
            at = near[kinds == kind] if len(self._kinds) > 1 else near
            if not len(at):
                continue
            exact[at] = True
            if kind == PAIRS_ROUND:
                found[at] = self._round(at, position, rotation)
            elif kind == PAIRS_BOXED:
                found[at] = self._boxed(at, position, rotation)
            else:
                found[at, 1:4] = apart[at] / np.maximum(length[at], TINY)[:, None]
                tabled = Posed(self._forms, self._form, position, rotation)
                exact[at] = _by_coal(found, at, tabled[self._first[at]], tabled[self._second[at]])
        return Distances(found[:, 0], found[:, 1:4], *ends, exact)

    def _axes(self, at: Indices, position: Array, rotation: Array) -> list[Array]:
        """The centres and half axes of round shapes."""
        return [position[at], rotation[at, :, 2] * self._along[at]]

    def _round(self, at: Indices, position: Array, rotation: Array) -> Array:
        """Of round shapes, on their axes."""
        from .axis_distances import evaluated, round_stage

        sides = (self._axes(side[at], position, rotation) for side in (self._first, self._second))
        return evaluated(round_stage(), np.concatenate([*next(sides), *next(sides)], axis=1), self._sizes[at, 3:])

    def _boxed(self, at: Indices, position: Array, rotation: Array) -> Array:
        """Of round shapes, on their axes, and boxes, whichever comes first."""
        from .axis_distances import COLUMNS, box_stage, evaluated

        round_, box = (side[at] for side in self._rounds)
        sizes, turned = self._sizes[at], self._turned[at]
        axes = self._axes(round_, position, rotation)
        given = np.concatenate([*axes, position[box], rotation[box].reshape(-1, 9)], axis=1)
        found = evaluated(box_stage(), given, sizes)
        deep = (found[:, 10] < WITHIN).nonzero()[0]
        if len(deep):
            depth, *ends = _within_box(given[deep], sizes[deep, :3])
            found[deep, 0] = depth - sizes[deep, 3]
            for columns, values in zip(COLUMNS, ends, strict=True):
                found[deep, columns] = values
        if turned.any():
            normal, one, other = (found[turned, columns] for columns in COLUMNS)
            for columns, values in zip(COLUMNS, (-normal, other, one), strict=True):
                found[turned, columns] = values
        return found[:, :10]


def distances(first: Posed, second: Posed, beyond: Array) -> Distances:
    """The distances of N pairs; of pairs that are surely farther apart than `beyond` `(N,)` metres a lower bound."""
    forms, more = first.forms, 0
    if second.forms is not forms:
        forms, more = forms.joined(second.forms), len(forms)
    numbers = np.arange(len(first.form))
    form = np.concatenate([first.form, second.form + more])
    position = np.concatenate([first.position, second.position])
    rotation = np.concatenate([first.rotation, second.rotation])
    return Pairing(forms, form, numbers, numbers + len(numbers)).distances(position, rotation, beyond)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))


def _length(a: Array) -> Array:
    return np.sqrt(_dot(a, a))


def _within_box(given: Array, half: Array) -> tuple[Array, Array, Array, Array]:
    """Of axes that go through boxes, as `box_stage` is given them `(N, 18)`, with half the sides `(N, 3)`: how far they
    are from being outside `(N,)`, less than 0, the normals and the nearest points."""
    axis, position, rotation = given[:, 3:6], given[:, 6:9], given[:, 9:].reshape(-1, 3, 3)
    start = ((given[:, :3] - axis - position)[:, None, :] @ rotation)[:, 0]
    way = 2.0 * (axis[:, None, :] @ rotation)[:, 0]
    point = start + _deepest(start, way, half)[:, None] * way
    excess, rows = np.abs(point) - half, np.arange(len(half))
    side = excess.argmax(axis=1)
    normal, nearest = np.zeros_like(point), point.copy()
    normal[rows, side] = np.where(point[rows, side] < 0.0, -1.0, 1.0)
    nearest[rows, side] = normal[rows, side] * half[rows, side]
    seen = np.stack([normal, point, nearest], axis=1) @ rotation.transpose(0, 2, 1)
    return excess[rows, side], seen[:, 0], seen[:, 1] + position, seen[:, 2] + position


def _deepest(start: Array, way: Array, half: Array) -> Array:
    """The shares `(N,)` of ways at which points are deepest in boxes: at an end, or where they are as far from two
    sides, as their depth is the least of six distances that change evenly."""
    depth = np.concatenate([half - start, half + start], axis=1)
    change = np.concatenate([-way, way], axis=1)
    faster = change[:, SIDES[0]] - change[:, SIDES[1]]
    apart = depth[:, SIDES[1]] - depth[:, SIDES[0]]
    shares = np.zeros((len(start), len(SIDES[0]) + 2))
    shares[:, 1] = 1.0
    np.divide(apart, faster, out=shares[:, 2:], where=faster != 0.0)
    np.clip(shares, 0.0, 1.0, out=shares)
    best = (depth[:, None] + shares[:, :, None] * change[:, None]).min(axis=2).argmax(axis=1)
    return np.asarray(shares[np.arange(len(start)), best])


def _by_coal(found: Array, pairs: Indices, first: Posed, second: Posed) -> NDArray[np.bool_]:
    """Measure some pairs, and say which: where coal knows no number, as it sometimes does deep within, the bound
    stays."""
    coal = load_coal()
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    sides = [(side.forms.shapes, side.form.tolist(), side.frames(), side.position, side.radius)
             for side in (first, second)]  # fmt: skip
    known = np.zeros(len(pairs), bool)
    for i, k in enumerate(pairs.tolist()):
        one, other = (
            (coal_geometry(shapes[form[i]]), coal.Transform3s(rotation[i], position[i]))
            for shapes, form, rotation, position, _ in sides
        )
        result = coal.DistanceResult()
        value = coal.distance(*one, *other, request, result)
        if np.isfinite(value) and np.isfinite(result.normal).all():
            normal = -result.normal
            known[i] = True
            found[k, 0], found[k, 1:4] = value, normal
            found[k, 4:7] = result.getNearestPoint1() + sides[0][4][i] * normal
            found[k, 7:10] = result.getNearestPoint2() - sides[1][4][i] * normal
    return known
