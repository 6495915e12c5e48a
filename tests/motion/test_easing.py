"""Phases begin and end without a jump in acceleration, on the same curve and no slower."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from tamplang import load
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.geometry.splines import ClampedSpline
from tamplang.runtime.planner.motion.end_conditions import eased, swept_weights
from tamplang.runtime.planner.motion.time_scaling import peaks, shortest_duration
from tamplang.runtime.skeleton import PhasePath

EXAMPLES = Path(__file__).parents[2] / "examples"
TEXT = """
import std.crawler
import std.rules

task t() {
    base floor: box(2 m, 2 m, 0.1 m) at (0, 0, 0)
    crawler c: A on floor at (0, 0)
    goal (on floor c.B)
}
"""
WORLD = compile_text(TEXT, "t.tamp", None, {})[0].world


def swing(amplitude: float, bend: float) -> PhasePath:
    """From rest to rest, by the least acceleration, with a wave of size `bend` on the way."""
    s = np.linspace(0.0, 1.0, 21)
    rows = np.tile([*WORLD.modules["c"].pose, *WORLD.modules["c"].joints], (21, 1))
    rows[:, 9] += amplitude * (3.0 * s**2 - 2.0 * s**3)
    rows[:, 11] += bend * np.sin(np.pi * s) ** 2
    return PhasePath({"c": rows}, {}, shortest_duration(WORLD, {"c": rows}))


@settings(max_examples=25, deadline=None)
@given(st.floats(-1.5, 1.5), st.floats(-1.0, 1.0))
def test_accelerations_vanish_at_both_ends(amplitude: float, bend: float) -> None:
    path = swing(amplitude, bend)
    (motion,) = eased(WORLD, [path])
    values = motion.modules["c"][:, 7:]
    curve = ClampedSpline(np.linspace(0.0, motion.duration, len(values)), values)
    assert np.abs(curve(np.array([0.0, motion.duration]), 2)).max() < 1e-9
    assert (peaks(values)[0] <= np.array([j.speed for j in WORLD.modules["c"].type.joints]) * motion.duration).all()
    assert values[[0, -1]] == pytest.approx(path.modules["c"][[0, -1], 7:])


@pytest.mark.parametrize("bend", [0.0, 0.6, -1.0])
def test_the_curve_stays(bend: float) -> None:
    path = swing(1.0, bend)
    (motion,) = eased(WORLD, [path])
    before = ClampedSpline(np.linspace(0.0, 1.0, 21), path.modules["c"][:, 7:])(np.linspace(0.0, 1.0, 4001))
    for row in motion.modules["c"][:, 7:]:
        assert np.linalg.norm(before - row, axis=1).min() < 1e-3


@pytest.mark.parametrize("bend", [0.6, -1.0])
def test_what_is_checked_is_what_is_stored(bend: float) -> None:
    path = swing(1.0, bend)
    path.modules["c"][1:-1, 10] += 0.1 * (-1.0) ** np.arange(19)
    (motion,) = eased(WORLD, [path])
    stored = motion.modules["c"][:, 7:]
    curve, own = (
        CubicSpline(np.linspace(0.0, 1.0, len(values)), values, bc_type="clamped")(np.linspace(0.0, 1.0, 40001))
        for values in (stored, path.modules["c"][:, 7:])
    )
    looked_at = swept_weights(20, 10) @ path.modules["c"][:, 7:]
    off = [max(np.abs(line - row).max(axis=1).min() for row in looked_at) for line in (curve, own)]
    assert len(looked_at) == 201 and off[0] < 1e-4 < off[1]


def test_the_least_acceleration_becomes_the_least_jerk() -> None:
    path = swing(1.0, 0.0)
    (motion,) = eased(WORLD, [path])
    assert motion.duration <= path.duration
    u = np.linspace(0.0, 1.0, len(motion.modules["c"]))
    expected = path.modules["c"][0, 9] + 10.0 * u**3 - 15.0 * u**4 + 6.0 * u**5
    assert motion.modules["c"][:, 9] == pytest.approx(expected, abs=1e-3)


def test_time_to_spare_stays() -> None:
    path = swing(1.0, 0.3)
    (quick,), (slow,) = eased(WORLD, [path]), eased(WORLD, [PhasePath(path.modules, {}, path.duration + 2.0)])
    assert slow.duration == pytest.approx(quick.duration + 2.0)


def test_the_seams_of_a_plan_are_smooth() -> None:
    plan = load(EXAMPLES / "climb.tamp", n=4, crawlers=1).solve(horizon=2).plan
    assert plan is not None and len(plan.record.windows) >= 2
    curves = [CubicSpline(s.knots, s.values, bc_type="clamped") for s in plan.record.splines]
    assert len(curves) == len(plan.record.phases) >= 3
    for before, after in pairwise(curves):
        for order in (0, 1, 2):
            assert before(before.x[-1], order) == pytest.approx(after(after.x[0], order), abs=1e-4)
