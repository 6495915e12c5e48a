"""The penalty that keeps a path clear of obstacles, of itself and of joint limits, with its Gauss-Newton Hessian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...skeleton import Array
from .batch import Batch
from .geometry import Geometry
from .kinematics import Indices

LIMIT_WEIGHT = 1e3
"""Weight of the squared excess over a joint limit."""


@dataclass(slots=True)
class Penalty:
    """Value `(phases,)`, gradient `(phases, times, joints)`, Hessian blocks `(phases, times, joints, joints)`."""

    value: Array
    gradient: Array
    hessian: Array

    def take(self, keep: Indices) -> Penalty:
        return Penalty(self.value[keep], self.gradient[keep], self.hessian[keep])

    def replaced(self, where: NDArray[np.bool_], other: Penalty) -> Penalty:
        """This one, but `other` in the phases `where`."""
        return Penalty(
            np.where(where, other.value, self.value),
            np.where(where[:, None, None], other.gradient, self.gradient),
            np.where(where[:, None, None, None], other.hessian, self.hessian),
        )


@dataclass(slots=True)
class _Rows:
    """Missed clearances of active pairs: amount, gradient `(rows, joints)`, and the slice they belong to."""

    amount: Array
    slope: Array
    place: Indices


def penalty(batch: Batch, inner: Array, weight: float, widening: float = 1.0) -> Penalty:
    """Half the weighted squares of what is missed at the inner slices `(phases, slices - 1, joints)`, against
    `widening` times the margin."""
    phases, times, joints = inner.shape
    geometry = batch.coarse
    frames, angular, linear = geometry.kinematics.frames(inner)
    points = geometry.points.place(frames, phases, times)
    twists = (_stacked(angular, phases, times), _stacked(linear, phases, times))
    margin = widening * batch.margin
    rows = [_obstacle_rows(margin, geometry, points, twists), _pair_rows(margin, geometry, points, twists)]
    over = np.maximum(inner - (batch.joints.upper - batch.joints.inset)[:, None], 0.0)
    over += np.minimum(inner - (batch.joints.lower + batch.joints.inset)[:, None], 0.0)
    value = 0.5 * LIMIT_WEIGHT * (over**2).sum(axis=(1, 2))
    gradient = LIMIT_WEIGHT * over
    hessian = np.zeros((phases, times, joints, joints))
    diagonal = np.arange(joints)
    hessian[:, :, diagonal, diagonal] += LIMIT_WEIGHT * (over != 0.0)
    amount = np.concatenate([r.amount for r in rows])
    if len(amount):
        slope, place = np.concatenate([r.slope for r in rows]), np.concatenate([r.place for r in rows])
        value += 0.5 * weight * np.bincount(place // times, amount**2, phases)
        order = np.argsort(place, kind="stable")
        amount, slope, place = amount[order], slope[order], place[order]
        found, first = np.unique(place, return_index=True)
        gradient.reshape(-1, joints)[found] += weight * np.add.reduceat(slope * amount[:, None], first)
        squares = np.add.reduceat(slope[:, :, None] * slope[:, None, :], first)
        hessian.reshape(-1, joints, joints)[found] += weight * squares
    return Penalty(value, gradient, hessian)


def _stacked(vectors: list[Array], phases: int, times: int) -> Array:
    result = np.empty((len(vectors), 3, phases, times))
    for k, vector in enumerate(vectors):
        result[k] = vector
    return result


def _slopes(
    geometry: Geometry, twists: tuple[Array, Array], spheres: Indices, points: Array, normals: Array,
    phase: Indices, time: Indices,
) -> Array:
    """How fast each joint carries points `(m, 3)` of the given spheres along normals `(m, 3)`: `(m, joints)`."""
    angular, linear = (t[:, :, phase, time] for t in twists)
    moment = np.cross(points, normals)
    slope = np.einsum("jcm,mc->mj", angular, moment) + np.einsum("jcm,mc->mj", linear, normals)
    return np.asarray(slope * geometry.moved_by[spheres])


def _obstacle_rows(margin: float, geometry: Geometry, points: Array, twists: tuple[Array, Array]) -> _Rows:
    times = points.shape[-1]
    wanted = geometry.radius[:, None] + margin * geometry.obstacle_share[..., 1:-1]
    a, o, k, t = np.nonzero(geometry.shapes.boxed(points, wanted))
    distance, offset, excess = geometry.shapes.distance_at(points[a, :, k, t][..., None], o, k)
    missed = wanted[a, o, k, t] - distance[:, 0]
    hit = np.flatnonzero(missed > 0.0)
    a, o, k, t = a[hit], o[hit], k[hit], t[hit]
    normals = geometry.shapes.normals(offset[hit, :, 0], excess[hit, :, 0], o, k)
    slope = _slopes(geometry, twists, a, points[a, :, k, t], normals, k, t)
    return _Rows(missed[hit], -slope, k * times + t)


def _pair_rows(margin: float, geometry: Geometry, points: Array, twists: tuple[Array, Array]) -> _Rows:
    times = points.shape[-1]
    first, second = geometry.pairs[:, 0], geometry.pairs[:, 1]
    apart = points[first] - points[second]
    distance = np.sqrt((apart * apart).sum(axis=1))
    missed = geometry.touching + margin * geometry.pair_share[..., 1:-1] - distance
    p, k, t = np.nonzero(missed > 0.0)
    normals = apart[p, :, k, t] / np.maximum(distance[p, k, t], 1e-9)[:, None]
    slope = _slopes(geometry, twists, first[p], points[first[p], :, k, t], normals, k, t)
    slope -= _slopes(geometry, twists, second[p], points[second[p], :, k, t], normals, k, t)
    return _Rows(missed[p, k, t], -slope, k * times + t)
