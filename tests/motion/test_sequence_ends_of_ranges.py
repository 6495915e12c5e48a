"""P_seq where joints come to the ends of their ranges: an arm of four joints that just reaches what it sorts."""

from __future__ import annotations

import pytest

from tamplang.compiler.ir import Action
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Skeleton

TEXT = """import std.rules

module scara() {
    effector A: gripper box(12 cm, 12 cm, 2 cm) normal (0, 0, -1)
    link (0, 0, 40 cm): box(10 cm, 10 cm)
    joint shoulder: revolute(z) in -150 deg .. 150 deg
    link (35 cm, 0, 0): capsule(3 cm)
    joint elbow: revolute(z) in -140 deg .. 140 deg home 40 deg
    link (30 cm, 0, 0): capsule(3 cm)
    joint quill: prismatic(z) in -30 cm .. 0 m
    joint wrist: revolute(z) in -180 deg .. 180 deg
    link (0, 0, -6 cm): capsule(1 cm)
    effector B: gripper sphere(1.5 cm) normal (0, 0, -1)
    fact (linked A B)
}
task sort() {
    base mount: box(20 cm, 20 cm, 4 cm) at (0, 0, 2 cm)
    object feeder: box(20 cm, 50 cm, 4 cm) at (45 cm, 0, 2 cm)
    object left: box(20 cm, 20 cm, 4 cm) at (0, 45 cm, 2 cm)
    object right: box(20 cm, 20 cm, 4 cm) at (0, -45 cm, 2 cm)
    fact (tray left)
    fact (tray right)
    for i in 1 .. 3 {
        object part[i]: box(4 cm, 4 cm, 4 cm) on feeder at (0, 12 cm * (i - 2))
        fact (grippable part[i])
    }
    scara s: A on mount
    goal (on left part[1]) and (on right part[2]) and (on left part[3])
}
"""
SORTED = (("part[1]", "left"), ("part[3]", "left"), ("part[2]", "right"))


@pytest.fixture(scope="module")
def skeleton(tmp_path_factory: pytest.TempPathFactory) -> Skeleton:
    file = tmp_path_factory.mktemp("scara") / "sort.tamp"
    file.write_text(TEXT)
    problem, _ = compile_problem(file, None, {}, 0)
    moves = [(Action("grasp", ("s.B", part)), Action("place", ("s.B", part, tray))) for part, tray in SORTED]
    return build_skeleton(problem, [action for move in moves for action in move])


@pytest.mark.parametrize("seed", [2, 9])
def test_what_stalls_close_to_feasible_is_no_refusal(skeleton: Skeleton, seed: int) -> None:
    assert solve_sequence(skeleton, MotionSettings(), Seed(seed), Budget(None)).feasible
