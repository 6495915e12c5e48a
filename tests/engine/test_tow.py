"""As many grippers as a thing is heavy."""

from pathlib import Path

import msgspec
import pytest

from benchmarks.trust import tampers_forces
from benchmarks.trust.kinds import KINDS
from benchmarks.trust.tamper import tampered
from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.engine import carry_out
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.verify.check import check

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
    if holders == 2:
        refuses_false_forces(plan, problem)


def refuses_false_forces(plan: Plan, problem: Problem) -> None:
    """Loads of pairs, also where several share them, torques, strengths and weights that a plan tells."""
    text = msgspec.json.encode(plan).decode()
    names = [name for name, kind in KINDS.items() if kind.change.__module__ == tampers_forces.__name__]
    spoilt = {name: tampered(text, KINDS[name], "7") for name in names}
    assert {name for name, changed in spoilt.items() if changed is None} <= {"torques_of_two_instants"}  # all straight
    assert len(spoilt) > 10
    for name, changed in spoilt.items():
        if changed is None:
            continue
        verdict = check(msgspec.json.decode(changed, type=Plan), problem)
        kinds = {f.kind for f in verdict.failures}
        assert kinds and kinds <= {"statics", "scene", "structure"}, name
