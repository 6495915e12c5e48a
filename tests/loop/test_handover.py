"""What one robot cannot carry to its place, another one takes over: a refusal says no more than it was met for."""

from __future__ import annotations

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.skeleton import Bound

TEXT = """
import std.logic
import std.motion
import std.rules

module scara {
    effector foot: gripper box(20 cm, 20 cm, 2 cm) at (0, 0, -4.1 cm) normal (0, 0, -1)
    link 30 cm: capsule(5 cm)
    joint j1: revolute(z) in -150 deg .. 150 deg
    link (35 cm, 0, 0): capsule(4 cm)
    joint j2: revolute(z) in -150 deg .. 150 deg
    link (30 cm, 0, 0): capsule(4 cm)
    joint j3: prismatic(z) in -25 cm .. 5 cm
    effector hand: gripper sphere(2 cm) normal (0, 0, -1)
}

task pass_on() {
    base floor: box(4 m, 2 m, 5 cm) at (0, 0, 0)
    base shelf: box(20 cm, 20 cm, 10 cm) at (-80 cm, 30 cm, 7.5 cm)
    base tray: box(20 cm, 20 cm, 10 cm) at (80 cm, 30 cm, 7.5 cm)
    object can: cylinder(3 cm, 10 cm) on shelf at (0, 0)
    scara left: foot on floor at (-50 cm, 0)
    scara right: foot on floor at (50 cm, 0)
    fact (grippable can)
    fact (tray tray)
    goal (on tray can)
}
"""


def test_two_arms_pass_on_what_neither_can_bring() -> None:
    outcome = solve(compile_text(TEXT, "pass_on.tamp", None, {})[0], SolveOptions(time=120.0, bound=Bound.SEQ))
    assert outcome.status == "solved"
    assert outcome.actions == ["grasp(left.hand, can)", "grasp(right.hand, can)", "place(right.hand, can, tray)"]
