"""P_seq on the fixtures: feasible skeletons are solved, infeasible ones refused with a reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamplang.compiler.ir import Problem
from tamplang.runtime.budget import Budget, OutOfTime
from tamplang.runtime.planner.motion.keyframes.initial_guesses import effector_pose
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence, window_feasible
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Configuration, Skeleton, start_configuration

from .fixtures import CRAWLER, climb_alone, climb_together, pick_and_place

SETTINGS = MotionSettings()
SKELETONS = {
    "alone": climb_alone(8),
    "together": climb_together(2, n=8),
    "table": pick_and_place(3),
}


def effector_at(problem: Problem, configuration: Configuration, name: str) -> np.ndarray:
    module, effector = problem.world.effector(name)  # a pair for every effector of the fixtures
    return np.array(effector_pose(module, effector.name, configuration.modules[module.name]))


def check_feet(skeleton: Skeleton, configurations: list[Configuration]) -> None:
    """Every foot that an action sets down lies on top of its base, within its outline, and then stays."""
    problem = skeleton.problem
    for k, phase in enumerate(skeleton.phases):
        for name, *objects in phase.added:
            if name == "stand":
                foot = effector_at(problem, configurations[k + 1], objects[0])
                base = problem.world.bodies[objects[1]]
                centre = np.array(base.pose[:3])
                assert foot[2] - 0.05 == pytest.approx(centre[2] + base.shape.size[2] / 2, abs=1e-5)
                assert (np.abs(foot[:2] - centre[:2]) <= np.array(base.shape.size[:2]) / 2 - 0.03 + 1e-5).all()
        for name, *objects in phase.mode:
            if name == "stable" and objects[0] in problem.world.bodies and problem.world.effector(objects[1]):
                before = effector_at(problem, configurations[k], objects[1])
                after = effector_at(problem, configurations[k + 1], objects[1])
                assert before[:3] == pytest.approx(after[:3], abs=1e-5)
                assert abs(before[3:] @ after[3:]) == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("name", list(SKELETONS))
@pytest.mark.parametrize("seed", range(5))
def test_fixtures_are_feasible(name: str, seed: int) -> None:
    skeleton = SKELETONS[name]
    result = solve_sequence(skeleton, SETTINGS, Seed(seed), Budget(30.0))
    assert result.feasible
    assert result.bound == "seq"
    assert not result.violations
    assert len(result.configurations) == len(skeleton) + 1
    check_feet(skeleton, result.configurations)
    for configuration in result.configurations[1:]:
        for slot in configuration.modules.values():
            for value, joint in zip(slot[7:], CRAWLER.joints, strict=True):
                assert joint.lower - 1e-9 <= value <= joint.upper + 1e-9  # as rows are met
            assert np.linalg.norm(slot[3:7]) == pytest.approx(1.0)


def test_boxes_travel_with_the_hand_and_come_to_rest() -> None:
    skeleton = pick_and_place(2)
    configurations = solve_sequence(skeleton, SETTINGS, Seed(0), Budget(30.0)).configurations
    start = start_configuration(skeleton.problem)
    assert np.array_equal(configurations[1].bodies["item[1]"], start.bodies["item[1]"])
    placed = configurations[2].bodies["item[1]"]
    assert placed[2] == pytest.approx(0.04 + 0.03, abs=1e-5)
    assert np.abs(placed[:2] - [0.0, -0.6]).max() < 0.25
    assert np.array_equal(configurations[3].bodies["item[1]"], placed)
    assert np.array_equal(configurations[4].bodies["item[1]"], placed)
    assert np.array_equal(configurations[2].bodies["item[2]"], start.bodies["item[2]"])


def test_long_skeletons_go_by_windows() -> None:
    skeleton = climb_alone(16)
    result = solve_sequence(skeleton, SETTINGS, Seed(0), Budget(30.0))
    assert result.feasible
    check_feet(skeleton, result.configurations)


def test_three_stairs_at_once_are_refused() -> None:
    skeleton = climb_alone(3, stride=3, grasp=False)
    for seed in range(3):
        result = solve_sequence(skeleton, SETTINGS, Seed(seed), Budget(30.0))
        assert not result.feasible
        assert result.violations[0].amount > 0.1
        assert result.violations[0].unit == "m"
        assert result.violations[0].phase < 3
        amounts = [v.amount for v in result.violations]
        assert amounts == sorted(amounts, reverse=True)


def test_windows_refuse_what_no_state_allows() -> None:
    far = climb_alone(4, stride=3)
    assert not window_feasible(far, 0, 0, SETTINGS, Seed(0), Budget(30.0)).feasible
    assert not window_feasible(far, 2, 2, SETTINGS, Seed(0), Budget(30.0)).feasible


@pytest.mark.parametrize(("first", "last"), [(0, 0), (3, 3), (4, 5), (6, 8)])
def test_windows_accept_what_some_state_allows(first: int, last: int) -> None:
    result = window_feasible(SKELETONS["alone"], first, last, SETTINGS, Seed(0), Budget(30.0))
    assert result.feasible
    assert len(result.configurations) == last - first + 2


def test_same_seed_same_result() -> None:
    one = solve_sequence(SKELETONS["together"], SETTINGS, Seed(3), Budget(30.0))
    two = solve_sequence(SKELETONS["together"], SETTINGS, Seed(3), Budget(30.0))
    assert one.cost == two.cost
    for a, b in zip(one.configurations, two.configurations, strict=True):
        assert all(np.array_equal(a.modules[m], b.modules[m]) for m in a.modules)


def test_warm_starts_stay_near() -> None:
    skeleton = SKELETONS["together"]
    cold, warm = [], []
    for seed in range(4):
        one = solve_sequence(skeleton, SETTINGS, Seed(seed), Budget(30.0))
        two = solve_sequence(skeleton, SETTINGS, Seed(seed + 4), Budget(30.0), warm=one.configurations[1:])
        assert two.feasible
        cold.append(one.iterations)
        warm.append(two.iterations)
    assert np.median(warm) < 0.75 * np.median(cold)


def test_ipopt_reaches_the_same_feasibility() -> None:
    settings = replace(SETTINGS, solver="ipopt")
    skeleton = climb_together(1, n=4, grasp=False)
    result = solve_sequence(skeleton, settings, Seed(0), Budget(30.0))
    assert result.feasible
    check_feet(skeleton, result.configurations)


def test_a_spent_budget_raises() -> None:
    with pytest.raises(OutOfTime):
        solve_sequence(SKELETONS["alone"], SETTINGS, Seed(0), Budget(0.0))
