"""A robot mounts a plate and carries things to where neither could alone; a thing too high is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tamplang.compiler.motion.permanent import permanent
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import SolveOptions, solve

EXAMPLE = Path(__file__).parents[2] / "examples" / "mobile_manipulator.tamp"


def test_one_object_is_carried() -> None:
    problem, _ = compile_problem(EXAMPLE, None, {"objects": "1"}, 0)
    outcome = solve(problem, SolveOptions(time=120.0))
    assert outcome.status == "solved"
    assert [action.partition("(")[0] for action in outcome.actions] == ["mount", "grasp", "place"]
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified


def test_trays_too_high_are_refused() -> None:
    problem, _ = compile_problem(EXAMPLE, None, {"objects": "1", "height": "2 m"}, 0)
    outcome = solve(problem, SolveOptions(time=120.0))
    assert outcome.status in ("exhausted", "infeasible")
    assert outcome.explanation


DRIVE = """
import std.crawler
import std.rules
import std.mobile

task park() {
    object floor: box(8 m, 8 m, 0.1 m) at (0, 0, -0.05 m)
    place bay: box(0.2 m, 0.2 m, 0.01 m) at (1.5 m, 0.4 m, 0.005 m)
    mobileBase plate: W on floor at (0, -0.8 m)
    goal (parked plate.M bay)
}
"""

UNMOUNT = """
import std.crawler
import std.rules
import std.mobile

task ferry() {
    object floor: box(8 m, 8 m, 0.1 m) at (0, 0, -0.05 m)
    base here: box(0.4 m, 0.4 m, 0.04 m) at (0, 0, 0.02 m)
    base there: box(0.4 m, 0.4 m, 0.04 m) at (3 m, 0, 0.02 m)
    crawler c: A on here
    mobileBase plate: W on floor at (0, -0.8 m)
    goal exists A: gripper { (on there A) }
}
"""

VISIT = """
import std.mobile

predicate (seen Y: place)
rule look(M: marker, Y: place) { pre (parked M Y) post (seen Y) }
task visit() {
    object floor: box(8 m, 4 m, 0.1 m) at (0, 0, -0.05 m)
    place west: box(0.3 m, 0.3 m, 1 mm) at (-2 m, 0, 0)
    place east: box(0.3 m, 0.3 m, 1 mm) at (2 m, 0, 0)
    mobileBase plate: W on floor at (0, 1 m)
    goal (seen west), (seen east)
}
"""


@pytest.mark.parametrize(
    ("text", "rules"),
    [(DRIVE, ["drive"]), (UNMOUNT, ["mount", "unmount"]), (VISIT, ["drive", "look", "leave", "drive", "look"])],
)
def test_plates_park_and_ferry(text: str, rules: list[str], tmp_path: Path) -> None:
    path = tmp_path / "task.tamp"
    path.write_text(text)
    problem, _ = compile_problem(path, None, {}, 0)
    outcome = solve(problem, SolveOptions(time=120.0))
    assert outcome.status == "solved"
    assert [action.partition("(")[0] for action in outcome.actions] == rules


def test_wheels_that_never_leave_the_ground_are_known_wherever_a_window_begins() -> None:
    """The plate drives 4 m from where it starts, the trays lie farther away: every grasp is refused on its own."""
    problem, _ = compile_problem(EXAMPLE, None, {"objects": "1", "away": "6 m"}, 0)
    assert permanent(problem) == {("stable", "floor", "plate.W"), ("level", "plate.W", "floor")}
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "exhausted"
    told = [e.message for e in outcome.explanation]
    assert any("grasp" in text and "joint drive.x of plate would have to go" in text for text in told)


def test_what_an_action_can_undo_is_not_permanent() -> None:
    problem, _ = compile_problem(EXAMPLE, None, {"objects": "1"}, 0)
    rules = {name: rule for name, rule in problem.rules.items() if name != "grasp"}
    resting = ("stable", "source", "item[1]")
    assert resting in problem.init_motion
    assert resting not in permanent(problem)
    assert resting in permanent(replace(problem, rules=rules))
