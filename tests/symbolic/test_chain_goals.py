"""Goals that speak of chains: searched, estimated, checked and written as PDDL like any other."""

from __future__ import annotations

import pytest

from tamplang.compiler.pipeline import check_sources, compile_text
from tamplang.compiler.symbolic.pddl import to_pddl
from tamplang.compiler.symbolic.successors import Successors
from tamplang.langs.source import Source
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import SkeletonSearch
from tamplang.runtime.verify.replay import Interpreter

from .test_pddl import shortest
from .test_search import check_estimate

TEXT = """import std.crawler
import std.rules
derived (long) = exists c: chain of module by connected { length(c) >= 2 }
task t() {
    base g: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    crawler c[1]: A on g at (0, -0.3 m)
    crawler c[2]: A on g at (0, 0.3 m)
    goal GOAL
}
"""
CHAIN = "c: chain of module by connected"
GOALS = {
    "(long)": 1,
    f"exists {CHAIN} {{ length(c) >= 2 }}": 1,
    f"forall {CHAIN} {{ length(c) >= 2 }}": 1,
    f"exists {CHAIN}, k: 1 .. length(c) {{ k = 2 and (support c[k].out) }}": 1,
    f"exists {CHAIN}, k: 1 .. 2 {{ length(c) = k and k != 1 }}": 1,
    f"not exists {CHAIN} {{ length(c) < 2 }} and forall {CHAIN} {{ (free c.first) or (support c.first) }}": 1,
    f"forall {CHAIN} {{ length(c) = 1 }}": 0,
}


@pytest.mark.parametrize("goal", GOALS)
def test_the_shortest_plan_is_found_and_verified(goal: str) -> None:
    text = TEXT.replace("GOAL", goal)
    assert not check_sources([Source("t.tamp", text)])
    problem, _ = compile_text(text)
    found = SkeletonSearch(problem, Successors(problem), "astar", Budget(30)).next()
    assert found is not None and found.optimal
    assert len(found.actions) == GOALS[goal]
    plain, facts = Interpreter(problem), problem.init
    for action in found.actions:
        assert not plain.holds(facts, problem.goal)
        facts = plain.apply(facts, frozenset(), action).facts
    assert plain.holds(facts, problem.goal)


def test_the_estimate_is_a_lower_bound() -> None:
    problem, _ = compile_text(TEXT.replace("GOAL", f"exists {CHAIN} {{ length(c) >= 2 }}, not (support c[1].A)"))
    check_estimate(problem, 300)


def test_pddl_says_the_same() -> None:
    problem, _ = compile_text(TEXT.replace("GOAL", f"exists {CHAIN} {{ length(c) >= 2 }}"))
    assert Successors(problem).is_goal(Successors(problem).initial) is False
    assert shortest(*to_pddl(problem), 3) == 2


def test_a_module_past_the_end_is_told() -> None:
    goal = f"exists {CHAIN}, k: 1 .. 3 {{ (free c[k].in) }}"
    found = check_sources([Source("t.tamp", TEXT.replace("GOAL", goal))])
    assert [d.code for d in found] == ["E0313"]
