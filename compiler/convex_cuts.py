"""Closed surfaces cut into convex parts along their own planes, exactly (Thibault and Naylor, Set Operations on
Polyhedra Using Binary Space Partitioning Trees, 1987)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .hulls import Array, corners_of
from .mesh_surfaces import Surface, Triangles, volume

MOST_PARTS = 64
"""Parts that a body is cut into: with more, what robots keep clear of takes longer than the search."""
MOST_PLANES = 24
"""Planes that are tried at a cut, the largest first."""
PLANES, CUTS = 8, 4
"""How many planes a surface may have, and how many cuts are made, for each part that is allowed."""
FLAT = 1e-6
"""Share of the size of a body by which a point may lie off a plane and is on it."""
EXACT = 1e-3
"""Share by which the volume of the parts may differ from that of the body: else it is not what the surface holds."""

Polygon = tuple[int, Array]
"""The number of its plane, and its corners (N, 3)."""


class TooMany(Exception):
    """The body has too many parts."""


def cut(surface: Surface, most: int = MOST_PARTS) -> list[Array] | None:
    """The corners (N, 3) of convex parts that fill what a closed surface holds; None where they are more than `most`,
    or where the surface holds nothing that can be told."""
    if not surface.even or surface.volume <= 0.0:
        return None
    count = int(surface.piece.max()) + 1
    if count > most:
        return None
    held = [volume(surface.points, surface.triangles[surface.piece == k]) for k in range(count)]
    hollow = min(held) < 0.0
    pieces = [surface.triangles]
    if not hollow:
        pieces = [surface.triangles[surface.piece == k] for k in range(count)]
    found: list[Array] = []
    try:
        for triangles in pieces:
            found += _Cutter(surface.points, triangles, most - len(found)).parts()
    except TooMany:
        return None
    filled = sum(hull_volume(part) for part in found)
    whole = sum(held)
    return found if abs(filled - whole) <= EXACT * whole else None


def hull_volume(corners: Array) -> float:
    """The volume of the hull of points (N, 3), cubic metres; 0 where there is none."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return float(ConvexHull(corners).volume)
    except (QhullError, ValueError):
        return 0.0


class _Cutter:
    """Cuts what a piece of a surface holds. A cell is the hull of its corners; polygons are what of the surface runs
    through it."""

    def __init__(self, points: Array, triangles: Triangles, most: int) -> None:
        self.most = most
        self.corners = points[triangles]
        self.size = float(np.linalg.norm(np.ptp(points[np.unique(triangles)], axis=0)))
        self.off = FLAT * self.size
        normals = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        self.areas = np.linalg.norm(normals, axis=1) / 2.0
        normals /= 2.0 * self.areas[:, None]
        offsets = np.einsum("ij,ij->i", normals, self.corners.mean(axis=1))
        self.planes, self.of = self._joined(np.column_stack([normals, offsets / self.size]))
        self.cuts = 0
        self.found: list[Array] = []

    def _joined(self, planes: Array) -> tuple[Array, Triangles]:
        """The planes that differ, those of the largest triangles, and which of them each triangle lies in."""
        kept: list[int] = []
        of = np.zeros(len(planes), dtype=np.int64)
        for k in np.argsort(-self.areas, kind="stable").tolist():
            near = np.abs(planes[kept] - planes[k]).max(axis=1) if kept else np.zeros(0)
            if len(near) and near.min() < 10.0 * FLAT:
                of[k] = int(near.argmin())
            else:
                of[k] = len(kept)
                kept.append(k)
                if len(kept) > PLANES * self.most:
                    raise TooMany
        return planes[kept] * np.array([1.0, 1.0, 1.0, self.size]), of

    def parts(self) -> list[Array]:
        """The corners of the convex parts. Raises TooMany."""
        cell = corners_of(self.corners.reshape(-1, 3))
        inner = []
        for k, corners in enumerate(self.corners):
            plane = self.planes[self.of[k]]
            if (cell @ plane[:3] - plane[3]).max() > self.off:
                inner.append((int(self.of[k]), corners))
        if inner:
            self._cut(cell, inner)
        else:
            self.found = [cell]
        return self.found

    def _cut(self, cell: Array, polygons: Sequence[Polygon]) -> None:
        self.cuts += 1
        if self.cuts > CUTS * self.most:
            raise TooMany
        chosen = self._plane(polygons)
        plane = self.planes[chosen]
        front, back = list[Polygon](), list[Polygon]()
        for number, corners in polygons:
            if number != chosen:
                for side, keeps in ((1.0, front), (-1.0, back)):
                    part = self._clipped(corners, side * plane)
                    if part is not None:
                        keeps.append((number, part))
        for side, inner in ((-1.0, back), (1.0, front)):
            half = self._half(cell, side * plane)
            if half is None:
                continue
            if inner:
                self._cut(half, inner)
            elif side < 0.0:
                self.found.append(half)
                if len(self.found) > self.most:
                    raise TooMany

    def _plane(self, polygons: Sequence[Polygon]) -> int:
        """The plane that cuts the fewest polygons; of those the one with the fewest on one side, then the largest."""
        area: dict[int, float] = {}
        for number, corners in polygons:
            area[number] = area.get(number, 0.0) + _area(corners)
        tried = sorted(area, key=lambda n: (-area[n], n))[:MOST_PLANES]
        points = np.concatenate([corners for _, corners in polygons])
        first = np.cumsum([0, *(len(corners) for _, corners in polygons[:-1])])
        own = np.array([number for number, _ in polygons])
        best = None
        for number in tried:
            height = points @ self.planes[number][:3] - self.planes[number][3]
            low, high = np.minimum.reduceat(height, first), np.maximum.reduceat(height, first)
            above, below = (high > self.off) & (own != number), (low < -self.off) & (own != number)
            split = int((above & below).sum())
            score = (split, min(int(above.sum()), int(below.sum())), -area[number], number)
            best = score if best is None or score < best else best
        assert best is not None
        return best[3]

    def _clipped(self, corners: Array, plane: Array) -> Array | None:
        """What of a polygon lies above a plane; None where it is nothing."""
        height = corners @ plane[:3] - plane[3]
        if height.max() <= self.off:
            return None
        if height.min() >= -self.off:
            return corners
        kept = []
        for k in range(len(corners)):
            a, b, h, i = corners[k], corners[(k + 1) % len(corners)], height[k], height[(k + 1) % len(corners)]
            if h >= 0.0:
                kept.append(a)
            if h * i < 0.0:
                kept.append(a + h / (h - i) * (b - a))
        part = np.array(kept)
        return part if len(part) >= 3 and _area(part) > self.off**2 else None

    def _half(self, cell: Array, plane: Array) -> Array | None:
        """The corners of what of a cell lies above a plane; None where it is flat."""
        height = cell @ plane[:3] - plane[3]
        if height.max() <= self.off:
            return None
        above, below = cell[height > 0.0], cell[height < 0.0]
        if not len(below) or height.min() >= -self.off:
            return cell
        high, low = height[height > 0.0][:, None], height[height < 0.0][None]
        share = (high / (high - low))[..., None]
        crossing = above[:, None] + share * (below[None] - above[:, None])
        return corners_of(np.concatenate([cell[height >= 0.0], crossing.reshape(-1, 3)]))


def _area(corners: Array) -> float:
    return float(np.linalg.norm(np.cross(corners[1:-1] - corners[0], corners[2:] - corners[0]).sum(axis=0))) / 2.0
