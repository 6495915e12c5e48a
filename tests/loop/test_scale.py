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


PUSH = """
import std.logic
import std.motion
type crate < object
type pad < region
type ram < effector
type wheelset < effector
predicate (behind A: ram, X: crate)
predicate (delivered X: crate)

module rover(s: length = 1 m) {
    effector W: wheelset box(0.002 * s, 0.002 * s, 0.002 * s) normal (0, 0, -1)
    joint drive: planar(x, y) in (-3 * s, -3 * s) .. (3 * s, 3 * s)
    link 0.03 * s
    link 0.12 * s: box(0.3 * s, 0.24 * s)
    effector bumper: ram box(0.02 * s, 0.24 * s, 0.06 * s) at (0.17 * s, 0, -0.06 * s) normal (1, 0, 0)
}
placement (W: wheelset) on (Y: object) { (support W), (on Y W), [stable Y W], [rolls W Y] }
motion [rolls W Y: object] borne rest {
    during bottom(W) = top(Y)
    during axis(W, z) = (0, 0, -1)
}
## The ram A is flat against X.
motion [against A: ram, X: crate] {
    at switch gap(A, X) = 0
    at switch dot(axis(A, z), axis(X, x)) >= 0.999
    at switch abs(dot(position(X) - position(A), axis(X, y))) <= radius(X) / 8
    keep pose(X, A)
}
motion [glides X Y: object] {
    during bottom(X) = top(Y)
    during axis(X, z) = (0, 0, 1)
}
motion [arrived X: crate, Y: pad] {
    at switch norm(position(X) - position(Y)) <= radius(X)
}
rule approach(A: ram, X: crate, F: object) {
    pre   not (behind A X), (on F X)
    post  (behind A X), [against A X], not [stable F X], [glides X F]
}
rule push(A: ram, X: crate, F: object, Y: pad) {
    pre   (behind A X), (on F X)
    post  (delivered X), [arrived X Y]
}
rule back(A: ram, X: crate, F: object) {
    pre   (behind A X), (delivered X), (on F X)
    post  not (behind A X), not [against A X], not [glides X F], [stable F X]
}
task push(s: length = 1 m) {
    object floor: box(6 * s, 6 * s, 0.04 * s) at (0, 0, -0.02 * s)
    crate box1: box(0.3 * s, 0.3 * s, 0.2 * s) on floor at (1 * s, 0.4 * s)
    pad spot: box(0.4 * s, 0.4 * s, 0.001 * s) at (2.2 * s, 0.6 * s, 0.0005 * s)
    object pillar: cylinder(0.15 * s, 0.5 * s) on floor at (1.6 * s, 0.1 * s)
    rover(s = s) r: W on floor
    goal (delivered box1), not (behind r.bumper box1)
}
"""


@pytest.mark.parametrize("size", ["1mm", "2cm", "30m"])
def test_a_rover_of_any_size_pushes_a_crate_over_the_floor(tmp_path: Path, size: str) -> None:
    """What rows hold in contact while they last is known in any unit of length; a rover of 6 mm that drives 12 cm is
    small."""
    file = tmp_path / "push.tamp"
    file.write_text(PUSH)
    problem = compile_problem(file, "push", {"s": size})[0]
    assert not LengthUnit(problem).plain
    _solved(problem)


HALL = """
import std.mobile
task t(range: length = 8 m) {
    object floor: box(12 m, 8 m, 0.1 m) at (0, 0, -0.05 m)
    object low: box(2 m, 2 m, 0.3 m) at (0, -1.45 m, 0.15 m)
    object high: box(2 m, 2 m, 0.3 m) at (0, 1.45 m, 0.15 m)
    for k in 1 .. 2 {
        place slot[k]: box(0.4 m, 0.4 m, 1 mm) at (2.5 m, 0.8 m * (k - 1), 0.5 mm)
        mobileBase(range = range) p[k]: W on floor at (-2.5 m, 0.8 m * (2 - k))
    }
    goal forall k in 1 .. 2 { (parked p[k].M slot[k]) }
}
"""


@pytest.mark.parametrize("range_", ["4.9m", "15m"])
def test_how_far_a_plate_may_drive_does_not_make_it_wind(tmp_path: Path, range_: str) -> None:
    """Two plates pass a gap of 90 cm; what makes their unit of length long made margins of half a metre."""
    file = tmp_path / "hall.tamp"
    file.write_text(HALL)
    plan = _solved(compile_problem(file, "t", {"range": range_})[0]).plans[0]
    for phase in plan.phases:
        assert phase.end - phase.start < 20.0  # 10.1 s straight ahead at full speed, 15.1 s by the gentle law of time


def test_a_robot_that_slides_far_is_measured_by_its_body(tmp_path: Path) -> None:
    file = tmp_path / "hall.tamp"
    file.write_text(HALL)
    units = [length_unit(compile_problem(file, "t", {"range": r})[0]) for r in ("4m", "15m", "60m")]
    assert units[0] == 1.0 and 3.0 < units[1] < 3.1 and 12.0 < units[2] < 12.1


def test_a_small_robot_with_a_wide_table_is_measured_by_its_body(tmp_path: Path) -> None:
    """A rover of 6 mm that drives 12 cm about could go through sheets of a millimetre."""
    file = tmp_path / "hall.tamp"
    file.write_text(PUSH)
    problem = compile_problem(file, "push", {"s": "2cm"})[0]
    assert 0.005 < share_of(problem.world) < 0.02 and 0.005 < length_unit(problem) < 0.02


def test_a_robot_of_large_balls_on_a_short_link_is_of_the_usual_size(tmp_path: Path) -> None:
    file = tmp_path / "balls.tamp"
    file.write_text("""
import std.rules
module balls() {
    effector A: gripper sphere(0.3 m) normal (0, 0, -1)
    joint a: revolute(y) in -90 deg .. 90 deg
    link 0.03 m
    effector B: gripper sphere(0.3 m)
}
predicate (done)
rule end() { post (done) }
task t() {
    base ground: box(2 m, 2 m, 4 cm) at (0, 0, -2 cm)
    balls c: A on ground
    goal (done)
}
""")
    problem = compile_problem(file)[0]
    assert share_of(problem.world) == length_unit(problem) == 1.0


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
