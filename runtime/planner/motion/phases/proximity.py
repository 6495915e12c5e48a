"""What comes near in phases of one structure: moving spheres and obstacles, and pairs of moving spheres.
Boxes and spheres around things are looked at first, so that what is far costs next to nothing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ....skeleton import Array
from .batch_kinematics import Indices
from .contact_margins import NEVER, Kinds
from .phase_geometry import Geometry
from .settings import PHASES


@dataclass(slots=True)
class Close:
    """Entries `(m,)` of one block (obstacles, pairs) that are nearer than asked for: the row and, for
    obstacles, the column there (else 0), phase, time, clearance in metres, and the kind of pair."""

    block: int
    row: Indices
    column: Indices
    phase: Indices
    time: Indices
    clearance: Array
    kind: Kinds


def near_obstacles(geometry: Geometry, points: Array, margin: float) -> tuple[Indices, Indices, Indices, Indices]:
    """Spheres, obstacles, phases and times `(m,)` at which they may be nearer than the margin, for the centres
    `(spheres, 3, phases, times)`: by boxes around the spheres of one node, over all times first, then at every time,
    and last by those around single spheres."""
    shapes, groups = geometry.shapes, geometry.points.groups
    if not groups or not len(shapes.rounding):
        return (np.zeros(0, np.intp),) * 4
    order = np.concatenate([mine for _, mine, _ in groups])
    size = np.array([len(mine) for _, mine, _ in groups])
    first = np.cumsum(size) - size
    ordered = points[order]
    wanted = (np.maximum.reduceat(geometry.radius[order, 0, 0], first) + margin)[:, None, None, None]
    lowest, highest = np.minimum.reduceat(ordered, first) - wanted, np.maximum.reduceat(ordered, first) + wanted
    bottom, top = shapes.centre[..., 0] - shapes.extent, shapes.centre[..., 0] + shapes.extent
    over, under = lowest.min(axis=-1)[:, None] <= top, highest.max(axis=-1)[:, None] >= bottom
    g, o, k = np.nonzero((over & under).all(axis=2))
    together = (lowest[g, :, k] <= top[o, :, k, None]) & (highest[g, :, k] >= bottom[o, :, k, None])
    row, t = np.nonzero(together.all(axis=1))
    g, o, k = g[row], o[row], k[row]
    entry = np.repeat(np.arange(len(g)), size[g])
    ahead = np.cumsum(size[g]) - size[g]
    a = order[first[g][entry] + np.arange(len(entry)) - ahead[entry]]
    kept = geometry.obstacle_kinds[a, o[entry], k[entry]] != NEVER
    a, entry = a[kept], entry[kept]
    o, k, t = o[entry], k[entry], t[entry]
    away = np.abs(points[a, :, k, t] - shapes.centre[o, :, k, 0])
    kept = (away <= shapes.extent[o, :, k] + geometry.radius[a, 0] + margin).all(axis=1)
    return a[kept], o[kept], k[kept], t[kept]


def near_pairs(geometry: Geometry, points: Array, margin: float) -> tuple[Indices, Indices, Indices, Array]:
    """Pairs of spheres that may meet, phases and times `(m,)` at which they are nearer than the margin, and the ways
    `(m, 3)` from their second centres to their first ones."""
    if len(geometry.pairs) > PHASES.many_pairs:
        return _near_by_nodes(geometry, points, margin)
    apart = points[geometry.pairs[:, 0]] - points[geometry.pairs[:, 1]]
    near = np.einsum("picd,picd->pcd", apart, apart) < (geometry.touching + margin) ** 2
    p, k, t = np.nonzero(near & (geometry.pair_kinds != NEVER)[..., None])
    return p, k, t, apart[p, :, k, t]


def _near_by_nodes(
    geometry: Geometry, points: Array, margin: float
) -> tuple[Indices, Indices, Indices, Array]:  # fmt: skip
    """The same, by boxes around the spheres of each node first."""
    p, k, t = geometry.groups.meeting(points, geometry.radius + margin / 2)
    kept = np.flatnonzero(geometry.pair_kinds[p, k] != NEVER)
    p, k, t = p[kept], k[kept], t[kept]
    apart = points[geometry.pairs[p, 0], :, k, t] - points[geometry.pairs[p, 1], :, k, t]
    near = np.einsum("mi,mi->m", apart, apart) < (geometry.touching[p, 0, 0] + margin) ** 2
    return p[near], k[near], t[near], apart[near]


def close(geometry: Geometry, values: Array, margin: float) -> Iterator[Close]:
    """All that is nearer than `margin`, metres, for joint values `(phases, times, joints)`, block by block."""
    frames = geometry.kinematics.frames(values)
    points = geometry.points.placed(frames)
    yield _to_obstacles(geometry, points, margin)
    yield _among_themselves(geometry, points, margin)


def _to_obstacles(geometry: Geometry, points: Array, margin: float) -> Close:
    a, o, k, t = near_obstacles(geometry, points, margin)
    distance = geometry.shapes.distance_at(points[a, :, k, t][..., None], o, k)[0][:, 0]
    clearance = distance - geometry.radius[a, 0, 0]
    hit = np.flatnonzero(clearance < margin)
    a, o, k, t = a[hit], o[hit], k[hit], t[hit]
    return Close(0, a, o, k, t, clearance[hit], geometry.obstacle_kinds[a, o, k])


def _among_themselves(geometry: Geometry, points: Array, margin: float) -> Close:
    p, k, t, apart = near_pairs(geometry, points, margin)
    clearance = np.linalg.norm(apart, axis=1) - geometry.touching[p, 0, 0]
    return Close(1, p, np.zeros_like(p), k, t, clearance, geometry.pair_kinds[p, k])
