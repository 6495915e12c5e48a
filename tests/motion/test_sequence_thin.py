"""P_seq where things lie nearer to each other than the usual margin: a low foot, and a thin plate on a table."""

from __future__ import annotations

from pathlib import Path

import pytest

import tamplang

TEXT = """
import std.rules

## An arm whose first link begins 2 cm above the floor.
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

task sort(thickness: length = 1 cm) {
    base bench: box(1.4 m, 1.4 m, 4 cm) at (0, 0, -2 cm)
    object plate: box(20 cm, 20 cm, thickness) on bench at (0.3 m, 0.4 m)
    object ball: sphere(3 cm) on bench at (45 cm, 0)
    fact (tray plate)
    fact (grippable ball)
    lamp l: Foot on bench
    goal (on plate ball)
}
"""


@pytest.mark.parametrize("seed", range(2))
def test_a_low_foot_and_a_thin_plate_are_no_collisions(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "sort.tamp"
    path.write_text(TEXT)
    result = tamplang.load(path, seed=seed).solve(time=30.0)
    assert result.status == "solved"
    assert result.plan is not None
    assert [a.partition("(")[0] for a in result.plan.actions] == ["grasp", "place"]
    assert result.plan.verify().verified
