"""The penalty that keeps a path clear of obstacles, of itself, of joint limits, and where it is asked, of loads beyond
strengths, with its Gauss-Newton Hessian."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....skeleton import Array
from .batch_kinematics import Indices
from .contact_margins import Kinds
from .exact_check import near_entries
from .phase_batch import Batch, Looks
from .phase_geometry import Geometry
from .proximity import near_obstacles, near_pairs
from .settings import PHASES


@dataclass(slots=True)
class Penalty:
    """Value `(phases,)`, gradient `(phases, times, joints)`, Hessian blocks `(phases, times, joints, joints)`, and how
    deep the worst pair overlaps `(phases,)`, metres."""

    value: Array
    gradient: Array
    hessian: Array
    overlap: Array

    def take(self, keep: Indices) -> Penalty:
        return Penalty(self.value[keep], self.gradient[keep], self.hessian[keep], self.overlap[keep])

    def replaced(self, where: NDArray[np.bool_], other: Penalty) -> Penalty:
        """This one, but `other` in the phases `where`."""
        return Penalty(
            np.where(where, other.value, self.value),
            np.where(where[:, None, None], other.gradient, self.gradient),
            np.where(where[:, None, None, None], other.hessian, self.hessian),
            np.where(where, other.overlap, self.overlap),
        )


@dataclass(slots=True)
class _Rows:
    """Missed clearances of active pairs, or loads: amount, gradient `(rows, joints)`, the slice they belong to, and how
    much a missed metre counts."""

    amount: Array
    slope: Array
    place: Indices
    scale: Array


def penalty(batch: Batch, inner: Array, weight: float, widening: float = 1.0) -> Penalty:
    """Half the weighted squares of what is missed by the inner slices `(phases, slices - 1, joints)`, at the times that
    the batch looks at, against `widening` times the margin."""
    phases, slices, joints = inner.shape
    rows = _missed(batch, inner, widening * batch.margin)
    low, high = batch.inner_limits()
    over = np.maximum(inner - high[:, None], 0.0) + np.minimum(inner - low[:, None], 0.0)
    limit = PHASES.limits_above * weight
    value = 0.5 * limit * (over**2).sum(axis=(1, 2))
    gradient = limit * over
    hessian = np.zeros((phases, slices, joints, joints))
    diagonal = np.arange(joints)
    hessian[:, :, diagonal, diagonal] += limit * (over != 0.0)
    overlap, times = np.zeros(phases), batch.looks.shares.shape[1]
    np.maximum.at(overlap, rows.place // times, rows.amount - widening * batch.margin)
    if batch.loads:
        rows = _joined([rows, *_load_rows(batch, inner)])
    if len(rows.amount):
        value += 0.5 * weight * np.bincount(rows.place // times, (rows.scale * rows.amount) ** 2, phases)
        order = np.argsort(rows.place, kind="stable")
        amount, slope = (rows.scale * rows.amount)[order], (rows.scale[:, None] * rows.slope)[order]
        found, first = np.unique(rows.place[order], return_index=True)
        pull = weight * np.add.reduceat(slope * amount[:, None], first)
        squares = weight * np.array([rows.T @ rows for rows in np.split(slope, first[1:])])
        _spread(batch.looks, found, pull, squares, gradient, hessian)
    return Penalty(value, gradient, hessian, overlap)


def _spread(looks: Looks, place: Indices, pull: Array, squares: Array, gradient: Array, hessian: Array) -> None:
    """Add gradients `(m, joints)` and Hessians at looked-at places to those of the inner slices. The Hessian of a time
    between slices is spread over the slices around it, without what couples them, so that it is none too small."""
    joints = gradient.shape[2]
    if looks.weights is None:
        gradient.reshape(-1, joints)[place] += pull
        hessian.reshape(-1, joints, joints)[place] += squares
        return
    phase, time = np.divmod(place, len(looks.weights))
    weights = looks.weights[time, 1:-1]
    size = np.abs(weights)
    size = np.where(size > PHASES.negligible, size * size.sum(axis=1, keepdims=True), 0.0)
    row, slice_ = np.nonzero(np.abs(weights) > 0.0)
    np.add.at(gradient, (phase[row], slice_), weights[row, slice_][:, None] * pull[row])
    row, slice_ = np.nonzero(size)
    np.add.at(hessian, (phase[row], slice_), size[row, slice_][:, None, None] * squares[row])


def most_missed(batch: Batch, inner: Array) -> Array:
    """By how much the worst pair of each phase misses the margin, metres; 0: none."""
    rows = _missed(batch, inner, batch.margin)
    result = np.zeros(len(batch))
    np.maximum.at(result, rows.place // batch.looks.shares.shape[1], rows.amount)
    return result


def _missed(batch: Batch, inner: Array, margin: float) -> _Rows:
    values = _looked_at(batch, inner)
    geometry, shares = batch.coarse, batch.looks.shares
    frames = geometry.kinematics.frames(values)
    points = geometry.points.placed(frames)
    rows = [make(margin, shares, geometry, points, frames) for make in (_obstacle_rows, _pair_rows)]
    if batch.closely or batch.exact.wholes:
        rows += _exact_rows(batch, frames, margin)
    found = _joined(rows)
    return _Rows(found.amount, geometry.kinematics.by_variables(found.slope), found.place, found.scale)


def _joined(rows: Sequence[_Rows]) -> _Rows:
    return _Rows(*(np.concatenate([getattr(r, part) for r in rows]) for part in ("amount", "slope", "place", "scale")))


def _looked_at(batch: Batch, inner: Array) -> Array:
    """The joint values `(phases, times, joints)` at the times that the batch looks at."""
    if batch.looks.weights is None:
        return inner
    return np.asarray(np.einsum("ts,bsj->btj", batch.looks.weights, batch.with_ends(inner)))


def _load_rows(batch: Batch, inner: Array) -> Iterator[_Rows]:
    times = batch.looks.shares.shape[1]
    for phase, values in enumerate(_looked_at(batch, inner)):
        time, amount, slope = batch.loads[phase].missed(values)
        yield _Rows(amount, slope, phase * times + time, np.ones(len(amount)))


def _scale(shares: Array, kinds: Kinds, times: Indices) -> Array:
    """How much more than elsewhere a missed metre counts where less than the margin is asked, next to a contact: there,
    little missed is an overlap. `shares` `(kinds, times)`."""
    share = shares[kinds, times]
    return np.where(share > 0.0, 1.0 / np.maximum(share, PHASES.least_share), 1.0)


def _obstacle_rows(
    margin: float, shares: Array, geometry: Geometry, points: Array, frames: Array
) -> _Rows:
    times = points.shape[-1]
    a, o, k, t = near_obstacles(geometry, points, margin)
    at = points[a, :, k, t]
    distance, offset, excess = geometry.shapes.distance_at(at[..., None], o, k)
    kind = geometry.obstacle_kinds[a, o, k]
    missed = geometry.radius[a, 0, 0] + margin * shares[kind, t] - distance[:, 0]
    hit = np.flatnonzero(missed > 0.0)
    a, o, k, t, at = a[hit], o[hit], k[hit], t[hit], at[hit]
    normals = geometry.shapes.normals(offset[hit, :, 0], excess[hit, :, 0], o, k)
    slope = geometry.kinematics.slopes(frames, at, normals, k, t) * geometry.moved_by[a]
    return _Rows(missed[hit], -slope, k * times + t, _scale(shares, kind[hit], t))


def _pair_rows(margin: float, shares: Array, geometry: Geometry, points: Array, frames: Array) -> _Rows:
    times = points.shape[-1]
    first, second = geometry.pairs[:, 0], geometry.pairs[:, 1]
    p, k, t, normals = near_pairs(geometry, points, margin)
    distance = np.sqrt((normals * normals).sum(axis=1))
    kind = geometry.pair_kinds[p, k]
    missed = geometry.touching[p, 0, 0] + margin * shares[kind, t] - distance
    hit = np.flatnonzero(missed > 0.0)
    p, k, t, missed = p[hit], k[hit], t[hit], missed[hit]
    normals = normals[hit] / np.maximum(distance[hit], 1e-9)[:, None]
    moved_by = geometry.moved_by[first[p]].astype(float) - geometry.moved_by[second[p]]
    slope = geometry.kinematics.slopes(frames, points[first[p], :, k, t], normals, k, t) * moved_by
    return _Rows(missed, -slope, k * times + t, _scale(shares, kind[hit], t))


def _exact_rows(batch: Batch, frames: Array, margin: float) -> list[_Rows]:
    """Of the true shapes: of those for which there are no spheres by the margin, of others `closely`."""
    geometry, times = batch.exact, frames.shape[-1]
    found = []
    room = max(margin, PHASES.closely) if geometry.wholes else PHASES.closely
    for entries in near_entries(geometry, frames, np.full((len(geometry.nodes), len(batch), times), room)):
        if not batch.closely:
            entries = entries.wholes(geometry)
        wide = np.where(geometry.is_whole(entries), max(margin, PHASES.closely), PHASES.closely)
        wanted = wide * batch.looks.shares[entries.kind, entries.time]
        measured = entries.measured(geometry, frames, wanted)
        hit = np.flatnonzero(measured.exact & (measured.value < wanted))
        near, normals = entries[hit], measured.normal[hit]
        moved_by = geometry.moved_by[near.first].astype(float)
        slope = geometry.kinematics.slopes(frames, measured.on_first[hit], normals, near.phase, near.time) * moved_by
        if near.among:
            against = geometry.kinematics.slopes(frames, measured.on_second[hit], normals, near.phase, near.time)
            slope = slope - against * geometry.moved_by[near.second]
        scale = _scale(batch.looks.shares, near.kind, near.time)
        found.append(_Rows((wanted - measured.value)[hit], -slope, near.phase * times + near.time, scale))
    return found
