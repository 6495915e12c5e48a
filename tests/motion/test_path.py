"""P_path and P_seqPath over all slices: stance, continuity, limits, clearance."""

from __future__ import annotations

import numpy as np
import pytest

from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.initial_guesses import effector_pose
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.path.whole_path import solve_path
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import BoundResult, Skeleton

from .fixtures import CRAWLER, climb_alone, climb_together, pick_and_place

SETTINGS = MotionSettings()
SKELETONS = {"alone": climb_alone(3), "together": climb_together(2, n=8), "table": pick_and_place(1)}


@pytest.fixture(scope="module", params=[(name, pinned) for name in SKELETONS for pinned in (True, False)], ids=str)
def solved(request: pytest.FixtureRequest) -> tuple[Skeleton, BoundResult, BoundResult, bool]:
    name, pinned = request.param
    skeleton = SKELETONS[name]
    sequence = solve_sequence(skeleton, SETTINGS, Seed(0), Budget(120.0))
    return skeleton, sequence, solve_path(skeleton, SETTINGS, Seed(0), Budget(120.0), sequence, pinned), pinned


Solved = tuple[Skeleton, BoundResult, BoundResult, bool]


def test_feasible_and_complete(solved: Solved) -> None:
    skeleton, _sequence, result, pinned = solved
    assert result.feasible
    assert result.bound == ("seq-path" if pinned else "path")
    assert len(result.paths) == len(skeleton)
    assert len(result.configurations) == len(skeleton) + 1
    for path in result.paths:
        assert path.duration > 0
        for track in path.modules.values():
            assert track.shape == (SETTINGS.slices + 1, 7 + len(CRAWLER.joints))


def test_pinned_switches_stay(solved: Solved) -> None:
    _, sequence, result, pinned = solved
    if pinned:
        for a, b in zip(sequence.configurations, result.configurations, strict=True):
            for name, slot in a.modules.items():
                assert slot == pytest.approx(b.modules[name], abs=1e-9)


def test_phases_join(solved: Solved) -> None:
    result = solved[2]
    for k, path in enumerate(result.paths):
        for name, track in path.modules.items():
            assert np.array_equal(track[0][7:], result.configurations[k].modules[name][7:])
            assert np.array_equal(track[-1][7:], result.configurations[k + 1].modules[name][7:])


def test_feet_and_held_things_do_not_slip(solved: Solved) -> None:
    skeleton, _, result, _ = solved
    world = skeleton.problem.world
    for phase, path in zip(skeleton.phases, result.paths, strict=True):
        for name, *objects in phase.mode:
            found = world.effector(objects[1])
            if name == "stable" and objects[0] in world.bodies and found:
                module, effector = found
                poses = np.array([effector_pose(module, effector.name, s) for s in path.modules[module.name]])
                assert np.abs(poses[:, :3] - poses[0, :3]).max() < 1e-4


def test_joints_stay_within_limits_and_do_not_jump(solved: Solved) -> None:
    lower = np.array([j.lower for j in CRAWLER.joints])
    upper = np.array([j.upper for j in CRAWLER.joints])
    for path in solved[2].paths:
        for track in path.modules.values():
            joints = track[:, 7:]
            assert (joints >= lower - 1e-3).all()
            assert (joints <= upper + 1e-3).all()
            assert np.abs(np.diff(joints, axis=0)).max() < 0.6


def test_bodies_move_only_while_held(solved: Solved) -> None:
    skeleton, _, result, _ = solved
    for phase, path in zip(skeleton.phases, result.paths, strict=True):
        held = {b for name, a, b in phase.mode if name == "stable" and skeleton.problem.world.effector(a)}
        assert set(path.bodies) == held & set(skeleton.problem.world.bodies)


def test_pinned_obstacles_stand_where_they_were_put_down() -> None:
    """The second box must keep clear of the first one's new place on the tray, not of its old one on the table."""
    skeleton = pick_and_place(2)
    sequence = solve_sequence(skeleton, SETTINGS, Seed(1), Budget(120.0))
    result = solve_path(skeleton, SETTINGS, Seed(1), Budget(120.0), sequence, pinned=True)
    assert result.feasible
    first = sequence.configurations[2].bodies["item[1]"]
    second = result.paths[3].bodies["item[2]"]
    assert np.linalg.norm(second[:, :3] - first[:3], axis=1).min() > 0.06
