"""Modules of few joints that dock: their ends meet in few postures only."""

from __future__ import annotations

import pytest

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve

CUBES = """
import std.rules
## Two half cylinders on parallel hinges.
module halves {
    effector A: gripper sphere(2 cm) normal (0, 0, -1)
    link 3 cm
    link 5 cm: capsule(4.5 cm)
    joint j1: revolute(y) in -90 deg .. 90 deg
    link 10 cm
    joint j2: revolute(y) in -90 deg .. 90 deg
    link 5 cm: capsule(4.5 cm)
    link 3 cm
    effector B: gripper sphere(2 cm)
    fact (linked A B)
}
task docked() {
    base floor: box(1 m, 1 m, 2 cm) at (0, 0, 0)
    for k in 1 .. 2 { halves m[k]: A on floor at (24 cm * k, 0) }
    goal (connected m[1].B m[2].B)
}
"""


@pytest.mark.parametrize("seed", [0, 3, 6, 7])
def test_ends_of_modules_with_two_hinges_meet_with_every_seed(seed: int) -> None:
    problem, _ = compile_text(CUBES, seed=seed)
    outcome = solve(problem, SolveOptions(seed=seed, time=60.0, bound="seq"))
    assert outcome.status == "solved" and outcome.misses == []
