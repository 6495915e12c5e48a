"""A robot of a millimetre and one of a hundred metres behave as one of a metre does; and the verifier measures small
ones by their size."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.bounds.length_unit import LengthUnit, length_unit
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve
from tamplang.runtime.skeleton import start_configuration
from tamplang.runtime.verify.findings import Findings
from tamplang.runtime.verify.limits import share_of

TEXT = """
import std.rules
module gx(s: length = 1 m) {
    effector A: gripper sphere(0.05 * s) normal (0, 0, -1)
    link (0, 0, s)
    joint dx: prismatic(x) in 0 m .. 2 * s home s * 0.5 speed s / 1 s
    joint dy: prismatic(y) in -s .. s speed s / 1 s
    joint dz: prismatic(z) in -0.95 * s .. 0 m home -0.3 * s speed s / 1 s
    joint turn: revolute(z) in -90 deg .. 90 deg
    effector B: gripper sphere(0.02 * s) normal (0, 0, -1)
    fact (linked A B)
}
task t(s: length = 1 m) {
    object foot: box(0.2 * s, 0.2 * s, 0.05 * s) at (0, 0, -0.025 * s)
    object table: box(0.5 * s, 1.5 * s, 0.1 * s) at (1.7 * s, 0, 0.03 * s)
    object tray1: box(0.5 * s, 1.5 * s, 0.1 * s) at (0.7 * s, 0, 0.03 * s)
    fact (tray tray1)
    object it: box(0.1 * s, 0.1 * s, 0.1 * s) on table
    fact (grippable it)
    object post: box(0.05 * s, 0.05 * s, 0.6 * s) at (1.2 * s, 0, 0.3 * s)
    gx(s = s) g: A on foot
    goal (on tray1 it)
}
"""
SIZES = {"1 mm": 1e-3, "100 m": 100.0}


def _problem(folder: Path, size: str) -> Problem:
    file = folder / "scale.tamp"
    file.write_text(TEXT)
    return compile_problem(file, "t", {"s": size.replace(" ", "")})[0]


def _solved(problem: Problem) -> Outcome:
    outcome = solve(problem, SolveOptions(seed=1, time=60.0))
    assert outcome.status == "solved" and outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
    return outcome


@pytest.mark.parametrize("size", SIZES)
def test_a_robot_of_any_size_picks_and_places(tmp_path: Path, size: str) -> None:
    plan = _solved(_problem(tmp_path, size)).plans[0]
    goal = next(b for b in reversed(plan.body_tracks) if b.name == "it").poses[-1]
    assert abs(goal[0] / SIZES[size] - 0.7) < 0.25 and abs(goal[2] / SIZES[size] - 0.13) < 0.01


def test_poses_come_back_as_they_went(tmp_path: Path) -> None:
    problem = _problem(tmp_path, "20 m")
    unit = LengthUnit(problem)
    assert unit.metres == length_unit(problem) > 10.0
    there = start_configuration(unit.problem)
    for name, slot in unit.configuration(start_configuration(problem)).modules.items():
        assert np.allclose(slot, there.modules[name])
    assert LengthUnit(_problem(tmp_path, "1 m")).plain


def test_a_small_robot_may_not_pass_through_what_is_thinner_than_the_usual_limit(tmp_path: Path) -> None:
    small, usual = (share_of(_problem(tmp_path, size).world) for size in ("1 mm", "1 m"))
    assert small < 0.01 and usual == 1.0
    findings = Findings()
    findings.share = small
    assert not findings.measure("penetration_m", 1e-4, "text") and findings.measure("start_m", 1e-6, "text")
