"""Receding horizon: dead ends are undone, every horizon solves the same task, broken-off runs keep what stands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tamplang.api import load
from tamplang.compiler.ir import Pose, Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.horizon.receding import solve_receding
from tamplang.runtime.lgp import Progress, SolveOptions
from tamplang.runtime.verify import verify

HERE = Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"
SEED = 1


def _slots(seed: int = SEED, **parameters: str) -> Problem:
    """Two things go into a slot that has just room for both; what was put down stays."""
    return compile_problem(HERE / "slots.tamp", None, parameters, seed)[0]


def _options(seed: int = SEED) -> SolveOptions:
    return SolveOptions(time=60.0, seed=seed)


def test_without_backtracking_a_window_walks_into_a_dead_end() -> None:
    """The scheme of the thesis: no look beyond the window, no way back."""
    outcome = solve_receding(_slots(), _options(), 2, lookahead=0, backtracks=0)
    assert outcome.status == "exhausted"
    assert outcome.explanation[0].code == "S0002"
    assert "2 actions in 1 windows were planned" in outcome.explanation[0].message
    (plan,) = outcome.plans
    assert not plan.complete and len(plan.phases) == 2
    assert plan.verdict is not None and plan.verdict.verified
    assert verify(plan).verified


def test_the_same_window_is_undone_and_planned_otherwise() -> None:
    outcome = solve_receding(_slots(), _options(), 2, lookahead=0)
    assert outcome.status == "solved"
    (plan,) = outcome.plans
    assert plan.complete and plan.verdict is not None and plan.verdict.verified
    assert [window.motions for window in plan.windows] == [2, 2]
    assert plan.windows[0].reason == "dead end"


@pytest.mark.parametrize("horizon", range(1, 9))
def test_every_horizon_solves_the_task(horizon: int) -> None:
    outcome = solve_receding(_slots(), _options(), horizon)
    assert outcome.status == "solved"
    (plan,) = outcome.plans
    assert plan.verdict is not None and plan.verdict.verified
    assert len(plan.phases) == 4
    assert [w.motions for w in plan.windows] == [min(horizon, 4 - k) for k in range(0, 4, horizon)]


def test_parts_of_the_goal_drop_out_as_they_are_reached() -> None:
    (plan,) = solve_receding(_slots(), _options(), 2).plans
    assert [len(window.unmet) for window in plan.windows] == [2, 1]
    assert [window.phase for window in plan.windows] == [0, 2]
    assert plan.windows[1].time == plan.phases[2].start
    assert len(plan.windows[1].actions) < len(plan.windows[0].actions)


def test_an_adaptive_horizon_climbs_stairs() -> None:
    result = load(EXAMPLES / "climb.tamp", n=8, crawlers=1).solve(horizon="auto")
    assert result.status == "solved" and result.plan is not None
    plan = result.plan.record
    assert plan.verdict is not None and plan.verdict.verified
    assert len(plan.windows) > 1
    assert {node.status for node in plan.statistics.tree} >= {"executed"}


def test_the_tree_holds_every_executed_action_in_one_line() -> None:
    (plan,) = solve_receding(_slots(), _options(), 2).plans
    line, node = [], plan.statistics.tree[0]
    for phase in plan.phases:
        node = next(n for n in plan.statistics.tree if n.parent == node.id and n.action == phase.action)
        line.append(node.status)
    assert line == ["executed"] * 4


def test_ctrl_c_keeps_the_windows_that_stand() -> None:
    def press(progress: Progress) -> None:
        if progress.message.startswith("window 2"):
            raise KeyboardInterrupt

    outcome = solve_receding(_slots(), _options(), 2, press)
    assert outcome.status == "interrupted"
    (plan,) = outcome.plans
    assert not plan.complete and len(plan.phases) == 2
    assert plan.verdict is not None and plan.verdict.verified


def test_what_is_never_in_reach_is_proved_infeasible() -> None:
    problem, _ = compile_problem(EXAMPLES / "climb.tamp", None, {"n": "8", "crawlers": "1"}, 0)
    far: Pose = (90.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    bodies = {**problem.world.bodies, "target": replace(problem.world.bodies["target"], pose=far)}
    outcome = solve_receding(replace(problem, world=replace(problem.world, bodies=bodies)), _options(), 3)
    assert outcome.status == "infeasible"
    assert not outcome.plans and outcome.explanation[0].code == "S0001"


def test_a_goal_that_holds_at_the_start_needs_no_window() -> None:
    outcome = solve_receding(_slots(objects="0"), _options(), 3)
    assert outcome.status == "solved" and not outcome.actions
    (plan,) = outcome.plans
    assert plan.complete and not plan.windows
