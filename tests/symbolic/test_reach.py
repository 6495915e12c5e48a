"""What `check` says is out of reach is proved to be so by the search, and nothing that a plan reaches is."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings

from tamplang.compiler.checks.findings import Findings
from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.scenes.check_reach import check_reach

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
