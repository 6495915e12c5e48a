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


@pytest.mark.parametrize("out, told", [("0", True), ("6 cm", False)])
def test_an_end_inside_the_hull_of_a_mesh_is_told(tmp_path: Path, out: str, told: bool) -> None:
    corners = [f"{x} {y} {z}" for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)]
    sides = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    turned = "\n".join([f"v {c}" for c in corners] + ["v 0 0 0.06"] + [f"f {s}" for s in sides[:5]] + ["f 2 6 9"] +
                       ["f 6 8 9", "f 8 4 9", "f 4 2 9"])  # fmt: skip
    (tmp_path / "hand.obj").write_text(turned)
    (tmp_path / "arm.urdf").write_text(
        '<robot name="m"><link name="foot"/><link name="hand"><collision><geometry><mesh filename="hand.obj"/>'
        '</geometry></collision></link><joint name="j" type="revolute"><parent link="foot"/><child link="hand"/>'
        '<axis xyz="0 1 0"/>'
        '<origin xyz="0 0 0.3"/><limit lower="-1" upper="1" effort="9" velocity="1"/></joint></robot>'
    )
    (tmp_path / "m.tamp").write_text(
        'import std.logic\nmodule m from urdf "arm.urdf" {\n'
        '    effector A: gripper "foot" sphere(5 cm) normal (0, 0, -1)\n'
        f'    effector B: gripper "hand" sphere(2 cm) at (0, 0, {out})\n}}\n'
    )
    assert ("W0020" in [d.code for d in check(tmp_path / "m.tamp")]) is told
