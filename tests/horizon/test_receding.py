"""Receding horizon: dead ends are undone, every horizon solves the same task, broken-off runs keep what stands."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tamplang.api import load
from tamplang.compiler import poses
from tamplang.compiler.ir import Pose, Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.lgp import Outcome, Progress, SolveOptions
from tamplang.runtime.planner.motion.keyframes.initial_guesses import effector_pose, to_tuple
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.receding.mid_run_state import after, start
from tamplang.runtime.planner.receding.receding_horizon import solve_receding
from tamplang.runtime.planner.receding.window import plan_window, remember
from tamplang.runtime.planner.search.best_first import SkeletonSearch
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Configuration, beginning
from tamplang.runtime.verify import verify

HERE = Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"
SEED = 1


def _slots(seed: int = SEED, **parameters: str) -> Problem:
    """Two things go into a slot that has just room for both; what was put down stays."""
    return compile_problem(HERE / "slots.tamp", None, parameters, seed)[0]


def _options(seed: int = SEED) -> SolveOptions:
    return SolveOptions(time=600.0, seed=seed)


def _thesis(seed: int) -> Outcome:
    """The scheme of the thesis: no look beyond the window, no way back."""
    return solve_receding(_slots(seed), _options(seed), 1, lookahead=0, backtracks=0)


@pytest.fixture(scope="module")
def stuck() -> tuple[int, Outcome]:
    """The first seed with which the scheme of the thesis puts the first thing where it leaves no room."""
    return next((seed, found) for seed in range(8) if (found := _thesis(seed)).status != "solved")


def test_without_backtracking_a_window_walks_into_a_dead_end(stuck: tuple[int, Outcome]) -> None:
    outcome = stuck[1]
    assert outcome.status == "exhausted"
    assert outcome.explanation[0].code == "S0002"
    assert "3 actions in 3 windows were planned" in outcome.explanation[0].message
    (plan,) = outcome.plans
    assert not plan.complete and len(plan.phases) == 3
    assert plan.verdict is not None and plan.verdict.verified
    assert verify(plan).verified


def test_the_window_of_a_dead_end_is_undone_and_planned_otherwise(stuck: tuple[int, Outcome]) -> None:
    outcome = solve_receding(_slots(stuck[0]), _options(stuck[0]), 1, lookahead=0)
    assert outcome.status == "solved"
    (plan,) = outcome.plans
    assert plan.complete and plan.verdict is not None and plan.verdict.verified
    assert [window.motions for window in plan.windows] == [1, 1, 1, 1]
    assert "dead end" in {window.reason for window in plan.windows}


def test_a_window_that_led_to_a_dead_end_is_planned_with_what_failed_behind_it_in_view() -> None:
    numbers = []
    outcome = solve_receding(_slots(0), _options(0), 1, lambda told: numbers.append(_window(told)), lookahead=0)
    assert outcome.status == "solved"
    assert 0 < sum(later < earlier for earlier, later in pairwise(numbers)) <= 6


def _window(told: Progress) -> int:
    return int(told.message.split()[1].rstrip(","))


@pytest.mark.parametrize("horizon", [1, 4])
def test_a_plate_that_lay_on_the_ground_is_lifted_in_a_window_of_its_own(horizon: int) -> None:
    problem = load(EXAMPLES / "quadruped.tamp").problem
    (plan,) = solve_receding(problem, _options(0), horizon).plans
    assert plan.complete and plan.verdict is not None and plan.verdict.verified
    assert plan.windows[-1].actions == ["standUp(p.S, ground)"]


def test_every_seed_that_got_stuck_is_solved_by_looking_ahead(stuck: tuple[int, Outcome]) -> None:
    outcome = solve_receding(_slots(stuck[0]), _options(stuck[0]), 1)
    assert outcome.status == "solved"
    assert outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified


@pytest.mark.parametrize("horizon", range(1, 9))
def test_every_horizon_solves_the_task(horizon: int) -> None:
    outcome = solve_receding(_slots(), _options(), horizon)
    assert outcome.status == "solved"
    (plan,) = outcome.plans
    assert plan.verdict is not None and plan.verdict.verified
    assert len(plan.phases) == 4
    assert [w.motions for w in plan.windows] == [min(horizon, 4 - k) for k in range(0, 4, horizon)]


def test_a_slot_without_room_is_given_up_after_some_starts() -> None:
    outcome = solve_receding(_slots(length="0.05 m", width="0.05 m"), _options(), 2)
    assert outcome.status == "exhausted"
    assert "0 actions in 0 windows were planned, and 0 windows undone" in outcome.explanation[0].message


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


def test_the_known_way_is_not_taken_where_its_beginning_is_forbidden() -> None:
    """It is the only way here."""
    problem, options, budget = _slots(), _options(), Budget(60.0)
    memory = remember(problem, options, budget)
    first = plan_window(problem, start(problem), options, 1, budget, memory)
    known = first.rest
    after = plan_window(problem, first.reached, options, 1, budget, memory, before=first)
    assert first.ahead and after.actions == known and after.tree_nodes == 0
    other = plan_window(problem, first.reached, options, 1, budget, memory, before=first, forbidden=(known[:2],))
    assert other.status == "stuck"


def test_a_goal_that_holds_at_the_start_needs_no_window() -> None:
    outcome = solve_receding(_slots(objects="0"), _options(), 3)
    assert outcome.status == "solved" and not outcome.actions
    (plan,) = outcome.plans
    assert plan.complete and not plan.windows


def test_switches_behind_a_window_are_drawn_anew_with_it() -> None:
    problem = load(EXAMPLES / "pick_and_place.tamp").problem
    bounds = remember(problem, SolveOptions(), Budget(30.0)).bounds
    successors = Successors(problem)
    candidate = SkeletonSearch(problem, successors, "astar", Budget(None), None).next()
    assert candidate is not None
    skeleton = build_skeleton(problem, candidate.actions, successors)
    sequence = solve_sequence(skeleton, bounds.settings, Seed(0), Budget(30.0))
    sequence.configurations[1].modules["c"][2] += 1.0
    judgement = bounds.motion(skeleton, sequence, 1)
    assert judgement.accepted and judgement.paths is not None and len(judgement.paths) == 1
    reached = after(problem, beginning(skeleton, 1), judgement.paths).configuration
    hand, thing = skeleton.phases[0].action.args
    assert isinstance(hand, str) and isinstance(thing, str)
    assert np.allclose(_held(problem, reached, hand, thing), _held(problem, judgement.ahead[0], hand, thing), atol=1e-5)


def _held(problem: Problem, configuration: Configuration, hand: str, thing: str) -> Pose:
    """The pose of a thing as its gripper sees it."""
    found = problem.world.effector(hand)
    assert found is not None
    gripper = effector_pose(found[0], found[1].name, configuration.modules[found[0].name])
    pose = poses.compose(poses.inverse(gripper), to_tuple(configuration.bodies[thing]))
    x, y, z, *turn = pose
    a, b, c, w = (q if pose[6] >= 0 else -q for q in turn)
    return x, y, z, a, b, c, w
