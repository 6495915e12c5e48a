"""Feet and things on tops that are narrower than the usual way from their edges."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import tamplang

TEXT = """
import std.rules

module mast(high: length = 60 cm) {
    effector Foot: gripper sphere(4 cm) normal (0, 0, -1)
    link (0, 0, high)
    joint out: prismatic(x) in 0 m .. 1.5 m home 30 cm
    joint side: prismatic(y) in -80 cm .. 80 cm
    joint down: prismatic(z) in -55 cm .. 0 m home -10 cm
    effector Hand: gripper sphere(2 cm) normal (0, 0, -1)
    fact (linked Foot Hand)
}
task narrow(foot: length = 4 cm, tray: length = 6 cm) {
    object post: box(foot, foot, 5 cm) at (0, 0, -2.5 cm)
    object table: box(40 cm, 80 cm, 10 cm) at (1 m, 0, 3 cm)
    object stand: cylinder(tray / 2, 10 cm) at (60 cm, 30 cm, 3 cm)
    fact (tray stand)
    object thing: box(8 cm, 8 cm, 8 cm) on table
    fact (grippable thing)
    mast m: Foot on post
    goal (on stand thing)
}
"""


@pytest.mark.parametrize("sizes", [{}, {"foot": "3 cm", "tray": "3.5 cm"}])
def test_a_narrow_foothold_and_a_narrow_stand_are_enough(tmp_path: Path, sizes: dict[str, str]) -> None:
    path = tmp_path / "narrow.tamp"
    path.write_text(TEXT)
    result = tamplang.load(path, **sizes).solve(time=60.0)
    assert result.plan is not None and result.plan.verify().verified
    x, y = [t for t in result.plan.record.body_tracks if t.name == "thing"][-1].poses[-1][:2]
    width = float(sizes.get("tray", "6 cm").split()[0]) / 100
    assert math.hypot(x - 0.6, y - 0.3) <= width / 4 + 2e-3
