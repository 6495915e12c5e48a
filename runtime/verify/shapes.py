"""Shapes as coal geometries, their sizes, and how high they reach. Sizes in metres; see `ir.Shape`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...compiler.ir import ShapeKind
from ..native import load_coal
from .geometry import Array

SIZES: Mapping[str, int] = {ShapeKind.BOX: 3, ShapeKind.SPHERE: 1, ShapeKind.CAPSULE: 2, ShapeKind.CYLINDER: 2}
"""How many numbers describe each kind of shape; a convex one has three for each of its corners."""
FLAT = 1e-6
"""Metres by which the corners of a flat top may differ in height."""


def corners(size: Sequence[float]) -> Array:
    """The corners `(N, 3)` of a convex shape."""
    return np.asarray(size, dtype=float).reshape(-1, 3)


def is_solid(size: Sequence[float]) -> bool:
    """Whether the corners of a convex shape are at least four and do not lie in a plane."""
    points = corners(size)
    return len(points) >= 4 and int(np.linalg.matrix_rank(points - points[0], tol=FLAT)) == 3


@lru_cache(maxsize=256)
def _convex(size: tuple[float, ...]) -> Any:
    """The coal geometry of a convex shape, from the triangles that SciPy finds for its hull."""
    from scipy.spatial import ConvexHull

    coal, points = load_coal(), corners(size)
    made = ConvexHull(points)
    listed, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    listed.extend(list(points))
    for triangle, plane in zip(made.simplices, made.equations, strict=True):
        a, b, c = (int(k) for k in triangle)
        if np.dot(np.cross(points[b] - points[a], points[c] - points[a]), plane[:3]) < 0:
            b, c = c, b
        triangles.append(coal.Triangle(a, b, c))
    return coal.Convex(listed, triangles)


def volume(size: Sequence[float]) -> float:
    """The volume of a convex shape, cubic metres. Raises MissingLibrary."""
    return float(_convex(tuple(size)).computeVolume())


def inside_top(size: Sequence[float], points: Array) -> Array:
    """How far points `(T, 2)` lie inside the edge of the flat top of a convex shape, in its own axes `(T,)`; -1 where
    it has none."""
    from scipy.spatial import ConvexHull, QhullError

    found = corners(size)
    top = found[found[:, 2] >= found[:, 2].max() - FLAT, :2]
    if len(top) < 3:
        return np.full(len(points), -1.0)
    try:
        edges = ConvexHull(top).equations
    except QhullError:
        return np.full(len(points), -1.0)
    return np.asarray((-(points @ edges[:, :2].T) - edges[:, 2]).min(axis=1))


def geometry(kind: str, size: Sequence[float]) -> Any:
    """The coal geometry of a shape. Raises MissingLibrary."""
    coal = load_coal()
    match kind:
        case ShapeKind.BOX:
            return coal.Box(*size)
        case ShapeKind.SPHERE:
            return coal.Sphere(*size)
        case ShapeKind.CAPSULE:
            return coal.Capsule(*size)
        case ShapeKind.CYLINDER:
            return coal.Cylinder(*size)
        case ShapeKind.CONVEX:
            return _convex(tuple(size))
        case _:
            raise ValueError(f"unknown shape {kind}")


def transform(position: Array, rotation: Array) -> Any:
    """A coal transform from a position `(3,)` and a rotation matrix `(3, 3)`."""
    return load_coal().Transform3s(rotation, position)


class Ruler:
    """Signed distances by coal; negative when two shapes overlap."""

    def __init__(self) -> None:
        coal = load_coal()
        self._request = coal.DistanceRequest()
        self._request.enable_signed_distance = True
        self._distance = coal.distance
        self._result = coal.DistanceResult

    def distance(self, first: Any, at_first: Any, second: Any, at_second: Any) -> float:
        """Metres between two coal geometries at two coal transforms."""
        return float(self._distance(first, at_first, second, at_second, self._request, self._result()))


def bounding_radius(kind: str, size: Sequence[float]) -> float:
    """Radius of the smallest sphere around the shape's centre that holds it."""
    match kind:
        case ShapeKind.BOX:
            return 0.5 * math.hypot(*size)
        case ShapeKind.CAPSULE:
            return size[0] + 0.5 * size[1]
        case ShapeKind.CYLINDER:
            return math.hypot(size[0], 0.5 * size[1])
        case ShapeKind.CONVEX:
            return float(np.linalg.norm(corners(size), axis=1).max())
        case _:
            return size[0]


def round_radius(kind: str, size: Sequence[float]) -> float:
    """What `radius(X)` means: the radius of a round shape, or of the sphere around another one."""
    return bounding_radius(kind, size) if kind in (ShapeKind.BOX, ShapeKind.CONVEX) else size[0]


def heights(kind: str, size: Sequence[float], rotation: Array, up: bool = True) -> Array:
    """How far the highest point of a shape turned by `rotation` `(T, 3, 3)` lies above its centre `(T,)`, or not `up`
    the lowest point below."""
    if kind == ShapeKind.CONVEX:
        along = rotation[:, 2, :] @ corners(size).T
        return np.asarray(along.max(axis=1) if up else -along.min(axis=1))
    upright = np.abs(rotation[:, 2, 2])
    match kind:
        case ShapeKind.BOX:
            return np.asarray(np.abs(rotation[:, 2, :]) @ (0.5 * np.asarray(size)))
        case ShapeKind.CAPSULE:
            return np.asarray(size[0] + 0.5 * size[1] * upright)
        case ShapeKind.CYLINDER:
            return np.asarray(0.5 * size[1] * upright + size[0] * np.sqrt(np.clip(1 - upright**2, 0, None)))
        case _:
            return np.full(len(rotation), size[0])
