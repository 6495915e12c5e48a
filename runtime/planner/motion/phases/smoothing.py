"""Levenberg-Marquardt on the joint paths of many phases at once: squared accelerations, homing and penalties."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .....langs.frozen import dataclass
from ....budget import Budget
from ....skeleton import Array
from ..nlp.banded_cholesky import factored, solved
from .batch_kinematics import Indices
from .penalty import Penalty, penalty
from .phase_batch import Batch
from .settings import PHASES


@dataclass(frozen=True, slots=True)
class Schedule:
    """Penalty weight, grown tenfold every `every` iterations up to `greatest`; iterations; relative tolerance;
    largest change of a joint per iteration; by how much more than the margin everything keeps clear."""

    weight: float = 1e3
    greatest: float = 1e5
    every: int = 5
    iterations: int = 40
    tolerance: float = 3e-3
    largest_step: float = 0.5
    widening: float = 1.0


def cost_matrix(slices: int) -> Array:
    """The matrix `(slices + 1, slices + 1)` of the quadratic cost of one joint's values: squared accelerations with
    zero velocity at both ends, and the squared distance from home."""
    differences = np.zeros((slices + 1, slices + 1))
    for t in range(slices + 1):
        differences[t, min(t + 1, slices)] += 1.0
        differences[t, t] -= 2.0
        differences[t, max(t - 1, 0)] += 1.0
    span = 1.0 / slices
    accelerations = (PHASES.acceleration_weight * span**-1.5) ** 2 * differences.T @ differences
    return np.asarray(accelerations + PHASES.homing_weight**2 * span * np.eye(slices + 1))


def path_cost(batch: Batch, paths: Array) -> Array:
    """The cost `(phases,)` of paths `(phases, slices + 1, joints)`."""
    away = paths - batch.joints.home[:, None]
    return np.asarray(0.5 * (away * np.einsum("st,btj->bsj", cost_matrix(batch.slices), away)).sum(axis=(1, 2)))


class _Normal:
    """The normal equations of the smooth cost, to which the penalties' blocks are added, in banded form."""

    def __init__(self, slices: int, joints: int) -> None:
        self.joints, self.inner = joints, slices - 1
        self.cost = cost_matrix(slices)
        self.band = np.zeros((self.inner, joints, 2 * joints + 1))
        smooth = self.cost[1:-1, 1:-1]
        for d in range(min(3, self.inner)):
            for t in range(self.inner - d):
                self.band[t, :, d * joints] = smooth[t + d, t]
        self.row, self.column = np.tril_indices(joints)

    def smooth(self, batch: Batch, inner: Array) -> tuple[Array, Array]:
        """Cost `(phases,)` and its gradient at the inner slices."""
        away = batch.with_ends(inner) - batch.joints.home[:, None]
        gradient = np.einsum("st,btj->bsj", self.cost, away)
        return 0.5 * (away * gradient).sum(axis=(1, 2)), gradient[:, 1:-1]

    def step(self, hessian: Array, gradient: Array, damping: Array) -> Array:
        """The damped Newton step of every phase; they do not couple, so one banded factorisation treats them all."""
        phases = len(hessian)
        band = np.broadcast_to(self.band, (phases, *self.band.shape)).copy()
        band[:, :, self.column, self.row - self.column] += hessian[:, :, self.row, self.column]
        band[:, :, :, 0] += damping[:, None, None]
        width = 2 * self.joints + 1
        factor = factored(band.reshape(-1, width))
        if factor is None:
            return np.zeros_like(gradient)
        return solved(factor, -gradient.reshape(-1)).reshape(gradient.shape)


@dataclass(slots=True)
class _State:
    """Phases that are still being improved: where they are, cost and slope of the smooth part, and penalties."""

    inner: Array
    cost: Array
    slope: Array
    penalty: Penalty

    @property
    def total(self) -> Array:
        return self.cost + self.penalty.value

    @property
    def gradient(self) -> Array:
        return self.slope + self.penalty.gradient

    def take(self, keep: Indices) -> _State:
        return _State(self.inner[keep], self.cost[keep], self.slope[keep], self.penalty.take(keep))

    def replaced(self, where: NDArray[np.bool_], other: _State) -> _State:
        wide = where[:, None, None]
        return _State(
            np.where(wide, other.inner, self.inner), np.where(where, other.cost, self.cost),
            np.where(wide, other.slope, self.slope), self.penalty.replaced(where, other.penalty),
        )


def smooth_paths(batch: Batch, inner: Array, schedule: Schedule, budget: Budget) -> tuple[Array, int]:
    """Improve inner slices `(phases, slices - 1, joints)`; returns them and the iterations of the longest phase.
    Every phase has its own damping and stops on its own, whatever the others do."""
    size = max(1, PHASES.lot // max(1, len(batch.coarse.radius) * batch.looks.shares.shape[1]))
    found = [
        _smooth(batch.take(index), inner[index], schedule, budget)
        for index in (np.arange(k, min(k + size, len(batch))) for k in range(0, len(batch), size))
    ]
    return np.concatenate([paths for paths, _ in found]), max(count for _, count in found)


def _smooth(batch: Batch, inner: Array, schedule: Schedule, budget: Budget) -> tuple[Array, int]:
    normal = _Normal(batch.slices, inner.shape[2])
    result = inner.copy()
    active = np.arange(len(batch))
    damping = np.ones(len(batch))
    weight = schedule.weight

    def evaluate(where: Batch, at: Array) -> _State:
        return _State(at, *normal.smooth(where, at), penalty(where, at, weight, schedule.widening))

    state = evaluate(batch, inner)
    iteration = 0
    for iteration in range(1, schedule.iterations + 1):
        budget.check()
        step = normal.step(state.penalty.hessian, state.gradient, damping)
        scale = np.minimum(1.0, schedule.largest_step / np.maximum(np.abs(step).max(axis=(1, 2)), 1e-12))
        slope = (state.gradient * step).sum(axis=(1, 2))
        curvature = -slope - damping * (step**2).sum(axis=(1, 2))
        predicted = np.minimum(scale * slope + 0.5 * scale**2 * curvature, -1e-300)
        trial = evaluate(batch, state.inner + scale[:, None, None] * step)
        before = state.total
        change = trial.total - before
        ratio = change / predicted
        better = (ratio > 0.05) | (np.abs(change) < 1e-9 * np.abs(before))
        ended = better & (-change < schedule.tolerance * np.abs(before) + 1e-6) & (scale == 1.0)
        state = state.replaced(better, trial)
        ended &= (weight >= schedule.greatest) | (state.penalty.value <= PHASES.no_penalty)
        factor = np.where(better, np.where(ratio > 0.7, 0.2, np.where(ratio < 0.25, 3.0, 1.0)), 8.0)
        damping = np.clip(damping * factor, 1e-6, 1e9)
        ended |= damping > 1e7
        if iteration >= PHASES.patience:
            ended |= state.penalty.overlap > PHASES.stuck
        result[active] = state.inner
        if ended.all():
            break
        if ended.any():
            keep = np.flatnonzero(~ended)
            active, damping, state, batch = active[keep], damping[keep], state.take(keep), batch.take(keep)
        if iteration % schedule.every == 0 and weight < schedule.greatest:
            weight *= 10.0
            state = evaluate(batch, state.inner)
    return result, iteration
