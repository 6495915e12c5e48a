"""What `check` says is out of reach is proved to be so by the search, and nothing that a plan reaches is."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings

from tamplang.compiler.checks.findings import Findings
from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import check_sources, compile_problem
from tamplang.compiler.scenes.check_reach import check_reach
from tamplang.langs.source import Source

from .problems import pick_and_place
from .test_search import climbs, scattered, started

BAD = Path(__file__).parents[1] / "programs" / "bad" / "out_of_reach.tamp"
EXAMPLES = Path(__file__).parents[2] / "examples"


def warned(problem: Problem) -> bool:
    findings = Findings(problem.sources)
    check_reach(findings, problem)
    found = findings.sorted()
    assert all(d.code == "W0009" for d in found)
    return bool(found)


def feasible(problem: Problem) -> bool:
    search = started(problem)
    found = search.next() is not None
    assert found or search.status == "infeasible"
    return found


def test_tasks_of_one_program_are_told_each_for_its_own_goal() -> None:
    far, near = "(0, 40 cm, 3 m)", "(0, 40 cm, 50 cm)"
    rules = "".join(
        f"predicate (seen{k} X: object)\nrule see{k}(A: gripper, X: object) {{\n"
        f"    pre   (grasped A X)\n    where distance(A, X) <= 1 m\n    post  (seen{k} X)\n}}\n"
        for k in (1, 2)
    )
    tasks = "".join(
        f"task t{k}() {{\n    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)\n    object ball: sphere(4 cm) at {place}\n"
        f"    crawler c: A on ground at (30 cm, 0)\n    fact (grippable ball)\n    goal (seen{k % 2 + 1} ball)\n}}\n"
        for k, place in enumerate((near, far, near, far))
    )
    found = check_sources([Source("t.tamp", f"import std.rules\nimport std.crawler\n{rules}{tasks}")])
    assert [(d.code, d.message.split()[0]) for d in found] == [("W0009", "`(seen2"), ("W0009", "`(seen2")]


@settings(max_examples=15, deadline=None)
@given(climbs())
def test_no_goal_that_a_plan_reaches_is_out_of_reach(problem: Problem) -> None:
    assert not (warned(problem) and feasible(problem))


@pytest.mark.parametrize("modules, height", [(1, 0.9), (1, 1.6), (2, 1.9), (2, 2.7), (3, 2.8), (3, 4.0)])
def test_targets_of_chains_are_told_exactly(modules: int, height: float) -> None:
    problem = scattered(modules, height, 0.0)
    assert warned(problem) is not feasible(problem)


@pytest.mark.parametrize("task", ["too_high", "too_far", "too_long", "too_many"])
def test_the_search_proves_each_warning(task: str) -> None:
    problem, _ = compile_problem(BAD, task)
    assert warned(problem) and not feasible(problem)


@pytest.mark.parametrize(
    "name, parameters",
    [("chain_climb", {"modules": "3", "missing": "1"}), ("rendezvous", {"n": "2", "gap": "1.5 m"})],
)
def test_variants_of_examples_without_a_plan_are_told(name: str, parameters: dict[str, str]) -> None:
    problem, _ = compile_problem(EXAMPLES / f"{name}.tamp", None, parameters)
    assert warned(problem) and not feasible(problem)


def test_things_in_reach_are_not_told() -> None:
    assert not warned(pick_and_place(4, 2))
