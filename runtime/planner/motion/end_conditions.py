"""Phases that begin and end gently: not only their speeds but also their accelerations are zero at switches."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ....compiler.ir import World
from ...geometry.resampling import between
from ...geometry.splines import spline_weights
from ...skeleton import Array, PhasePath
from .settings import ACCEPTANCE
from .time_scaling import second_derivatives, shortest_duration


def eased(world: World, paths: Sequence[PhasePath]) -> list[PhasePath]:
    """The same curves, run through by another law of time: one that turns the motion from rest to rest of least
    acceleration, 3s² - 2s³, into that of least jerk, 10u³ - 15u⁴ + 6u⁵, whose accelerations are no greater. Each phase
    takes as long as its joints need, but not less than before when it had time to spare."""
    return [_eased(world, path) for path in paths]


def _eased(world: World, path: PhasePath) -> PhasePath:
    motion = eased_samples(path)
    spare = path.duration - shortest_duration(world, path.modules)
    motion.duration = shortest_duration(world, motion.modules) + max(0.0, spare)
    return motion


def eased_samples(path: PhasePath) -> PhasePath:
    """The samples of the eased motion, as they are stored; it takes as long as the path does."""
    count = path.samples - 1
    even, times = np.linspace(0.0, 1.0, count + 1), _times(count)
    modules = {
        name: np.hstack([between(even, rows[:, :7], times), eased_weights(count) @ rows[:, 7:]])
        for name, rows in path.modules.items()
    }
    bodies = {name: between(even, rows, times) for name, rows in path.bodies.items()}
    return PhasePath(modules, bodies, path.duration)


@lru_cache(maxsize=16)
def eased_weights(slices: int) -> Array:
    """The matrix from the joint values `(slices + 1, n)` of a path to those of its eased motion,
    `(eased_density * slices + 1, n)`."""
    return settled(spline_weights(slices, slices * _times(slices)))


@lru_cache(maxsize=16)
def swept_weights(slices: int, refinement: int) -> Array:
    """The matrix from the joint values `(slices + 1, n)` of a path to those of the spline of its eased motion, which is
    the one that is stored, `(slices * refinement + 1, n)`: at instants when the path is at even times."""
    knots = ACCEPTANCE.eased_density * slices
    shares = np.linspace(0.0, 1.0, ACCEPTANCE.samples * slices + 1)
    instants = np.interp(np.linspace(0.0, 1.0, slices * refinement + 1), _law(shares), shares)
    return np.asarray(spline_weights(knots, knots * instants) @ eased_weights(slices))


def _times(slices: int) -> Array:
    return _law(np.linspace(0.0, 1.0, ACCEPTANCE.eased_density * slices + 1))


def _law(u: Array) -> Array:
    """s with 3s² - 2s³ = 10u³ - 15u⁴ + 6u⁵."""
    return np.asarray(0.5 - np.sin(np.arcsin(np.clip(1.0 - 2.0 * least_jerk(u), -1.0, 1.0)) / 3.0))


def least_jerk(u: Array) -> Array:
    """10u³ - 15u⁴ + 6u⁵: how far the motion of least jerk from rest to rest has come at the share u of its time."""
    return np.asarray(u**3 * (10.0 + u * (6.0 * u - 15.0)))


def settled(values: Array) -> Array:
    """Values `(S + 1, n)` whose clamped spline has no second derivative at its ends: the second and the last but one
    are moved, by what the samples leave of it."""
    last = len(values) - 1
    bends = second_derivatives(last)[[0, last]]
    moved = values.copy()
    moved[[1, last - 1]] -= np.linalg.solve(bends[:, [1, last - 1]], bends @ values)
    return moved
