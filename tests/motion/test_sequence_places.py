"""Many things on one body, far steps in long skeletons, and robots in loops, before P_seq."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from tamplang.compiler.ir import Shape
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.multi_start import judged_alone
from tamplang.runtime.planner.motion.keyframes.placement_samples import places
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.keyframes.settings import KEYFRAMES
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Skeleton

from .fixtures import climb_alone, pick_and_place

SETTINGS = MotionSettings()
TRAY = (0.7, 0.4, 0.04)


def crowd(n: int) -> Skeleton:
    """n things from two rows on the table to a tray that just holds them."""
    skeleton = pick_and_place(n)
    world = skeleton.problem.world
    bodies = dict(world.bodies)
    for i in range(n):
        name = f"item[{i + 1}]"
        there = (0.49 + 0.12 * (i % 2), 0.15 * (i // 2 - n / 4), 0.07, 0.0, 0.0, 0.0, 1.0)
        bodies[name] = replace(bodies[name], pose=there)
    tray = bodies["goal_tray"]
    bodies["goal_tray"] = replace(tray, shape=Shape("box", TRAY), pose=(0.0, -0.62, *tray.pose[2:]))
    return replace(skeleton, problem=replace(skeleton.problem, world=replace(world, bodies=bodies)))


def test_many_things_get_places_of_their_own() -> None:
    skeleton = crowd(16)
    found = places(skeleton)
    assert sorted(name for _, name in found) == sorted(f"item[{i}]" for i in range(1, 17))
    for one, other in combinations(found.values(), 2):
        assert np.hypot(*(one - other)) >= 0.06 * np.sqrt(2) + KEYFRAMES.gap - 1e-9
    for place in found.values():
        assert np.all(np.abs(place - (0.0, -0.62)) <= np.array(TRAY[:2]) / 2 - 0.03 * np.sqrt(2))


def test_few_things_and_tops_that_are_too_small_are_left_to_chance() -> None:
    assert not places(crowd(KEYFRAMES.laid_out_from - 1))
    assert not places(crowd(40))


def test_places_keep_off_what_lies_there() -> None:
    skeleton = crowd(10)
    problem = skeleton.problem
    there = replace(problem.world.bodies["item[1]"], name="other", pose=(0.1, -0.6, 0.07, 0.0, 0.0, 0.0, 1.0))
    world = replace(problem.world, bodies=problem.world.bodies | {"other": there})
    rests = problem.init_motion | {("stable", "goal_tray", "other")}
    problem = replace(problem, world=world, objects=problem.objects | {"other": "object"}, init_motion=rests)
    found = places(replace(skeleton, problem=problem))
    assert len(found) == 10
    assert min(np.hypot(*(place - (0.1, -0.6))) for place in found.values()) > 0.09


def test_a_tray_that_fills_up_needs_no_way_back() -> None:
    result = solve_sequence(crowd(14), SETTINGS, Seed(0), Budget(60.0))
    assert result.feasible
    assert result.iterations < 3000


def test_a_far_step_late_in_a_long_skeleton_is_refused_soon() -> None:
    skeleton = climb_alone(20, grasp=False)
    world = skeleton.problem.world
    last = world.bodies["stair[20]"]
    far = replace(last, pose=(last.pose[0] + 1.2, *last.pose[1:]))
    problem = replace(skeleton.problem, world=replace(world, bodies=world.bodies | {"stair[20]": far}))
    result = solve_sequence(replace(skeleton, problem=problem), SETTINGS, Seed(0), Budget(60.0))
    assert not result.feasible
    assert result.violations[0].phase == 19
    assert result.iterations < 200


def test_robots_that_stand_on_two_feet_are_judged_from_the_start_only() -> None:
    skeleton = climb_alone(3, grasp=False)
    assert judged_alone(skeleton, 2)
    phase = skeleton.phases[2]
    twice = replace(phase, mode=phase.mode | {("stable", "ground", "c[1].A"), ("stable", "stair[2]", "c[1].B")})
    phases = (*skeleton.phases[:2], twice)
    assert not judged_alone(replace(skeleton, phases=phases), 2)
    assert judged_alone(replace(skeleton, phases=(twice, *phases)), 0)


def test_tight_tops_are_filled_side_by_side() -> None:
    """Fifteen things of 6 cm on 0.5 m × 0.3 m: no room to turn them, but to set them down as they lay."""
    skeleton = pick_and_place(15)
    found = places(skeleton)
    assert len(found) == 15
    for one, other in combinations(found.values(), 2):
        assert np.abs(one - other).max() >= 0.09 - 1e-9
    for place in found.values():
        assert np.all(np.abs(place - (0.0, -0.6)) <= (0.225 + 1e-9, 0.125 + 1e-9))
