"""A functional predicate never has two values: an action that would leave them cannot be done, wherever it is asked."""

from __future__ import annotations

import pytest

from tamplang.compiler.pipeline import check_sources, compile_text
from tamplang.compiler.symbolic.successors import Successors
from tamplang.langs.source import Source
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import SkeletonSearch
from tamplang.runtime.verify.replay import Interpreter

TEXT = """
type thing < object
predicate (at X: thing, A: thing) functional in A
predicate (wed X Y: thing) symmetric functional in X
predicate (seen A: thing)
rule move(A X: thing) { pre not (at X A) post (at X A) }
rule wipe(A: thing) { pre (seen A) post not (at ANY A) }
rule look(A: thing) { post (seen A) }
rule both(A X Y: thing) { post not (at ANY A), (at X A), if (seen A) { (at Y A) } }
rule marry(A B: thing) { pre A != B post (wed A B) }
task t() {
    thing a: box(1 m, 1 m, 1 m) at (0, 0, 0)
    thing b: box(1 m, 1 m, 1 m) at (3 m, 0, 0)
    thing c: box(1 m, 1 m, 1 m) at (6 m, 0, 0)
    fact (at a a)
    fact (wed a b)
    goal GOAL
}
"""


@pytest.mark.parametrize(
    ("goal", "plan"),
    [
        ("(at b a)", ["both(a, b, a)"]),
        ("(at b b)", ["move(b, b)"]),
    ],
)
def test_the_cheapest_plan_leaves_one_value(goal: str, plan: list[str] | None) -> None:
    problem, _ = compile_text(TEXT.replace("GOAL", goal))
    found = SkeletonSearch(problem, Successors(problem), "astar", Budget(20)).next()
    assert (None if found is None else [str(a) for a in found.actions]) == plan


def test_planner_and_verifier_refuse_a_second_value() -> None:
    problem, _ = compile_text(TEXT.replace("GOAL", "(at b a)"))
    fast, plain = Successors(problem), Interpreter(problem)
    theirs = {str(fast.action(number)) for _, number in fast.expand(fast.initial)}
    ours = {str(a) for rule in problem.rules.values() for a in plain.applicable(problem.init, rule)}
    assert theirs == ours
    assert not {"move(a, b)", "marry(a, c)", "marry(b, c)"} & theirs
    assert {"both(a, b, c)", "move(b, a)", "marry(b, a)"} <= theirs
    seen = next(t for t, number in fast.expand(fast.initial) if str(fast.action(number)) == "look(a)")
    after = {str(fast.action(number)) for _, number in fast.expand(seen)}
    assert "both(a, b, c)" not in after
    assert "both(a, b, b)" in after


FIRST = """
type thing < object
predicate (at X: thing, A: thing) functional in A
RULE
task t() {
    thing a: box(1 m, 1 m, 1 m) at (0, 0, 0)
    thing b: box(1 m, 1 m, 1 m) at (3 m, 0, 0)
    fact (at a a)
    goal GOAL
}
"""
WIPE = "rule wipe(A: thing) { post not (at ANY A) }"
MOVE = "rule move(A X: thing) { post (at X A) }"


@pytest.mark.parametrize(
    ("rules", "goal", "codes"),
    [
        (f"{WIPE}\n{MOVE}", "(at b a)", []),
        (f"{WIPE}\n{MOVE}", "(at b a), (at a a)", ["E0306"]),
        (f"{WIPE}\n{MOVE}", "(at b a) or (at a a)", []),
        (MOVE, "(at b a)", ["E0503"]),
        (MOVE, "(at b b)", []),
        (f"{MOVE}\nrule clear(A: thing) {{ pre (at A A), A != A post not (at A A) }}", "(at b a)", []),
        ("rule move(A X Y: thing) { pre (at X A) post (at Y A) }", "(at a a)", ["E0306"]),
        ("rule move(A X Y: thing) { pre (at X A) post not (at X A), (at Y A) }", "(at b a)", []),
        ("rule both(A X Y: thing) { post (at X A), (at Y A) }", "(at b b)", ["E0306"]),
        ("rule both(A X Y: thing) { post (at X A), (at Y X) }", "(at b b)", []),
    ],
)
def test_check_finds_second_values(rules: str, goal: str, codes: list[str]) -> None:
    text = FIRST.replace("RULE", rules).replace("GOAL", goal)
    found = check_sources([Source("t.tamp", text)])
    assert [d.code for d in found if d.code.startswith("E")] == codes
