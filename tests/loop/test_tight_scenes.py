"""Scenes with less room than the margin that is wished for: it is a wish, and only contact is the limit."""

from __future__ import annotations

from pathlib import Path

import pytest

import tamplang

GANTRY = """
import std.rules
module gantry() {
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    link (0, 0, 1 m)
    joint dx: prismatic(x) in 0 m .. 2 m
    joint dy: prismatic(y) in -1 m .. 1 m
    joint dz: prismatic(z) in -0.95 m .. 0 m
    effector B: gripper sphere(1 cm) normal (0, 0, -1)
    fact (linked A B)
}
module plated(thick: length) {
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    link (0, 0, 1 m)
    joint dx: prismatic(x) in 0 m .. 2 m home 0.5 m
    joint dy: prismatic(y) in -1 m .. 1 m
    joint dz: prismatic(z) in -0.95 m .. 0 m home -0.3 m
    branch { link thick: box(24 cm, 24 cm) }
    link (0, 0, -10 cm)
    effector B: gripper sphere(2 cm) normal (0, 0, -1)
    fact (linked A B)
}
scene shop() {
    base foot: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, -0.025 m)
    object item: box(4 cm, 4 cm, 4 cm) at (1.5 m, 0, 0.1 m)
    fact (grippable item)
}
## At the lower limit of two joints, `gap` from a block in front.
task beside(gap: length = 1 mm) {
    scene shop()
    object block: box(0.2 m, 0.2 m, 0.2 m) at (0.11 m + gap, 0, 1 m)
    gantry g: A on foot
    goal (held item)
}
## Between four walls, `gap` from each.
task in_bin(gap: length = 2 mm) {
    scene shop()
    object floor: box(0.5 m, 0.5 m, 0.1 m) at (1.5 m, 0, 0.03 m)
    for k in 0 .. 1 {
        object x[k]: box(2 cm, 4 cm, 6 cm) at (1.5 m + (2 * k - 1) * (3 cm + gap), 0, 0.11 m)
        object y[k]: box(10 cm, 2 cm, 6 cm) at (1.5 m, (2 * k - 1) * (3 cm + gap), 0.11 m)
    }
    object shelf: box(0.3 m, 0.3 m, 2 cm) at (1 m, 0.5 m, 0.1 m)
    fact (tray shelf)
    gantry g: A on foot
    goal (on shelf item)
}
## With a plate on the tool.
task plate(thick: length = 1 mm) {
    scene shop()
    plated(thick = thick) g: A on foot
    goal (held item)
}
"""
SHEET = """
import std.crawler
import std.rules
task sheet(thick: length) {
    base pedestal: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    object table: box(0.4 m, 1.4 m, 0.04 m) at (0.55 m, 0, 0.02 m)
    object dish: box(0.5 m, 0.3 m, 0.04 m) at (0, -0.6 m, 0.02 m)
    fact (tray dish)
    object item: box(0.1 m, 0.06 m, thick) on table
    fact (grippable item)
    crawler c: A on pedestal
    goal (on dish item)
}
"""


def solved(tmp_path: Path, text: str, task: str, **parameters: str) -> tamplang.Plan:
    path = tmp_path / "scene.tamp"
    path.write_text(text)
    result = tamplang.load(path, task, **parameters).solve(time=90.0)
    assert result.plan is not None, [e.message for e in result.explanation]
    assert result.plan.verify().verified
    return result.plan


@pytest.mark.parametrize("gap", ["0 mm", "2 mm"])
def test_an_arm_at_its_limits_leaves_a_block_beside_it(tmp_path: Path, gap: str) -> None:
    solved(tmp_path, GANTRY, "beside", gap=gap)


def test_a_thing_is_lifted_out_of_a_narrow_bin(tmp_path: Path) -> None:
    assert len(solved(tmp_path, GANTRY, "in_bin").actions) == 2


def test_a_thin_plate_is_carried_like_a_thick_one(tmp_path: Path) -> None:
    solved(tmp_path, GANTRY, "plate")


@pytest.mark.parametrize("thick", ["12 mm", "2 mm"])
def test_a_sheet_is_taken_from_a_table(tmp_path: Path, thick: str) -> None:
    solved(tmp_path, SHEET, "sheet", thick=thick)
