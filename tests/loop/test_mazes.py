"""Narrow ways, which samples find where nothing else does."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import SolveOptions, solve

MAZES = Path(__file__).parents[1] / "programs" / "good" / "mazes.tamp"


@pytest.mark.parametrize(("task", "seed"), [("gate", 3), ("pipe", 4), ("window", 0)])
def test_a_way_through_is_found(task: str, seed: int) -> None:
    outcome = solve(compile_problem(MAZES, task, seed=seed)[0], SolveOptions(seed=seed, time=120.0))
    assert outcome.status == "solved" and outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
