"""The swept check: whether a path keeps clear all along its spline, and within limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....compiler.motion.collision import CHECK_MARGIN
from ...skeleton import Array
from .batch import REFINEMENT, Batch, excess
from .geometry import Geometry
from .kinematics import Frame
from .shares import NEVER

FAR = 0.02
"""Excess clearance, metres, beyond which nothing is measured: more counts as this much."""
AT_SLICES = slice(None, None, REFINEMENT)


def departure(points: Array) -> Array:
    """How far points `(…, 3, phases, fine times)` go from where they are at a slice, until another one is nearer:
    `(…, phases, slices + 1)`."""
    times = np.arange(points.shape[-1])
    away = points - points[..., (times + REFINEMENT // 2) // REFINEMENT * REFINEMENT]
    first = np.maximum(times[AT_SLICES] - REFINEMENT // 2, 0)
    return np.asarray(np.sqrt(np.maximum.reduceat((away * away).sum(axis=-3), first, axis=-1)))


def swept_clearance(batch: Batch, values: Array) -> Array:
    """The least excess clearance `(phases,)` at all fine times, for joint values `(phases, times, joints)`; FAR when it
    is more. What cannot come near between the slices is measured at the slices only: a distance changes by no more
    than its spheres move."""
    fine = batch.fine
    points, frames = fine.place(values)
    moved = departure(points)
    least = np.full(len(batch), FAR)
    _to_obstacles(batch, fine, points, moved, least)
    _among_themselves(batch, fine, points, moved, least)
    for k in range(len(fine.bodies)):
        _to_body(batch, fine, points, frames, k, least)
    return least


def _to_obstacles(batch: Batch, fine: Geometry, points: Array, moved: Array, least: Array) -> None:
    reach = fine.radius + CHECK_MARGIN + FAR
    near = fine.shapes.boxed(points.min(axis=-1), points.max(axis=-1), reach) & (fine.obstacle_kinds != NEVER)
    a, o, k = np.nonzero(near)
    distance = fine.shapes.distance_at(points[a, :, k, AT_SLICES], o, k)[0]
    close = np.flatnonzero((distance - moved[a, k]).min(axis=-1, initial=np.inf) < reach[a, 0, 0])
    a, o, k = a[close], o[close], k[close]
    clearance = fine.shapes.distance_at(points[a, :, k], o, k)[0] - fine.radius[a, 0]
    np.minimum.at(least, k, excess(clearance, fine.obstacle_kinds[a, o, k], fine.exact[a], batch.required))


def _among_themselves(batch: Batch, fine: Geometry, points: Array, moved: Array, least: Array) -> None:
    p, k = np.nonzero(fine.pair_kinds != NEVER)
    one, other = fine.pairs[p].T
    reach = fine.touching[p, 0, 0] + CHECK_MARGIN + FAR
    apart = points[one, :, k, AT_SLICES] - points[other, :, k, AT_SLICES]
    between = np.sqrt((apart * apart).sum(axis=1)) - moved[one, k] - moved[other, k]
    close = np.flatnonzero(between.min(axis=-1, initial=np.inf) < reach)
    p, k, one, other = p[close], k[close], one[close], other[close]
    apart = points[one, :, k] - points[other, :, k]
    clearance = np.sqrt((apart * apart).sum(axis=1)) - fine.touching[p, 0]
    exact = fine.exact[fine.pairs[p]].min(axis=1)
    np.minimum.at(least, k, excess(clearance, fine.pair_kinds[p, k], exact, batch.required))


def _to_body(batch: Batch, fine: Geometry, points: Array, frames: list[Frame], number: int, least: Array) -> None:
    body, kinds = fine.bodies[number], fine.body_kinds[number]
    axes, origin = fine.body_frame(points.shape[1:], frames, number)
    away = points[body.meets] - origin
    reach = fine.radius[body.meets, 0] + body.extent + CHECK_MARGIN + FAR
    near = np.sqrt((away * away).sum(axis=1).min(axis=-1)) < reach
    n, k = np.nonzero(near & (kinds != NEVER))
    clearance = body.distance_at(axes, away[n, :, k], k) - fine.radius[body.meets[n], 0]
    np.minimum.at(least, k, excess(clearance, kinds[n, k], fine.exact[body.meets[n]], batch.required))


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
    from scipy.interpolate import CubicSpline

    values = CubicSpline(np.arange(batch.slices + 1), paths, axis=1, bc_type="clamped")(batch.times)
    joints = batch.joints
    beyond = np.maximum(values - joints.upper[:, None], joints.lower[:, None] - values)
    step = np.abs(np.diff(paths, axis=1)) - joints.step[:, None]
    clearance = np.concatenate([
        swept_clearance(batch.take(index), values[index])
        for index in (np.arange(k, min(k + chunk, len(batch))) for k in range(0, len(batch), chunk))
    ])
    return Sweep(clearance, beyond.max(axis=(1, 2), initial=-np.inf), step.max(axis=(1, 2), initial=-np.inf))
