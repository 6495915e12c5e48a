"""Joints that turn more than once around take the short way from switch to switch."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.motion.keyframes.unwinding import unwound
from tamplang.runtime.skeleton import start_configuration

TURNTABLE = """
import std.rules
module arm {
    effector A: gripper sphere(4 cm) normal (0, 0, -1)
    joint j: revolute(z) in -400 deg .. 400 deg
    link 20 cm: capsule(3 cm)
    joint k: revolute(y) in -100 deg .. 100 deg
    link 20 cm: capsule(3 cm)
    effector B: gripper sphere(4 cm)
    fact (linked A B)
}
task t() {
    base stand: box(30 cm, 30 cm, 10 cm) at (0, 0, -5 cm)
    arm a: A on stand
    goal (on stand a.B)
}
"""


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ([0.0, 6.0, 5.5], [0.0, 6.0 - 2 * math.pi, 5.5 - 2 * math.pi]),
        ([0.0, 6.5, 6.5, 0.3], [0.0, 6.5 - 2 * math.pi, 6.5 - 2 * math.pi, 0.3]),
        ([0.0, 3.0, 5.9, 6.9], [0.0, 3.0, 5.9, 6.9]),  # on and on
        ([0.0, 1.0, 0.5], [0.0, 1.0, 0.5]),
        ([0.0, 3.5, -3.5, -6.9], [0.0, 3.5 - 2 * math.pi, -3.5, 2 * math.pi - 6.9]),
    ],
)
def test_whole_turns_are_left_out(given: list[float], kept: list[float]) -> None:
    problem, _ = compile_text(TURNTABLE)
    start = start_configuration(problem)
    switches = [start.copy() for _ in given]
    for switch, value in zip(switches, given, strict=True):
        switch.modules["a"][7:] = value, 0.5
    found = np.array([c.modules["a"][7:] for c in unwound(problem, switches)])
    assert found[:, 0] == pytest.approx(kept)
    assert found[:, 1] == pytest.approx(0.5)
    assert (np.abs(found[:, 0]) <= math.radians(400)).all()
