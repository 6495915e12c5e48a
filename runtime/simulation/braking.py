"""Breaking off a motion: to rest along the same path, as soon as can be or by a given time."""

from __future__ import annotations

import math

import numpy as np

from ...compiler import ir
from ..planner.motion.time_scaling import peaks
from ..skeleton import Array, Configuration, PhasePath
from .settings import SIMULATION
from .world import spline_values


def braked(world: ir.World, path: PhasePath, seconds: float) -> PhasePath:
    """The motion that follows `path` for `seconds` and then slows down along it until it rests, before its end, within
    the limits of speed and acceleration. Where that is impossible on what is left of the path, it is carried on to its
    end."""
    length = braking_time(world, path, seconds)
    left = path.duration - seconds
    for _ in range(SIMULATION.brake_tries):
        if length >= 2.0 * left:
            break
        slowed = _slowed(path, seconds, length)
        if within_limits(world, slowed):
            return slowed
        length *= SIMULATION.brake_growth
    return path


def _slowed(path: PhasePath, seconds: float, length: float) -> PhasePath:
    """To rest over `length` seconds from `seconds` on."""
    total = seconds + length
    count = max(8, math.ceil(total / SIMULATION.brake_knot))
    times = np.linspace(0.0, total, count + 1)
    return at_times(path, np.minimum(resting(times, seconds, length), path.duration), total)


def resting(times: Array, seconds: float, length: float) -> Array:
    """How far along a motion one is at `times` that comes to rest over `length` seconds from `seconds` on."""
    share = np.clip((times - seconds) / length, 0.0, 1.0)
    return np.asarray(np.minimum(times, seconds) + length * (share - share**3 + 0.5 * share**4))


def within_limits(world: ir.World, path: PhasePath) -> bool:
    """Whether every joint keeps its greatest speed and acceleration on a motion."""
    for name, rows in path.modules.items():
        joints = world.modules[name].type.joints
        if not joints:
            continue
        speeds, changes = peaks(rows[:, 7:])
        for speed, change, joint in zip(speeds / path.duration, changes / path.duration**2, joints, strict=True):
            if speed > joint.speed or change > joint.acceleration:
                return False
    return True


def stopped(world: ir.World, path: PhasePath, seconds: float) -> PhasePath:
    """The motion that follows `path` for as long as it can and rests after `seconds`, within the limits of speed and
    acceleration. `path` begins at rest; where too little time is left to follow it at its own pace, less of it is
    gone, or nothing."""
    times = np.linspace(0.0, seconds, max(8, math.ceil(seconds / SIMULATION.brake_knot)) + 1)
    length = braking_time(world, path, seconds)
    for _ in range(SIMULATION.brake_tries):
        if length >= seconds:
            break
        slowed = at_times(path, np.minimum(resting(times, seconds - length, length), path.duration), seconds)
        if within_limits(world, slowed):
            return slowed
        length *= SIMULATION.brake_growth
    share = times / seconds
    gone = 0.5 * seconds
    for _ in range(SIMULATION.brake_tries):
        slowed = at_times(path, gone * (3.0 * share**2 - 2.0 * share**3), seconds)
        if within_limits(world, slowed):
            return slowed
        gone /= SIMULATION.brake_growth
    return at_times(path, np.zeros_like(times), seconds)


def reversed_path(world: ir.World, path: PhasePath, share: float) -> PhasePath:
    """Back along the last `share` of a motion, which ends at rest, to rest again."""
    count = path.samples
    back = np.linspace(0.0, 1.0, count)
    back = path.duration * (1.0 - share * (3.0 * back**2 - 2.0 * back**3))
    result = at_times(path, back, share * path.duration)
    while not within_limits(world, result):
        result = PhasePath(result.modules, result.bodies, SIMULATION.brake_growth * result.duration)
    return result


def first_part(path: PhasePath, share: float) -> PhasePath:
    """The first `share` of a motion, from rest to rest, on the same way."""
    count = path.samples
    return at_times(path, np.linspace(0.0, share * path.duration, count), share * path.duration)


def waiting(configuration: Configuration, seconds: float) -> PhasePath:
    """No motion."""
    rows = {name: np.tile(state, (5, 1)) for name, state in configuration.modules.items()}
    return PhasePath(rows, {}, seconds)


def braking_time(world: ir.World, path: PhasePath, seconds: float) -> float:
    """Seconds until rest in which the brake alone keeps the limits of acceleration."""
    longest = SIMULATION.brake_shortest
    for name, rows in path.modules.items():
        joints = world.modules[name].type.joints
        if not joints:
            continue
        speeds = np.abs(spline_values(rows[:, 7:], path.duration, np.array([seconds]), 1))[0]
        for speed, joint in zip(speeds, joints, strict=True):
            limit = joint.acceleration if math.isfinite(joint.acceleration) else joint.speed / SIMULATION.brake_quick
            longest = max(longest, 1.5 * float(speed) / limit)
    return longest


def at_times(path: PhasePath, times: Array, duration: float) -> PhasePath:
    """A motion whose equidistant knots are the points of `path` at `times`."""
    shares = np.linspace(0.0, path.duration, path.samples)

    def rows(poses: Array) -> Array:
        return np.column_stack([np.interp(times, shares, column) for column in poses.T])

    modules = {
        name: np.hstack([rows(values[:, :7]), spline_values(values[:, 7:], path.duration, times)])
        for name, values in path.modules.items()
    }
    return PhasePath(modules, {name: rows(poses) for name, poses in path.bodies.items()}, duration)
