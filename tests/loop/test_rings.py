"""Closed rings of joints without drives: postures and ways that descent from the start does not find."""

from __future__ import annotations

from pathlib import Path

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve

FOUR_BAR = """
import std.motion
type pin < effector
module linkage {
    effector F: pin sphere(1 cm) normal (0, 0, -1)
    link 15 cm: capsule(1 cm)
    joint crank: revolute(y) in -360 deg .. 360 deg home 0.3 rad
    link 10 cm: capsule(8 mm)
    joint coupler: revolute(y) in -360 deg .. 360 deg home 0.855981303912 rad passive
    link 25 cm: capsule(8 mm)
    effector T: pin sphere(1 cm) at (0, 0, 4 cm)
    joint rocker: revolute(y) in -360 deg .. 360 deg home 2.178554960130 rad passive
    link 20 cm: capsule(8 mm)
    joint post: revolute(y) in -360 deg .. 360 deg home -0.192943610453 rad passive
    link 15 cm: capsule(1 cm)
    effector G: pin sphere(1 cm)
}
placement (A: pin) on (X: object) { [stable X A] }
predicate (done T: pin)
motion [there T: pin] {
    at switch dot(position(T), (1, 0, 0)) = 0.18639
    at switch dot(position(T), (0, 0, 1)) >= 0.400224
}
rule turn(T: pin) { pre not (done T) post (done T), [there T] }
task t {
    object bed: box(42 cm, 10 cm, 2 cm) at (11 cm, 0, 0)
    linkage b: F on bed at (-11 cm, 0)
    fact [stable bed b.G]
    goal (done b.T)
}
"""

LID = """
import std.mechanisms
import std.crawler
import std.rules
task t {
    base pedestal: box(30 cm, 30 cm, 5 cm) at (0, 0, 0)
    object sill: box(40 cm, 40 cm, 10 cm) at (72 cm, 0, 5 cm)
    crawler c: A on pedestal
    lid d: F on sill at (10 cm, 0)
    goal (open d.H)
}
"""

def _solved(folder: Path, text: str, seed: int = 0) -> Outcome:
    (folder / "ring.tamp").write_text(text)
    outcome = solve(compile_problem(folder / "ring.tamp", "t", seed=seed)[0], SolveOptions(seed=seed, time=60.0))
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
    return outcome


def test_a_four_bar_is_turned_to_where_descent_from_its_start_does_not_lead(tmp_path: Path) -> None:
    _solved(tmp_path, FOUR_BAR, seed=1)


def test_a_lid_is_lifted_that_an_elbow_at_its_limit_can_just_follow(tmp_path: Path) -> None:
    """The elbow is at 2.095 of 2.1 rad at first: wishes to keep from limits do not refuse it."""
    _solved(tmp_path, LID)
