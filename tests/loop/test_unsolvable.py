"""A variant of each example that has no solution ends with what is missing, by how much, and where it is asked for."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve

EXAMPLES = Path(__file__).parents[2] / "examples"
REACH = "std/logic.tamp"


def outcome_of(example: str, **parameters: str) -> Outcome:
    problem, _ = compile_problem(EXAMPLES / f"{example}.tamp", None, parameters)
    return solve(problem, SolveOptions(time=20.0))


@pytest.mark.parametrize(
    ("example", "parameters", "note"),
    [
        ("chain_climb", {"missing": "1"}, "all 4 modules in one line reach 4.30 m: 0.16 m too little"),
        ("rendezvous", {"gap": "1.5 m"}, "all 2 modules in one line reach 2.10 m: 2.27 m too little"),
        ("strut_bridge", {"struts": "0"}, "all 2 modules in one line reach 2.10 m: 0.30 m too little"),
    ],
)
def test_what_is_out_of_reach_is_told_in_metres(example: str, parameters: dict[str, str], note: str) -> None:
    outcome = outcome_of(example, **parameters)
    assert outcome.status == "infeasible" and not outcome.actions
    told = outcome.explanation[0]
    assert told.code == "S0001" and told.span is not None and told.span.file.endswith(f"{example}.tamp")
    assert told.note is not None and note in told.note
    assert any(label.span.file in (REACH, "std/rules.tamp") for label in told.labels)


@pytest.mark.parametrize("crawlers", ["1", "2"])
def test_a_target_that_hangs_too_high(crawlers: str) -> None:
    text = (EXAMPLES / "climb.tamp").read_text().replace("+ 1.0 m)", "+ 4.0 m)")
    outcome = solve(compile_text(text, "climb.tamp", None, {"crawlers": crawlers})[0], SolveOptions(time=20.0))
    assert outcome.status == "infeasible"
    note = outcome.explanation[0].note
    assert note is not None and "target is 3.95 m from stair[8]" in note


def test_too_few_legs() -> None:
    outcome = outcome_of("quadruped", crawlers="3")
    assert outcome.status == "infeasible"
    told = outcome.explanation[0]
    assert "`standUp`" in told.message and told.note is not None
    assert "standUp(p.S, ground) comes nearest after mount(c[1].A, c[1].B, p.P1), mount(" in told.note
    assert told.note.endswith("it still lacks `forall Q: socket { not (free Q) }`, which fails for Q = p.P4")
    assert [label.text for label in told.labels] == ["a rule that achieves it", "this stays false"]


def test_what_no_motion_reaches_is_told_by_the_smallest_miss() -> None:
    outcome = outcome_of("mobile_manipulator", height="2 m", objects="1")
    assert outcome.status == "exhausted" and not outcome.actions
    for told in outcome.explanation:
        assert told.code == "S0002" and told.span is not None and told.labels
        assert told.message.startswith("P_seq refuses ") and "is missed by" in told.message
        assert not told.message.endswith(" 1")


def test_what_several_sequences_are_refused_by_is_told_once() -> None:
    text = """
import std.crawler
import std.logic
import std.motion
import std.rules
motion [aloft X Y: object] { at switch bottom(X) >= top(Y) + 5 m }
predicate (lifted X: object)
rule lift(A: gripper, X: object) { pre (grasped A X) post (lifted X), [aloft X A] }
task lift() {
    base ground: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    object target: sphere(0.04 m) at (0.5 m, 0, 0.4 m)
    fact (grippable target)
    crawler c: A on ground at (0, 0)
    goal (lifted target)
}
"""
    outcome = solve(compile_text(text, "lift.tamp", None, {})[0], SolveOptions(time=60.0))
    assert outcome.status == "exhausted" and len(outcome.statistics.refusals) > 1
    assert len(outcome.explanation) == 1 and "[aloft target c.B] is missed by" in outcome.explanation[0].message
