"""As many grippers as a thing is heavy."""

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.engine import carry_out
from tamplang.runtime.planner.lgp import SolveOptions, solve

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "tow.tamp"


@pytest.mark.parametrize(("load", "holders"), [("5 kg", 1), ("10 kg", 2)])
def test_a_second_arm_is_brought_where_one_cannot_hold(load: str, holders: int) -> None:
    problem, _ = compile_problem(EXAMPLE, None, {"load": load})
    (plan,) = solve(problem, SolveOptions(time=90.0)).plans
    assert [p.rule for p in plan.phases] == ["hold"] * holders + ["lift"]
    assert plan.verdict is not None and plan.verdict.verified and 0.5 < plan.verdict.worst["dock_ratio"] <= 1.0
    carried = carry_out(problem, plan)
    assert carried.reached and not carried.broken
    assert max(carried.loads.values()) > 0.3
