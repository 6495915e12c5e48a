"""What one robot cannot carry to its place, another one takes over: a refusal says no more than it was met for."""

from __future__ import annotations

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.skeleton import Bound

ARM = """
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
"""

PASS_ON = """
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


SORT = """
task sort() {
    base floor: box(6 m, 6 m, 5 cm) at (0, 0, 0)
    for i in 1 .. 4 {
        base shelf[i]: box(20 cm, 20 cm, 10 cm) at (-3 m + 1.2 m * i, 50 cm, 7.5 cm)
        base bin[i]: box(20 cm, 20 cm, 10 cm) at (-3 m + 1.2 m * i, -50 cm, 7.5 cm)
        object can[i]: cylinder(3 cm, 10 cm) on shelf[i] at (0, 0)
        scara s[i]: foot on floor at (-3 m + 1.2 m * i, 0)
        fact (grippable can[i])
        fact (tray bin[i])
        goal (on bin[i] can[i])
    }
}
"""


def test_two_arms_pass_on_what_neither_can_bring() -> None:
    outcome = solve(compile_text(ARM + PASS_ON, "pass_on.tamp", None, {})[0], SolveOptions(time=120.0, bound=Bound.SEQ))
    assert outcome.status == "solved"
    assert outcome.actions == ["grasp(left.hand, can)", "grasp(right.hand, can)", "place(right.hand, can, tray)"]


def test_arms_on_one_floor_find_who_reaches_what() -> None:
    """Logic knows only that all of them stand on the floor, as do the things."""
    outcome = solve(compile_text(ARM + SORT, "sort.tamp", None, {})[0], SolveOptions(time=120.0, bound=Bound.SEQ))
    assert outcome.status == "solved"
    assert sorted(outcome.actions) == sorted(
        action
        for i in range(1, 5)
        for action in (f"grasp(s[{i}].hand, can[{i}])", f"place(s[{i}].hand, can[{i}], bin[{i}])")
    )
