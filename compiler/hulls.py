"""Convex bodies as corners and planes. A shape of kind "convex" lists the corners of its hull, three numbers each, in
metres; its frame is at the middle of the box around it, along its axes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..langs.frozen import dataclass
from .apart import apart
from .ir import Shape, ShapeKind, Vec3

Array = NDArray[np.float64]

MOST_CORNERS = 100
"""A hull with more corners is replaced by a simpler one around it."""
THIN = 1e-6
"""Metres: no body is thinner."""
SLICE = 0.02
MOST_SLICES = 16
"""How thick the slices are that a body is cut into, metres, and how many there are at most."""
LONG = 5000
"""Points whose hull takes a twentieth of a second: those of more are made apart."""
SAME = 1e-7
"""Planes whose normals and offsets differ by less are one."""


class HullError(Exception):
    """The points have no hull: they are too few, lie in a plane, or are not finite."""


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """`corners` (N, 3); `triangles` (T, 3) of them, counter-clockwise from outside; faces by outward unit `normals`
    (F, 3) and `offsets` (F,): a point x is inside where normals · x <= offsets. `volume` in cubic metres, `sides` of
    the box around it (3,)."""

    corners: Array
    triangles: NDArray[np.int64]
    normals: Array
    offsets: Array
    volume: float
    sides: Array

    @property
    def radius(self) -> float:
        """Of the sphere around the frame's origin that holds the body."""
        return float(np.linalg.norm(self.corners, axis=1).max())

    def distance(self, points: Array) -> Array:
        """How far points (…, 3) lie beyond the farthest plane: exact inside, a lower bound outside."""
        return np.asarray((points @ self.normals.T - self.offsets).max(axis=-1))


def convex_shape(points: ArrayLike) -> tuple[Shape, Vec3, bool]:
    """The hull of points (M, 3) as a shape, where its frame lies among them, and whether it had to be made simpler,
    which makes it larger. Raises HullError."""
    cloud = np.asarray(points, dtype=float).reshape(-1, 3)
    if len(cloud) < 4:
        raise HullError(f"a body has at least four corners, not {len(cloud)}")
    if not np.isfinite(cloud).all():
        raise HullError("a corner is not finite")
    corners = _corners(cloud)
    simpler = len(corners) > MOST_CORNERS
    if simpler:
        corners = _around(corners)
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    x, y, z = (float(v) for v in middle)
    return Shape(ShapeKind.CONVEX, tuple(float(v) for v in (corners - middle).ravel())), (x, y, z), simpler


@lru_cache(maxsize=1024)
def hull(shape: Shape) -> Hull:
    """The geometry of a shape of kind "convex"."""
    from scipy.spatial import ConvexHull

    corners = np.array(shape.size).reshape(-1, 3)
    made = ConvexHull(corners)
    planes = _distinct(made.equations)
    triangles = _outward(corners, made.simplices, made.equations)
    return Hull(corners, triangles, planes[:, :3], -planes[:, 3], float(made.volume), np.ptp(corners, axis=0))


@lru_cache(maxsize=256)
def slices(shape: Shape) -> tuple[tuple[Vec3, Vec3], ...]:
    """Boxes, as centres and half sizes, that cover a convex shape: one around each of its level slices."""
    body = hull(shape)
    height = float(body.sides[2])
    count = min(MOST_SLICES, max(1, math.ceil(height / SLICE)))
    levels = np.linspace(-height / 2, height / 2, count + 1)
    cuts = [_cut(body, level) for level in levels]
    found = []
    for low, high, one, other in zip(levels, levels[1:], cuts, cuts[1:], strict=False):
        between = body.corners[(body.corners[:, 2] >= low - THIN) & (body.corners[:, 2] <= high + THIN)]
        points = np.concatenate([one, other, between])
        x, y, z = ((points.min(axis=0) + points.max(axis=0)) / 2).tolist()
        a, b, c = (np.ptp(points, axis=0) / 2).tolist()
        found.append(((x, y, z), (a, b, c)))
    return tuple(found)


def _cut(body: Hull, level: float) -> Array:
    """Where the edges of a body cross a height (K, 3)."""
    ends = body.corners[np.concatenate([body.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])]
    low, high = ends[:, 0], ends[:, 1]
    crossing = (low[:, 2] - level) * (high[:, 2] - level) < 0
    low, high = low[crossing], high[crossing]
    share = (level - low[:, 2]) / (high[:, 2] - low[:, 2])
    return np.asarray(low + share[:, None] * (high - low))


