"""The swept check: whether a path keeps clear all along its spline, and within limits.

Distances are measured at the slices first. A distance changes by no more than its two sides move, so that what is far
apart there, less how far both go until another slice is nearer, needs no look between the slices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .....compiler.motion.collision import CHECK_MARGIN, PATH_MARGIN
from ....geometry.splines import spline_weights
from ....skeleton import Array
from .batch_kinematics import Indices
from .contact_margins import NEVER, Kinds
from .exact_shapes import Whole
from .phase_batch import REFINEMENT, Batch
from .phase_geometry import Geometry

FAR = 1e-3
"""Excess clearance, metres, beyond which nothing is measured: more counts as this much."""
AT_SLICES = slice(None, None, REFINEMENT)


def departure(vectors: Array) -> Array:
    """How far vectors `(…, fine times)` go from where they are at a slice, until another one is nearer, the sum of
    squares over the axis before `phases`: `(…, phases, slices + 1)` for `(…, k, phases, fine times)`."""
    times = np.arange(vectors.shape[-1])
    away = vectors - vectors[..., (times + REFINEMENT // 2) // REFINEMENT * REFINEMENT]
    first = np.maximum(times[AT_SLICES] - REFINEMENT // 2, 0)
    return np.asarray(np.sqrt(np.maximum.reduceat((away * away).sum(axis=-3), first, axis=-1)))


class _Motion:
    """The frames of all nodes at all fine times, and bounds of how far things fixed to them go between the slices."""

    def __init__(self, geometry: Geometry, values: Array) -> None:
        self.geometry = geometry
        self.frames = geometry.kinematics.frames(values)
        nodes, _, _, phases, times = self.frames.shape
        self._shift = departure(self.frames[:, 3])
        self._turn = departure(self.frames[:, :3].reshape(nodes, 9, phases, times))
        self.at_slices = geometry.points.placed(self.frames[..., AT_SLICES])
        self.moved = self.departure_of(geometry.points.nodes, np.linalg.norm(geometry.points.centres, axis=2).T)

    def departure_of(self, nodes: Indices, radius: Array) -> Array:
        """Bounds `(n, phases, slices + 1)` for points at most `radius` `(n, phases)` from the origins of nodes."""
        return np.asarray(self._shift[nodes] + radius[..., None] * self._turn[nodes])

    def times(self, slices: Indices) -> Indices:
        """The fine times `(m, REFINEMENT)` nearest to slices `(m,)`."""
        around = slices[:, None] * REFINEMENT + np.arange(REFINEMENT) - REFINEMENT // 2
        return np.asarray(np.clip(around, 0, self.frames.shape[-1] - 1))

    def nodes(self, node: Indices, phase: Indices, times: Indices) -> Array:
        """The frames `(m, times, 4, 3)` of nodes `(m,)` at times `(m, times)`."""
        return np.asarray(self.frames[node[:, None], :, :, phase[:, None], times])

    def points(self, spheres: Indices, phase: Indices, times: Indices) -> Array:
        """The centres `(m, 3, times)` of spheres `(m,)` at times `(m, times)`."""
        frames = self.nodes(self.geometry.points.nodes[spheres], phase, times)
        centres = self.geometry.points.centres[phase, spheres]
        turned = (centres[:, None, None] @ frames[:, :, :3])[:, :, 0]
        return np.asarray((turned + frames[:, :, 3]).transpose(0, 2, 1))


def swept_clearance(batch: Batch, values: Array) -> Array:
    """The least excess clearance `(phases,)` at all fine times, for joint values `(phases, times, joints)`; FAR when it
    is more."""
    fine = batch.fine
    motion = _Motion(fine, values)
    least = np.full(len(batch), FAR)
    _to_obstacles(batch, motion, _suspects(batch.coarse, _Motion(batch.coarse, values)), least)
    _among_themselves(batch, motion, least)
    for whole, kinds in zip(fine.wholes, fine.whole_kinds, strict=True):
        _to_whole(batch, motion, whole, kinds, least)
    return least


def _suspects(coarse: Geometry, motion: _Motion) -> NDArray[np.bool_]:
    """`(owners, obstacles, phases, slices + 1)`: what the optimiser's spheres, which are few, do not prove to keep
    clear until another slice is nearer."""
    owners = int(coarse.owner.max(initial=-1)) + 1
    result = np.zeros((owners, *coarse.obstacle_kinds.shape[1:], motion.moved.shape[-1]), bool)
    a, o, k, slices, times = _near_obstacles(motion, PATH_MARGIN, None)
    distance = coarse.shapes.distance_at(motion.points(a, k, times), o, k)[0]
    left = (distance.min(axis=1) - coarse.radius[a, 0, 0]) < PATH_MARGIN
    result[coarse.owner[a[left]], o[left], k[left], slices[left]] = True
    return result


def _near_obstacles(
    motion: _Motion, reach: float, suspects: NDArray[np.bool_] | None
) -> tuple[Indices, Indices, Indices, Indices, Indices]:
    """What may come nearer than `reach`, metres, by what is known at the slices: spheres, obstacles, phases and slices
    `(m,)`, and fine times `(m, REFINEMENT)`."""
    geometry, points, moved = motion.geometry, motion.at_slices, motion.moved
    radius = geometry.radius + reach
    near = geometry.shapes.boxed(points.min(axis=-1), points.max(axis=-1), radius + moved.max(axis=-1)[:, None])
    near &= geometry.obstacle_kinds != NEVER
    if suspects is not None:
        near &= np.asarray(suspects.any(axis=-1))[geometry.owner]
    a, o, k = np.nonzero(near)
    distance = geometry.shapes.distance_at(points[a, :, k], o, k)[0]
    close = distance - moved[a, k] < radius[a, 0]
    if suspects is not None:
        close &= suspects[geometry.owner[a], o, k]
    row, slices = np.nonzero(close)
    return a[row], o[row], k[row], slices, motion.times(slices)


def _to_obstacles(batch: Batch, motion: _Motion, suspects: NDArray[np.bool_], least: Array) -> None:
    fine = motion.geometry
    a, o, k, _, times = _near_obstacles(motion, CHECK_MARGIN + FAR, suspects)
    clearance = fine.shapes.distance_at(motion.points(a, k, times), o, k)[0] - fine.radius[a, 0]
    required = batch.required[fine.exact[a, None], fine.obstacle_kinds[a, o, k][:, None], times]
    np.minimum.at(least, k, (clearance - required).min(axis=1))


def _among_themselves(batch: Batch, motion: _Motion, least: Array) -> None:
    fine, points, moved = motion.geometry, motion.at_slices, motion.moved
    p, k = np.nonzero(fine.pair_kinds != NEVER)
    one, other = fine.pairs[p].T
    reach = fine.touching[p, 0] + CHECK_MARGIN + FAR
    apart = points[one, :, k] - points[other, :, k]
    row, slices = np.nonzero(np.sqrt((apart * apart).sum(axis=1)) - moved[one, k] - moved[other, k] < reach)
    p, k, one, other, times = p[row], k[row], one[row], other[row], motion.times(slices)
    apart = motion.points(one, k, times) - motion.points(other, k, times)
    clearance = np.sqrt((apart * apart).sum(axis=1)) - fine.touching[p, 0]
    exact = fine.exact[fine.pairs[p]].min(axis=1)
    required = batch.required[exact[:, None], fine.pair_kinds[p, k][:, None], times]
    np.minimum.at(least, k, (clearance - required).min(axis=1))


def _to_whole(batch: Batch, motion: _Motion, whole: Whole, kinds: Kinds, least: Array) -> None:
    fine, points = motion.geometry, motion.at_slices
    reach = fine.radius[whole.meets, 0, 0] + CHECK_MARGIN + FAR
    around = np.linalg.norm(whole.local[:, :3, 3], axis=1) + whole.extent
    own = motion.departure_of(np.array([whole.node]), around[None])
    free = reach[:, None, None] + motion.moved[whole.meets] + own
    frames = motion.frames[whole.node][..., AT_SLICES]
    away = points[whole.meets] - whole.origin(frames)
    apart = np.sqrt((away * away).sum(axis=1)) - whole.extent[:, None]
    n, k = np.nonzero((kinds != NEVER) & (apart < free).any(axis=-1))
    distance = whole.distance_at(frames[:, :, k].transpose(2, 3, 0, 1), points[whole.meets[n], :, k], k)
    row, slices = np.nonzero(distance < free[n, k])
    n, k, times = n[row], k[row], motion.times(slices)
    spheres = whole.meets[n]
    frames = motion.nodes(np.full(len(k), whole.node), k, times)
    clearance = whole.distance_at(frames, motion.points(spheres, k, times), k) - fine.radius[spheres, 0]
    required = batch.required[fine.exact[spheres, None], kinds[n, k][:, None], times]
    np.minimum.at(least, k, (clearance - required).min(axis=1))


@dataclass(slots=True)
class Sweep:
    """The swept check per phase: excess clearance (metres; accepted from 0), how far joint limits are exceeded, and
    how far the largest step between slices exceeds what is allowed (both accepted up to 0)."""

    clearance: Array
    limit: Array
    step: Array

    @property
    def clean(self) -> NDArray[np.bool_]:
        return (self.clearance >= 0.0) & (self.limit <= 0.0) & (self.step <= 0.0)


def sweep(batch: Batch, paths: Array, chunk: int = 4) -> Sweep:
    """Check paths `(phases, slices + 1, joints)` on their clamped cubic splines."""
    values = spline_weights(batch.slices, batch.times) @ paths
    joints = batch.joints
    beyond = np.maximum(values - joints.upper[:, None], joints.lower[:, None] - values)
    step = np.abs(np.diff(paths, axis=1)) - joints.step[:, None]
    clearance = np.concatenate([
        swept_clearance(batch.take(index), values[index])
        for index in (np.arange(k, min(k + chunk, len(batch))) for k in range(0, len(batch), chunk))
    ])
    return Sweep(clearance, beyond.max(axis=(1, 2), initial=-np.inf), step.max(axis=(1, 2), initial=-np.inf))
