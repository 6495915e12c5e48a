"""Things that touch at the start, though no text says that one stands on the other."""

from __future__ import annotations

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.geometry.start_contacts import touching
from tamplang.runtime.planner.lgp import SolveOptions, solve

TEXT = """
import std.crawler
import std.rules

task tidy(height: length = 14 cm) {
    base floor: box(1.6 m, 1.6 m, 10 cm) at (0, 0, 5 cm)
    base shelf: box(40 cm, 40 cm, 30 cm) at (0.6 m, 0.3 m, 25 cm)
    fact (tray shelf)
    object ball: sphere(4 cm) at (-0.3 m, 0.4 m, height)
    fact (grippable ball)
    crawler c: A on floor at (0, 0)
    goal (on shelf ball)
}
"""


def test_a_ball_that_touches_the_floor_is_taken_from_it() -> None:
    problem, _ = compile_text(TEXT, "tidy.tamp", None, {})
    assert ("ball", "floor") in touching(problem.world)
    outcome = solve(problem, SolveOptions(time=30.0))
    assert outcome.status == "solved" and outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
    assert [action.split("(")[0] for action in outcome.actions] == ["grasp", "place"]


def test_what_is_well_apart_does_not_touch() -> None:
    problem, _ = compile_text(TEXT, "tidy.tamp", None, {"height": "30 cm"})
    assert touching(problem.world) == {("c.A", "floor")}
