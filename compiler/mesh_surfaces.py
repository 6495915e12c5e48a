"""The surfaces of meshes: what is wrong with them, and mended as far as it is plain how."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..langs.frozen import dataclass
from .hulls import Array

Triangles = NDArray[np.int64]

SAME = 1e-6
"""Share of the size of a mesh by which two corners may differ and are one."""

BITS = 21
"""Of a number of a point, or of a place along an axis in such shares."""


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """`points` (M, 3) and `triangles` (T, 3) of them, each there once and none without an area, counter-clockwise from
    outside as far as it can be told; the `volume` inside. `piece` (T,) numbers what hangs together. `gaps` counts edges
    with one triangle alone; `turned` tells how many triangles looked inward, `flat` and `double` how many were left
    out."""

    points: Array
    triangles: Triangles
    piece: Triangles
    volume: float
    gaps: int
    turned: int
    flat: int
    double: int

    @property
    def even(self) -> bool:
        """Whether its faces look as much one way as the other, as those of a closed surface do."""
        return _even(self.points, self.triangles)

    def faults(self) -> list[str]:
        """What was wrong, in words."""
        count, told = len(self.triangles), list[str]()
        if self.gaps:
            told.append(f"it has holes: {self.gaps} edges have a face on one side alone")
        if self.turned:
            share = "" if self.turned == count else f"{self.turned} of "
            told.append(f"{share}its {count} faces look inward, and are turned")
        told += [f"{self.flat} faces without an area are left out"] if self.flat else []
        told += [f"{self.double} faces that are there twice are left out"] if self.double else []
        return told


def surface_of(points: Array, triangles: NDArray[np.number[Any]]) -> Surface:
    """The surface of a mesh of points (M, 3) and triangles (T, 3), numbers of points."""
    size = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    places = np.round((points - points.min(axis=0)) / (SAME * size)).astype(np.int64)
    _, first, number = np.unique(_keys(places), return_index=True, return_inverse=True)
    points, faces = points[first], number.reshape(-1)[np.asarray(triangles, dtype=np.int64)]
    kept = _areas(points, faces) > (SAME * size) ** 2
    flat, faces = int((~kept).sum()), faces[kept]
    _, once = np.unique(_keys(np.sort(faces, axis=1)), return_index=True)
    double, faces = len(faces) - len(once), faces[np.sort(once)]
    faces, turned = _outward(points, faces)
    return Surface(
        points, faces, _pieces(len(points), faces), volume(points, faces), _gaps(faces), turned, flat, double
    )  # fmt: skip


def _keys(rows: Triangles) -> Triangles:
    """One number for each row of two or three: no file that may be read has more points than this tells apart."""
    found = rows[:, 0]
    for k in range(1, rows.shape[1]):
        found = (found << BITS) | rows[:, k]
    return found


def volume(points: Array, triangles: Triangles) -> float:
    """The volume inside a closed surface, below zero where its faces look inward."""
    return float(_volumes(points, triangles).sum())


def _volumes(points: Array, triangles: Triangles) -> Array:
    """The volumes (T,) between triangles and one point."""
    a, b, c = (points[triangles[:, k]] - points.mean(axis=0) for k in range(3))
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0)


def _areas(points: Array, triangles: Triangles) -> Array:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2.0)


def _edges(triangles: Triangles) -> tuple[Triangles, Triangles]:
    """The edges (3 T, 2) of triangles, as these go around, and the triangle of each (3 T,)."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return ends, np.tile(np.arange(len(triangles)), 3)


def _gaps(triangles: Triangles) -> int:
    ends, _ = _edges(triangles)
    _, count = np.unique(_keys(np.sort(ends, axis=1)), return_counts=True)
    return int((count % 2).sum())


def _pieces(points: int, triangles: Triangles) -> Triangles:
    """The number of what each triangle hangs together with by its corners."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ends, _ = _edges(triangles)
    graph = coo_matrix((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(points, points))
    label = connected_components(graph, directed=False)[1][triangles[:, 0]]
    return np.unique(label, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _outward(points: Array, triangles: Triangles) -> tuple[Triangles, int]:
    """The triangles with their corners in the order that makes them look outward, and how many that changed. Where
    neighbours disagree they follow the first of their patch; closed patches that then hold less than nothing are
    turned, but for those that were sound within others."""
    if not len(triangles):
        return triangles, 0
    patch, against = _patches(triangles)
    count = int(patch.max()) + 1
    signed = np.where(against, -1.0, 1.0) * _volumes(points, triangles)
    inward = np.bincount(patch, signed, count) < 0.0
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for k in range(3):
        np.minimum.at(low, patch, points[triangles[:, k]])
        np.maximum.at(high, patch, points[triangles[:, k]])
    mixed = np.bincount(patch, against, count) > 0
    for k in np.flatnonzero(inward).tolist():
        hollow = not mixed[k] and bool(((low < low[k]) & (high[k] < high)).all(axis=1).any())
        inward[k] = not hollow
    ends, owner = _edges(triangles)
    keys = np.column_stack([patch[owner], np.sort(ends, axis=1)])
    _, found, times = np.unique(_keys(keys), return_index=True, return_counts=True)
    inward[keys[found[times % 2 == 1], 0]] = False
    turn = against ^ inward[patch]
    if (
        not inward.any()
        and float(np.where(turn, -1.0, 1.0) @ _volumes(points, triangles)) < 0.0
        and _even(points, np.where(turn[:, None], triangles[:, ::-1], triangles))
    ):
        turn = ~turn
    return np.where(turn[:, None], triangles[:, ::-1], triangles), int(turn.sum())


def _even(points: Array, triangles: Triangles) -> bool:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
    return bool(np.linalg.norm(areas.sum(axis=0)) <= SAME * np.linalg.norm(areas, axis=1).sum())


def _patches(triangles: Triangles) -> tuple[Triangles, NDArray[np.bool_]]:
    """The number of the patch of each triangle, which hangs together over edges of two triangles, and whether it goes
    round against the first of its patch."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    ends, owner = _edges(triangles)
    key = _keys(np.sort(ends, axis=1))
    order = np.argsort(key, kind="stable")
    _, start, count = np.unique(key[order], return_index=True, return_counts=True)
    pairs = start[count == 2]
    one, other = order[pairs], order[pairs + 1] if len(pairs) else order[pairs]
    same = (ends[one] == ends[other]).all(axis=1)
    a, b, total = owner[one], owner[other], len(triangles)
    graph = coo_matrix((np.ones(len(a), np.int8), (a, b)), shape=(total, total)).tocsr()
    label = connected_components(graph, directed=False)[1].astype(np.int64)
    against = np.zeros(total, bool)
    if same.any():
        joined = zip(a.tolist(), b.tolist(), same.tolist(), strict=True)
        between = {(min(p, q), max(p, q)): bool(s) for p, q, s in joined}
        for first in np.unique(label, return_index=True)[1].tolist():
            reached, before = breadth_first_order(graph, first, directed=False)
            for at in reached[1:].tolist():
                come = int(before[at])
                against[at] = against[come] ^ between[min(at, come), max(at, come)]
    return label, against
