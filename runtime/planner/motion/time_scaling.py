"""The time of a phase: as short as the limits of its joints allow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from ....compiler.ir import World
from ...geometry.splines import ClampedSpline
from ...skeleton import Array
from .settings import ACCEPTANCE


def shortest_duration(world: World, modules: Mapping[str, Array]) -> float:
    """Seconds in which no joint exceeds its speed or its acceleration, rounded up to hundredths.

    `modules` maps modules to equidistant samples `(S + 1, 7 + n)` of one phase, as in `PhasePath`. What is between is
    their cubic spline, clamped at both ends. Its accelerations are greatest at its knots, its speeds there or where the
    acceleration is zero, so that both are exact: a longer time divides speeds by its length, accelerations by the
    square.
    """
    joints = [joint for name in modules for joint in world.modules[name].type.joints]
    if not joints:
        return ACCEPTANCE.shortest_phase
    values = np.hstack([modules[name][:, 7:] for name in modules])
    speed = np.array([joint.speed for joint in joints])
    acceleration = np.array([joint.acceleration for joint in joints])
    rates, changes = peaks(values)
    by_speed = float((rates / speed).max()) / ACCEPTANCE.limit_share
    by_acceleration = math.sqrt(float((changes / acceleration).max()) / ACCEPTANCE.limit_share)
    jerk = np.array([joint.jerk for joint in joints])
    by_jerk = 0.0
    if np.isfinite(jerk).any():
        by_jerk = float((jerks(values) / jerk).max() / ACCEPTANCE.limit_share) ** (1.0 / 3.0)
    return max(ACCEPTANCE.shortest_phase, math.ceil(max(by_speed, by_acceleration, by_jerk) * 100.0) / 100.0)


def peaks(values: Array) -> tuple[Array, Array]:
    """Greatest absolute first and second derivatives `(n,)` of the clamped spline through `values` `(S + 1, n)`, by the
    phase's own time, which runs from 0 to 1."""
    count = len(values) - 1
    second = second_derivatives(count) @ values
    left, right = second[:-1], second[1:]
    first = np.diff(values, axis=0) - (2.0 * left + right) / 6.0
    change = right - left
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.clip(np.nan_to_num(-left / change), 0.0, 1.0)
    speeds = [np.abs(first + u * left + 0.5 * u * u * change) for u in (0.0, 1.0, turn)]
    return np.max(speeds, axis=(0, 1)) * count, np.abs(second).max(axis=0) * count**2


def jerks(values: Array) -> Array:
    """Greatest absolute third derivatives `(n,)` of the same, which are constant between knots."""
    count = len(values) - 1
    return np.asarray(np.abs(np.diff(second_derivatives(count) @ values, axis=0)).max(axis=0) * count**3)


@lru_cache(maxsize=16)
def second_derivatives(count: int) -> Array:
    """The matrix `(count + 1, count + 1)` from the values of a clamped spline at 0, 1 … `count` to its second
    derivatives there."""
    knots = np.arange(count + 1)
    return ClampedSpline(knots, np.eye(count + 1))(knots, 2)
