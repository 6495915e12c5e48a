"""P_seq on spans that only just can or cannot be done, and the exactness of what it accepts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.keyframe_program import SwitchProgram
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Skeleton

from .fixtures import climb_alone, climb_together, pick_and_place

SETTINGS = MotionSettings()


def moved(skeleton: Skeleton, name: str, by: tuple[float, float, float]) -> Skeleton:
    world = skeleton.problem.world
    body = world.bodies[name]
    x, y, z, *turn = body.pose
    there = replace(body, pose=(x + by[0], y + by[1], z + by[2], *turn))
    problem = replace(skeleton.problem, world=replace(world, bodies=dict(world.bodies) | {name: there}))
    return replace(skeleton, problem=problem)


@pytest.mark.parametrize(
    "skeleton",
    [
        moved(climb_alone(2), "target", (0.0, 0.0, 0.3)),
        moved(pick_and_place(2), "goal_tray", (0.0, -0.6, 0.0)),
        moved(pick_and_place(2), "item[2]", (0.6, 0.0, 0.0)),
        climb_together(1, stride=7),
    ],
    ids=["target", "tray", "item", "stride"],
)
def test_what_is_out_of_reach_is_refused_soon(skeleton: Skeleton) -> None:
    result = solve_sequence(skeleton, SETTINGS, Seed(0), Budget(60.0))
    assert not result.feasible
    assert result.violations[0].amount > 0.01
    assert result.iterations < 500


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("skeleton", [climb_alone(20, seed=1), pick_and_place(4)], ids=["windows", "whole"])
def test_accepted_switches_are_exact(skeleton: Skeleton, seed: int) -> None:
    result = solve_sequence(skeleton, SETTINGS, Seed(seed), Budget(60.0))
    assert result.feasible
    start, *_ = result.configurations
    switches = SwitchProgram(skeleton, 0, len(skeleton) - 1, start, SETTINGS, frozen=False)
    x = switches.pack(result.configurations)
    switches.prepare(x)
    assert switches.program().largest(x) < 2e-6
