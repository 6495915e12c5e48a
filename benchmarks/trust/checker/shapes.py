"""Shapes of a plan file, how far they reach, and coal's distances between them. Metres."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2}


@dataclass(frozen=True, slots=True)
class Solid:
    """A shape with its sizes; `around` is the radius of the sphere around it, a round one's own radius."""

    kind: str
    size: tuple[float, ...]
    coal: Any
    sides: tuple[float, float, float]
    around: float

    @property
    def extent(self) -> float:
        """The radius of the sphere around its frame's origin that holds all of it."""
        if self.kind == "capsule":
            return self.size[0] + self.size[1] / 2
        if self.kind == "cylinder":
            return math.hypot(self.size[0], self.size[1] / 2)
        return self.around

    def rise(self, frame: Matrix) -> Matrix:
        """How far its highest point lies above its origin: of one frame (4, 4), or of each of a stack of them."""
        up = np.abs(frame[..., 2, :3])
        match self.kind:
            case "box":
                return np.asarray(up @ (np.array(self.size) / 2))
            case "sphere":
                return np.asarray(0.0 * up[..., 0] + self.size[0])
            case "capsule":
                return np.asarray(up[..., 2] * self.size[1] / 2 + self.size[0])
            case "cylinder":
                side = np.sqrt(np.maximum(0.0, 1 - up[..., 2] ** 2))
                return np.asarray(up[..., 2] * self.size[1] / 2 + side * self.size[0])
        return np.asarray((frame[..., 2, :3] @ self.points.T).max(axis=-1))

    def fall(self, frame: Matrix) -> Matrix:
        """How far its lowest point lies below its origin."""
        if self.kind != "convex":
            return self.rise(frame)
        return np.asarray(-(frame[..., 2, :3] @ self.points.T).min(axis=-1))

    @property
    def points(self) -> Matrix:
        return np.array(self.size).reshape(-1, 3)


@functools.lru_cache(maxsize=4096)
def _solid(kind: str, size: tuple[float, ...]) -> Solid:
    if kind == "convex" and len(size) >= 12 and len(size) % 3 == 0:
        points = np.array(size).reshape(-1, 3)
        sides = points.max(axis=0) - points.min(axis=0)
        around = float(np.linalg.norm(points, axis=1).max())
        x, y, z = sides.tolist()
        return Solid(kind, size, _hull(points), (x, y, z), around)
    if SIZES.get(kind) != len(size) or min(size) < 0:
        raise ValueError(f"no shape: {kind} {size}")
    if kind == "box":
        x, y, z = size
        return Solid(kind, size, coal.Box(x, y, z), (x, y, z), math.hypot(x, y, z) / 2)
    if kind == "sphere":
        return Solid(kind, size, coal.Sphere(*size), (2 * size[0],) * 3, size[0])
    maker = coal.Capsule if kind == "capsule" else coal.Cylinder
    height = size[1] + (2 * size[0] if kind == "capsule" else 0.0)
    return Solid(kind, size, maker(*size), (2 * size[0], 2 * size[0], height), size[0])


def solid_of(kind: str, size: Sequence[float]) -> Solid:
    return _solid(kind, tuple(map(float, size)))


def _hull(points: Matrix) -> Any:
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    triangles = coal.StdVec_Triangle()
    for simplex, plane in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = (int(i) for i in simplex)
        turn = np.cross(points[b] - points[a], points[c] - points[a]) @ plane[:3]
        triangles.append(coal.Triangle(a, b, c) if turn > 0 else coal.Triangle(a, c, b))
    corners = coal.StdVec_Vec3s()
    for point in points:
        corners.append(point)
    return coal.Convex(corners, triangles)


def distance(one: tuple[Solid, Matrix], other: tuple[Solid, Matrix]) -> float:
    """The signed distance; negative where shapes overlap. Spheres and capsules are measured by hand."""
    if {one[0].kind, other[0].kind} <= {"sphere", "capsule"}:
        return _segments(_segment(*one), _segment(*other)) - one[0].size[0] - other[0].size[0]
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    return float(coal.distance(one[0].coal, _place(one[1]), other[0].coal, _place(other[1]), request, result))


def _place(frame: Matrix) -> Any:
    return coal.Transform3s(np.ascontiguousarray(frame[:3, :3]), np.ascontiguousarray(frame[:3, 3]))


def _segment(solid: Solid, frame: Matrix) -> tuple[Matrix, Matrix]:
    half = frame[:3, 2] * (solid.size[1] / 2 if solid.kind == "capsule" else 0.0)
    return frame[:3, 3] - half, frame[:3, 3] + half


def _segments(one: tuple[Matrix, Matrix], other: tuple[Matrix, Matrix]) -> float:
    """The distance of two segments: that of their lines where it lies inside both, else that of an end to a segment."""
    (a, b), (c, d) = one, other
    u, v, w = b - a, d - c, a - c
    uu, uv, vv, uw, vw = u @ u, u @ v, v @ v, u @ w, v @ w
    found = [_point(p, *other) for p in one] + [_point(p, *one) for p in other]
    det = uu * vv - uv * uv
    if det > 1e-15:
        s, t = (uv * vw - vv * uw) / det, (uu * vw - uv * uw) / det
        if 0 <= s <= 1 and 0 <= t <= 1:
            found.append(float(np.linalg.norm(w + s * u - t * v)))
    return min(found)


def _point(p: Matrix, a: Matrix, b: Matrix) -> float:
    u = b - a
    t = min(1.0, max(0.0, float((p - a) @ u) / max(float(u @ u), 1e-30)))
    return float(np.linalg.norm(p - a - t * u))


def corners(sides: Sequence[float]) -> Matrix:
    return np.array(list(itertools.product(*((-s / 2, s / 2) for s in sides))))
