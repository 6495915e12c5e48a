"""The least clearance of phases all along their motion.

Distances are measured at the slices first. A distance changes by no more than its two sides move, so that what is far
apart there, less how far both go until another slice is nearer, needs no look between the slices. So with fine times:
what is clear at two of them is looked at between them where it goes by so fast that it may be deeper there.
"""

from __future__ import annotations

import numpy as np

from ....skeleton import Array
from .contact_margins import REQUIRED
from .exact_check import Entries, ExactGeometry, near_entries
from .settings import PHASES

AT_SLICES = slice(None, None, PHASES.refinement)


def departure(vectors: Array) -> Array:
    """How far vectors `(…, fine times)` go from where they are at a slice, until another one is nearer, the sum of
    squares over the axis before `phases`: `(…, phases, slices + 1)` for `(…, k, phases, fine times)`."""
    times = np.arange(vectors.shape[-1])
    away = vectors - vectors[..., (times + PHASES.refinement // 2) // PHASES.refinement * PHASES.refinement]
    first = np.maximum(times[AT_SLICES] - PHASES.refinement // 2, 0)
    return np.asarray(np.sqrt(np.maximum.reduceat((away * away).sum(axis=-3), first, axis=-1)))


def swept_clearance(geometry: ExactGeometry, values: Array) -> Array:
    """The least excess clearance `(phases,)` at all fine times, for joint values `(phases, times, joints)`; `far`
    when it is more."""
    frames = geometry.kinematics.frames(values)
    nodes, _, _, phases, times = frames.shape
    shift, turn = departure(frames[:, 3]), departure(frames[:, :3].reshape(nodes, 9, phases, times))
    lever = np.linalg.norm(geometry.local[:, :, :3, 3], axis=2) + geometry.reach
    moved = shift[geometry.nodes] + lever.T[:, :, None] * turn[geometry.nodes]
    least = np.full(phases, PHASES.far)
    at_slices = frames[..., AT_SLICES]
    for entries in near_entries(geometry, at_slices, moved + PHASES.far):
        room = moved[entries.first, entries.phase, entries.time]
        if entries.among:
            room = room + moved[entries.second, entries.phase, entries.time]
        distance = entries.measured(geometry, at_slices, room + PHASES.far).value
        _lower(least, entries, distance)
        closer = np.flatnonzero(distance - room < REQUIRED[entries.kind] + PHASES.far)
        fine = _between(entries[closer], times)
        step = _steps(geometry, frames, fine)
        distance = fine.measured(geometry, frames, step + PHASES.far).value
        _lower(least, fine, distance)
        passing = (least[fine.phase] >= 0.0) & (distance - step < -PHASES.deepest)
        _look_closer(geometry, values, fine[np.flatnonzero(passing)], least)
    return least


def _steps(geometry: ExactGeometry, frames: Array, entries: Entries) -> Array:
    """How far the two sides of entries at fine times go, together, to half-way to the time before or after, the
    longer of both: `(m,)`, metres."""
    phase, time = entries.phase, entries.time
    result = np.zeros(len(time))
    for part in (entries.first, entries.second) if entries.among else (entries.first,):
        node, local = geometry.nodes[part], geometry.local[phase, part, :3, 3]
        lever = np.linalg.norm(local, axis=1) + geometry.reach[phase, part]
        here = frames[node, :, :, phase, time]
        ways = []
        for other in (np.maximum(time - 1, 0), np.minimum(time + 1, frames.shape[-1] - 1)):
            away = frames[node, :, :, phase, other] - here
            ways.append(np.linalg.norm(away[:, 3], axis=1) + lever * np.linalg.norm(away[:, :3], axis=(1, 2)))
        result += np.maximum(*ways) / 2
    return result


def between(values: Array) -> Array:
    """Joint values `(times, joints)` with as many more in between as are looked at where things pass fast."""
    every = 2 * PHASES.closer_looks
    share = (np.arange(every) / every)[:, None]
    filled = values[:-1, None] * (1.0 - share) + values[1:, None] * share
    return np.concatenate([filled.reshape(-1, values.shape[1]), values[-1:]])


def _look_closer(geometry: ExactGeometry, values: Array, entries: Entries, least: Array) -> None:
    """Lower the clearance `(phases,)` by entries at fine times, seen around these on straight lines of the joints."""
    if not len(entries.first):
        return
    looks = np.arange(-PHASES.closer_looks, PHASES.closer_looks + 1) / (2 * PHASES.closer_looks)
    place, row = np.unique(entries.phase * values.shape[1] + entries.time, return_inverse=True)
    phase, time = np.divmod(place, values.shape[1])
    before, after = np.maximum(time - 1, 0), np.minimum(time + 1, values.shape[1] - 1)
    here = values[phase, time][:, None]
    back, on = values[phase, before][:, None] - here, values[phase, after][:, None] - here
    row, share = row.ravel(), looks[:, None]
    for first in range(0, len(place), PHASES.closer_lot):
        lot = np.arange(first, min(first + PHASES.closer_lot, len(place)))
        around = here[lot] + np.maximum(-share, 0.0) * back[lot] + np.maximum(share, 0.0) * on[lot]
        closer = geometry.take(phase[lot])
        mine = np.flatnonzero((row >= first) & (row < first + PHASES.closer_lot))
        many = entries[np.repeat(mine, len(looks))]
        many.phase, many.time = np.repeat(row[mine] - first, len(looks)), np.tile(np.arange(len(looks)), len(mine))
        distance = many.measured(closer, closer.kinematics.frames(around), np.full(len(many.first), PHASES.far)).value
        np.minimum.at(least, phase[lot][many.phase], distance + PHASES.deepest)


def _between(entries: Entries, times: int) -> Entries:
    """The entries, which are at slices, at the fine times nearest to these."""
    around = entries.time[:, None] * PHASES.refinement + np.arange(PHASES.refinement) - PHASES.refinement // 2
    result = entries[np.repeat(np.arange(len(entries.first)), PHASES.refinement)]
    result.time = np.clip(around, 0, times - 1).ravel()
    return result


def _lower(least: Array, entries: Entries, distance: Array) -> None:
    np.minimum.at(least, entries.phase, distance - REQUIRED[entries.kind])
