"""P_seq of arms with few joints: targets on all sides of the start, and things to sort that lie around it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.motion.keyframes.initial_guesses import effector_pose
from tamplang.runtime.planner.motion.keyframes.posture_samples import Aim, reaching
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Skeleton

HEAD = """
import std.rules

## Three joints: it turns, bends and slides out.
module hook() {
    effector Foot: gripper box(10 cm, 10 cm, 4 cm) normal (0, 0, -1)
    link 4 cm: cylinder(3 cm)
    joint turn: revolute(z) in -175 deg .. 175 deg
    link 30 cm: capsule(3 cm)
    joint shoulder: revolute(y) in 0 deg .. 130 deg home 20 deg
    link 30 cm: capsule(3 cm)
    link 6 cm
    joint out: prismatic(z) in 0 cm .. 30 cm
    link 4 cm
    effector Hand: gripper sphere(3 cm)
}

## Three joints that turn.
module boom() {
    effector Foot: gripper box(10 cm, 10 cm, 4 cm) normal (0, 0, -1)
    link 4 cm: cylinder(3 cm)
    joint turn: revolute(z) in -175 deg .. 175 deg
    link 30 cm: capsule(3 cm)
    joint shoulder: revolute(y) in -20 deg .. 110 deg home 20 deg
    link 35 cm: capsule(3 cm)
    joint elbow: revolute(y) in 10 deg .. 140 deg home 60 deg
    link 35 cm: capsule(3 cm)
    effector Hand: gripper sphere(3 cm)
}
"""
LAMP = """
## Four joints, the last three in one plane.
module lamp() {
    effector Foot: gripper box(10 cm, 10 cm, 4 cm) normal (0, 0, -1)
    link 4 cm: cylinder(3 cm)
    joint turn: revolute(z) in -170 deg .. 170 deg
    link 20 cm: capsule(3 cm)
    joint shoulder: revolute(y) in -100 deg .. 100 deg home 20 deg
    link 35 cm: capsule(3 cm)
    joint elbow: revolute(y) in -140 deg .. 140 deg home 60 deg
    link 35 cm: capsule(3 cm)
    joint wrist: revolute(y) in -110 deg .. 110 deg
    link 5 cm
    effector Hand: gripper sphere(3 cm)
}
"""
BENCH = """
task sort() {
    base bench: box(1.6 m, 1.6 m, 4 cm) at (0, 0, -2 cm)
    object ball[1]: sphere(3 cm) on bench at (-45 cm, 0)
    object ball[2]: sphere(3 cm) on bench at (0, -45 cm)
    fact (grippable ball[1])
    fact (grippable ball[2])
"""
PLATE = """
    object red: box(25 cm, 25 cm, 1 cm) on bench at (0 cm, 45 cm)
    fact (tray red)
    hook l: Foot on bench
    goal (on red ball[1]) and (on red ball[2])
}
"""
SHELF = """
    object shelf: box(30 cm, 30 cm, 2 cm) at (0 cm, 45 cm, 60 cm)
    fact (tray shelf)
    lamp l: Foot on bench
    goal (on shelf ball[1]) and (on shelf ball[2])
}
"""
TRAYS = """
    object red: box(25 cm, 25 cm, 1 cm) on bench at (30 cm, 40 cm)
    object blue: box(25 cm, 25 cm, 1 cm) on bench at (-30 cm, 40 cm)
    fact (tray red)
    fact (tray blue)
    object ball[3]: sphere(3 cm) on bench at (-45 cm, -15 cm)
    fact (grippable ball[3])
    lamp l: Foot on bench
    goal (on red ball[1]) and (on blue ball[2]) and (on red ball[3])
}
"""


def taking(arm: str, angle: float, far: float, height: float) -> Skeleton:
    """The arm takes a ball that hangs in the air: where, by cylinder coordinates."""
    x, y = far * math.cos(angle), far * math.sin(angle)
    text = f"""{HEAD}
task take() {{
    base bench: box(2 m, 2 m, 4 cm) at (0, 0, -2 cm)
    object ball: sphere(3 cm) at ({x:.3f} m, {y:.3f} m, {height} m)
    fact (grippable ball)
    {arm} l: Foot on bench
    goal (grasped l.Hand ball)
}}"""
    problem, _ = compile_text(text)
    successors = Successors(problem)
    action = next(
        a for a in (successors.action(n) for _, n in successors.expand(successors.initial)) if a.rule == "grasp"
    )
    return build_skeleton(problem, [action], successors)


@pytest.mark.parametrize("angle", [math.pi * k / 4 + 0.1 for k in range(8)])
@pytest.mark.parametrize(("arm", "far", "height"), [("hook", 0.5, 0.3), ("boom", 0.5, 0.2), ("boom", 0.3, 0.85)])
def test_targets_on_all_sides_are_reached(arm: str, far: float, height: float, angle: float) -> None:
    skeleton = taking(arm, angle, far, height)
    for seed in range(3):
        assert solve_sequence(skeleton, MotionSettings(), Seed(seed), Budget(20.0), tries=3).feasible


def test_what_is_out_of_reach_is_still_refused() -> None:
    skeleton = taking("boom", math.pi, 0.8, 0.9)
    result = solve_sequence(skeleton, MotionSettings(), Seed(0), Budget(20.0))
    assert not result.feasible
    assert result.violations[0].amount > 0.05
    assert result.iterations < 250


def test_postures_come_near_and_keep_the_limits() -> None:
    skeleton = taking("boom", math.pi, 0.5, 0.3)
    module = skeleton.problem.world.modules["l"]
    foot = effector_pose(module, "Foot", np.array([*module.pose, *module.joints]))
    for seed in range(10):
        aim = Aim("Hand", np.array([-0.5, 0.0, 0.3]), 0.06)
        values = reaching(module, np.array(module.joints), ("Foot", foot), aim, 0.1, np.random.default_rng(seed))
        hand = effector_pose(module, "Hand", np.array([*module.pose, *values]))
        assert math.dist(hand[:3], aim.point) < 0.3
        assert all(j.lower + 0.09 < q < j.upper - 0.09 for j, q in zip(module.type.joints, values, strict=True))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("rest", "length"), [(PLATE, 4), (SHELF, 4), (TRAYS, 6)], ids=["plate", "shelf", "trays"])
def test_small_arms_sort_what_lies_around_them(rest: str, length: int, seed: int) -> None:
    problem, _ = compile_text(HEAD + LAMP + BENCH + rest)
    outcome = solve(problem, SolveOptions(seed=seed, time=30.0))
    assert outcome.status == "solved"
    assert len(outcome.actions) == length
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
