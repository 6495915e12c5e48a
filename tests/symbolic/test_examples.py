"""The examples of chains and of the rendezvous: their skeletons, and that they cannot be had for less."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang import load
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import Candidate, SkeletonSearch

EXAMPLES = Path(__file__).parents[2] / "examples"


def skeleton(name: str, **parameters: str) -> tuple[SkeletonSearch, Candidate | None]:
    problem, _ = compile_problem(EXAMPLES / f"{name}.tamp", None, parameters)
    search = SkeletonSearch(problem, Successors(problem), "astar", Budget(30))
    return search, search.next()


@pytest.mark.parametrize("modules", [2, 3, 4, 8])
def test_a_chain_of_all_modules_reaches_the_target(modules: int) -> None:
    search, candidate = skeleton("chain_climb", modules=str(modules))
    assert candidate is not None and candidate.optimal
    assert [a.rule for a in candidate.actions] == ["connect"] * (modules - 1) + ["grasp"]
    assert search.expanded_nodes <= 2 * modules


def test_a_missing_module_makes_the_target_unreachable() -> None:
    search, candidate = skeleton("chain_climb", modules="3", missing="1")
    assert candidate is None and search.status == "infeasible"


@pytest.mark.parametrize("n", [1, 4, 64])
def test_the_rendezvous_joins_and_parts(n: int) -> None:
    _, candidate = skeleton("rendezvous", n=str(n))
    assert candidate is not None and candidate.optimal
    walks = {"stepTogether"} if n == 64 else set()
    assert {"connect", "disconnect", "grasp"} | walks <= {a.rule for a in candidate.actions}


def test_a_wide_gap_makes_the_rendezvous_impossible() -> None:
    search, candidate = skeleton("rendezvous", n="2", gap="1.5 m")
    assert candidate is None and search.status == "infeasible"


def test_two_modules_move_as_a_chain() -> None:
    result = load(EXAMPLES / "chain_climb.tamp", modules=2).solve()
    assert result.status == "solved"
