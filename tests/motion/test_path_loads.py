"""Loads on the way between switches: they are looked at over all of a phase, and paths give way to them."""

from pathlib import Path

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.skeleton import Bound
from tamplang.runtime.verify.check import check as judge

EXAMPLES = Path(__file__).parents[2] / "examples"


def payload(load: str, physics: bool = True) -> tuple[ir.Problem, Plan]:
    text = (EXAMPLES / "payload.tamp").read_text()
    text = text if physics else text.replace("physics = dynamics, ", "")
    problem, _ = compile_text(text, "payload.tamp", None, {"load": load})
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "solved", [d.message for d in outcome.explanation]
    return problem, outcome.plans[0]


def test_a_grip_that_would_slip_on_the_way_is_carried_another_way() -> None:
    _, plan = payload("8 kg")
    assert plan.verdict is not None and plan.verdict.verified
    assert 0.8 < plan.verdict.worst["dock_ratio"] <= 1.0


def test_without_physics_the_base_would_tip_over() -> None:
    problem, _ = payload("5 kg")
    _, careless = payload("5 kg", physics=False)
    assert "tip_m" in {f.kind for f in judge(careless, problem).failures}


def test_what_several_hands_cannot_bear_together_is_refused_without_a_posture() -> None:
    text = (EXAMPLES / "tow.tamp").read_text()
    problem, _ = compile_text(text, "tow.tamp", None, {"load": "40 kg"})
    outcome = solve(problem, SolveOptions(time=30.0))
    assert outcome.status in ("exhausted", "infeasible")
    told = next(d for d in outcome.explanation if "item" in d.message and d.labels)
    assert told.span is not None and "holds grip" in text.splitlines()[told.span.line - 1]


def test_strength_decides_whether_one_climbs_or_two_dock() -> None:
    text = (EXAMPLES / "real_choice.tamp").read_text()
    chosen = {}
    for drive, clasp in (("100 N m", "2.8 N m"), ("100 N m", "60 N m")):
        problem, _ = compile_text(text, "real_choice.tamp", None, {"drive": drive, "clasp": clasp})
        outcome = solve(problem, SolveOptions(time=60.0, bound=Bound.SEQ))
        chosen[clasp] = {action.partition("(")[0] for action in outcome.actions}
    assert chosen == {"2.8 N m": {"step", "grasp"}, "60 N m": {"join", "stride_together", "grasp"}}
