"""The time of a phase against dense samples of its spline."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from tamplang.compiler.ir import Joint, Module, ModuleType, World
from tamplang.runtime.planner.motion.settings import ACCEPTANCE
from tamplang.runtime.planner.motion.time_scaling import peaks, shortest_duration

SHORTEST = ACCEPTANCE.shortest_phase

HERE = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
JOINT = Joint("j", "revolute", -1, HERE, (0.0, 0.0, 1.0), -9.0, 9.0, 0.0, speed=2.0, acceleration=5.0)


def scene(**limits: float) -> World:
    kind = ModuleType("arm", (replace(JOINT, **limits),), (), ())
    return World({"arm": Module("arm", kind, HERE, (0.0,))}, {})


def rows(values: list[float]) -> dict[str, np.ndarray]:
    return {"arm": np.column_stack([np.tile(HERE, (len(values), 1)), values])}


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=24))
def test_peaks_are_those_of_dense_samples(values: list[float]) -> None:
    spline = CubicSpline(np.linspace(0, 1, len(values)), values, bc_type="clamped")
    times = np.linspace(0, 1, 2000 * (len(values) - 1) + 1)
    speed, acceleration = peaks(np.array(values)[:, None])
    for exact, order in ((speed[0], 1), (acceleration[0], 2)):
        sampled = np.abs(spline(times, order)).max()
        assert sampled <= exact + 1e-9 * (1 + exact)
        assert exact == pytest.approx(sampled, rel=1e-4, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=24), st.floats(0.1, 9.0), st.floats(0.1, 90.0))
def test_a_phase_keeps_both_limits_and_is_not_slower_than_one_of_them_asks(
    values: list[float], speed: float, acceleration: float
) -> None:
    seconds = shortest_duration(scene(speed=speed, acceleration=acceleration), rows(values))
    spline = CubicSpline(np.linspace(0, seconds, len(values)), values, bc_type="clamped")
    times = np.linspace(0, seconds, 200 * len(values))
    fastest, hardest = (float(np.abs(spline(times, order)).max()) for order in (1, 2))
    assert fastest <= speed and hardest <= acceleration
    faster = (seconds - 0.01) / seconds
    assert seconds == SHORTEST or fastest >= 0.99 * faster * speed or hardest >= 0.99 * faster**2 * acceleration


def test_what_rests_takes_the_least_time_and_joints_without_limits_too() -> None:
    assert shortest_duration(scene(), rows([1.0] * 5)) == SHORTEST
    assert shortest_duration(scene(speed=math.inf, acceleration=math.inf), rows([0.0, 1.0, 2.0])) == SHORTEST
