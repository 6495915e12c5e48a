"""Ends that can touch nothing, as they lie inside a link (W0020)."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import check

STDLIB = Path(__file__).parents[2] / "stdlib"
TEXT = """import std.logic
module arm() {{
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    joint j1: revolute(y) in -90 deg .. 90 deg
    link {link}
    {between}
    effector B: gripper {end}
}}
"""
SUNKEN = [
    ("40 cm: capsule(4 cm)", "", "sphere(2 cm)"),
    ("40 cm: capsule(4 cm)", "joint j2: revolute(z) in -90 deg .. 90 deg", "sphere(2 cm)"),
    ("40 cm: capsule(4 cm)", "", "box(2 cm, 2 cm, 2 cm)"),
    ("40 cm: box(9 cm, 9 cm)", "", "sphere(2 cm) at (0, 0, -5 cm)"),
    ("40 cm: cylinder(4 cm)", "", "capsule(1 cm, 2 cm) at (0, 0, -6 cm)"),
    ("40 cm: capsule(4 cm)", "", "cylinder(4 cm, 2 cm)"),
    ("40 cm: capsule(4 cm)", "", "box(20 cm, 20 cm, 2 cm)"),
]
FREE = [
    ("40 cm: capsule(4 cm)", "", "sphere(4 cm)"),
    ("40 cm: capsule(4 cm)", "", "cylinder(4 cm, 2 cm) at (0, 0, 3 cm)"),
    ("40 cm: capsule(4 cm)", "", "sphere(2 cm) at (0, 0, 3 cm)"),
    ("40 cm: box(9 cm, 9 cm)", "", "sphere(2 cm)"),
    ("40 cm: capsule(4 cm)", "joint j2: prismatic(z) in 0 cm .. 9 cm", "sphere(2 cm)"),
    ("40 cm: capsule(4 cm)", "joint j2: revolute(z) in -90 deg .. 90 deg", "box(2 cm, 2 cm, 9 cm)"),
]


@pytest.mark.parametrize("link, between, end, codes",
                         [*((*case, ["W0020"]) for case in SUNKEN), *((*case, []) for case in FREE)])  # fmt: skip
def test_an_end_inside_a_link_is_told(tmp_path: Path, link: str, between: str, end: str, codes: list[str]) -> None:
    file = tmp_path / "arm.tamp"
    file.write_text(TEXT.format(link=link, between=between, end=end))
    assert [d.code for d in check(file)] == codes


@pytest.mark.parametrize("file", sorted(STDLIB.glob("*.tamp")), ids=lambda f: f.stem)
def test_no_end_of_the_standard_library_is_sunken(file: Path) -> None:
    assert "W0020" not in {d.code for d in check(file)}
