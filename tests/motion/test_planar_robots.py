"""Robots whose joints all turn about one axis walk: where a foot is set down says how it is turned, too."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tamplang.compiler.ir import Module
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.motion.keyframes.initial_guesses import effector_pose
from tamplang.runtime.planner.motion.keyframes.posture_samples import Aim, closing, freedom

HEAD = """
import std.motion
import std.rules

module inchworm(size: length = 0.6 m, far: angle = 120 deg) {
    effector A: gripper sphere(4 cm) normal (0, 0, -1)
    link 0.1 * size: capsule(3 cm)
    joint j1: revolute(y) in -far .. far home 40 deg
    link 0.4 * size: capsule(3 cm)
    joint j2: revolute(y) in -far .. far home 60 deg
    link 0.4 * size: capsule(3 cm)
    joint j3: revolute(y) in -far .. far home 40 deg
    link 0.1 * size: capsule(3 cm)
    effector B: gripper sphere(4 cm)
    fact (linked A B)
}

module telescope() {
    effector A: gripper sphere(4 cm) normal (0, 0, -1)
    link 10 cm: capsule(3 cm)
    joint j1: revolute(y) in -150 deg .. 150 deg home 45 deg
    link 15 cm: capsule(3 cm)
    joint out: prismatic(z) in 0 cm .. 30 cm home 10 cm
    link 15 cm: capsule(2 cm)
    joint j2: revolute(y) in -150 deg .. 150 deg home 90 deg
    link 10 cm: capsule(3 cm)
    effector B: gripper sphere(4 cm)
    fact (linked A B)
}
"""
BENDS = "".join(f"    link 12 cm: capsule(25 mm)\n    joint j{k}: revolute(y) in -90 deg .. 90 deg home 20 deg\n"
                for k in range(2, 8))  # fmt: skip
SNAKE = f"""
module snake() {{
    effector A: gripper sphere(4 cm) normal (0, 0, -1)
    link 6 cm: capsule(25 mm)
    joint j1: revolute(y) in -90 deg .. 90 deg home 20 deg
{BENDS}    link 6 cm: capsule(25 mm)
    effector B: gripper sphere(4 cm)
    fact (linked A B)
}}
"""


def walk(robot: str, gap: str, pads: int, turn: int) -> str:
    return f"""{HEAD}{SNAKE}
task walk() {{
    for i in 0 .. {pads - 1} {{
        base pad[i]: box(18 cm, 18 cm, 5 cm) at ({gap} * i * cos({turn} deg), {gap} * i * sin({turn} deg), 0)
            heading {turn} deg
    }}
    {robot} w: A on pad[0]
    goal (on pad[{pads - 1}] w.A)
}}"""


def module(robot: str) -> Module:
    problem, _ = compile_text(walk(robot, "25 cm", 2, 0))
    return problem.world.modules["w"]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(
    ("robot", "gap", "pads", "turn"),
    [
        ("inchworm", "25 cm", 3, 0),
        ("inchworm", "20 cm", 3, 70),
        ("inchworm(far = 170 deg)", "30 cm", 3, 0),
        ("inchworm(size = 1 m)", "40 cm", 5, 0),
        ("telescope", "25 cm", 3, 200),
        ("snake", "25 cm", 3, 0),
    ],
)
def test_planar_robots_walk_from_pad_to_pad(robot: str, gap: str, pads: int, turn: int, seed: int) -> None:
    problem, _ = compile_text(walk(robot, gap, pads, turn))
    outcome = solve(problem, SolveOptions(seed=seed, time=60.0))
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified


def test_a_pad_beside_the_plane_of_a_robot_is_refused() -> None:
    text = walk("inchworm", "25 cm", 2, 0).replace("heading 0 deg\n", "heading 60 deg * (1 - i)\n")
    problem, _ = compile_text(text)
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "exhausted"


@pytest.mark.parametrize(("robot", "directions"), [("inchworm", 3), ("telescope", 3), ("snake", 3)])
def test_the_freedom_of_a_hand_is_counted_in_directions_not_in_joints(robot: str, directions: int) -> None:
    assert freedom(module(robot).type, "A", "B") == directions
    assert freedom(module(robot).type, "B", "A") == directions


@pytest.mark.parametrize("robot", ["inchworm", "telescope", "snake"])
def test_a_posture_is_closed_where_its_aim_is_in_reach(robot: str) -> None:
    worm = module(robot)
    foot = effector_pose(worm, "A", np.array([*worm.pose, *worm.joints]))
    point = np.array([foot[0] + 0.3, foot[1], foot[2] + 0.05])
    values = closing(worm, np.array(worm.joints), ("A", foot), Aim("B", point, 0.0), 0.1)
    slot = np.array([*worm.pose, *values])
    apart = math.dist(effector_pose(worm, "A", slot)[:3], effector_pose(worm, "B", slot)[:3])
    assert abs(apart - math.dist(foot[:3], point)) < 1e-3
    assert all(j.lower < q < j.upper for j, q in zip(worm.type.joints, values, strict=True))
