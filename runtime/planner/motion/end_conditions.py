"""Phases that begin and end gently: not only their speeds but also their accelerations are zero at switches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....compiler.ir import World
from ...geometry.resampling import between
from ...geometry.splines import ClampedSpline
from ...skeleton import Array, PhasePath
from .settings import ACCEPTANCE
from .time_scaling import second_derivatives, shortest_duration


def eased(world: World, paths: Sequence[PhasePath]) -> list[PhasePath]:
    """The same curves, run through by another law of time: one that turns the motion from rest to rest of least
    acceleration, 3s² - 2s³, into that of least jerk, 10u³ - 15u⁴ + 6u⁵, whose accelerations are no greater. Each phase
    takes as long as its joints need, but not less than before when it had time to spare."""
    return [_eased(world, path) for path in paths]


def _eased(world: World, path: PhasePath) -> PhasePath:
    count = path.samples - 1
    even, times = np.linspace(0.0, 1.0, count + 1), _law(np.linspace(0.0, 1.0, ACCEPTANCE.eased_density * count + 1))
    modules = {}
    for name, rows in path.modules.items():
        joints = settled(ClampedSpline(even, rows[:, 7:])(times))
        modules[name] = np.hstack([between(even, rows[:, :7], times), joints])
    bodies = {name: between(even, rows, times) for name, rows in path.bodies.items()}
    spare = path.duration - shortest_duration(world, path.modules)
    return PhasePath(modules, bodies, shortest_duration(world, modules) + max(0.0, spare))


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