def convex_geometry(shape: Shape) -> Any:
    """A shape of kind "convex" for coal."""
    import coal

    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for corner in hull(shape).corners:
        points.append(corner)
    for a, b, c in hull(shape).triangles.tolist():
        triangles.append(coal.Triangle(a, b, c))
    return coal.Convex(points, triangles)


def top_outline(shape: Shape) -> Array:
    """The corners (K, 2) of the flat top of a convex body that lies in its own axes, counter-clockwise; none where its
    top is an edge or a point."""
    from scipy.spatial import ConvexHull

    corners = hull(shape).corners
    top = corners[corners[:, 2] > corners[:, 2].max() - THIN][:, :2]
    if len(top) < 3 or np.linalg.matrix_rank(top[1:] - top[0], tol=THIN) < 2:
        return np.zeros((0, 2))
    return np.asarray(top[ConvexHull(top).vertices])


def top_edges(shape: Shape) -> tuple[Array, Array]:
    """The edges of the flat top: outward normals (K, 2) and offsets (K,); (0, 2) and (0,) without one."""
    outline = top_outline(shape)
    along = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack([along[:, 1], -along[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("ij,ij->i", normals, outline)


def corners_of(points: Array) -> Array:
    """The corners of the hull of points (M, 3); all of them where there is none."""
    made = _made(points)
    return points if made is None else np.asarray(points[made[0]])


def _made(points: Array) -> tuple[NDArray[np.intp], float] | None:
    """The numbers of the corners of the hull of points (M, 3), in order, and its volume; None where there is none."""
    return apart(partial(_hull_of, points)) if len(points) > LONG else _hull_of(points)


def _hull_of(points: Array) -> tuple[NDArray[np.intp], float] | None:
    from scipy.spatial import ConvexHull, QhullError

    try:
        made = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    return np.sort(made.vertices), float(made.volume)


def _corners(points: Array) -> Array:
    made = _made(points)
    if made is None or np.ptp(points, axis=0).min() < THIN:
        raise HullError("the corners lie in a plane")
    return np.asarray(points[made[0]])


def _outward(corners: Array, triangles: NDArray[np.int32], planes: Array) -> NDArray[np.int64]:
    """The triangles with their corners in the order that makes them look outward."""
    a, b, c = (corners[triangles[:, i]] for i in range(3))
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), planes[:, :3]) < 0
    return np.where(turned[:, None], triangles[:, [0, 2, 1]], triangles).astype(np.int64)


def _distinct(planes: Array) -> Array:
    """The planes without repetitions, in the order of their first."""
    kept: list[Array] = []
    for plane in planes:
        if not any(np.abs(plane - other).max() < SAME for other in kept):
            kept.append(plane)
    return np.array(kept)


def _around(corners: Array) -> Array:
    return _body(lambda normals: np.asarray((corners @ normals.T).max(axis=0)), corners.mean(axis=0))


def corners_around(shape: Shape) -> Array:
    """Corners (N, 3) of a shape, or of a body around a round one, in its own frame."""
    if shape.kind == ShapeKind.CONVEX:
        return hull(shape).corners
    if shape.kind == ShapeKind.BOX:
        return np.array(list(itertools.product(*((-s / 2, s / 2) for s in shape.size))))
    radius, half = shape.size[0], shape.size[1] / 2 if len(shape.size) > 1 else 0.0

    def reach(normals: Array) -> Array:
        across = np.hypot(normals[:, 0], normals[:, 1]) if shape.kind == ShapeKind.CYLINDER else 1.0
        return np.asarray(half * np.abs(normals[:, 2]) + radius * across)

    return _body(reach, np.zeros(3))


def _body(reach: Callable[[Array], Array], inner: Array) -> Array:
    """The corners of a body around the point `inner` whose faces look in the 26 directions of a cube's faces, edges and
    corners; `reach` tells how far they lie from the origin along those (26, 3)."""
    from scipy.spatial import HalfspaceIntersection

    steps = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3)).reshape(3, -1).T
    normals = steps[np.linalg.norm(steps, axis=1) > 0]
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    made = HalfspaceIntersection(np.column_stack([normals, -reach(normals)]), inner)
    return _corners(np.unique(made.intersections.round(9), axis=0))
