"""Scenes of rai become modules and bodies that lie where rai's own reader (PyPI `robotic` 0.4.2) put them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.poses import compose

from .conftest import Command, problems, refused
from .kinematics import poses

SCENE = """world: {}
table (world): { shape: ssBox, Q: "t(0 0 .6) d(30 0 0 1)", size: [2., 2., .06, .02], color: [.3, .3, .3], contact }
j1 (table): { joint: hingeX, pre: "t(0 0 .1) d(20 0 1 0)", Q: "d(10 1 0 0)", limits: [-1, 1] }
l1 (j1): { Q: [0, 0, .3, .9, .1, .2, .3], shape: capsule, size: [.3, .05], mass: 1 }
Prefix: "R_"
j2 (l1): { joint: transZ, limits: [0, .2] }
l2 (R_j2): { shape: cylinder, size: [.2, .03], Q: "t(0 0 .1)" }
Prefix!
Edit l1: { mass: 2, Q: [0, 0, .4] }
box (world): { shape: box, X: [1, 0, .1, 1, 0, 0, 0], size: [.1, .2, .3], joint: rigid, logical: { a, b: 2 } }
cam (world): { shape: marker, size: [.1] }
Prefix: "P_"
Include: <hand.g>
Prefix!
Edit P_a(table): { Q: "t(0 0 2)" }
"""
HAND = """# a hand
a: { shape: sphere, size: [.1] }
b (a): { joint: hingeX, Q: "t(0 0 .1)", limits: [-1, 1] }
c (b): { Q: [0, 0, .1], shape: mesh, mesh: <x.ply> }
"""
J1 = (0.0, 0.0, 0.7, 0.038135, 0.189308, 0.239298, 0.951549)
L2 = (0.189261, 0.009014, 1.162708)


def test_a_scene_lies_where_rai_puts_it(command: Command) -> None:
    Path("s.g").write_text(SCENE)
    Path("hand.g").write_text(HAND)
    answer = command("import", "s.g", "-o", "s.tamp")
    assert answer.status == 0 and "hand.g:3:" in answer.told and "the mesh of `P_c`" in answer.told
    assert problems(command, "s.tamp") == []
    text = Path("s.tamp").read_text()
    assert "base table: box(2 m, 2 m, 0.06 m) at (0 m, 0 m, 0.6 m)" in text
    assert "object box_: box(0.1 m, 0.2 m, 0.3 m) at (1 m, 0 m, 0.1 m)" in text and "(grippable box_)" in text
    table = (0.0, 0.0, 0.6, 0.0, 0.0, 0.258819045102521, 0.965925826289068)
    found = poses(Path("s_j1.urdf").read_text(), {"j1": 0.17453292519943295})
    assert compose(table, found["j1"]) == pytest.approx(J1, abs=1e-6)
    assert compose(table, found["R_l2"])[:3] == pytest.approx(L2, abs=1e-6)
    assert poses(Path("s_P_a.urdf").read_text(), {})["P_c"][:3] == pytest.approx((0, 0, 0.2), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("a", "E0020"), ("a {", "E0019"), ("a: { b: ", "E0019"), ("a (", "E0019"), ("}", "E0019"), ("a b c", "E0019"),
        ("a: { { }", "E0019"), ("$", "E0020"), ('a: { "', "E0019"), ("a {} a {}", "E0022"), ("a (b) {}", "E0022"),
        ("Edit a: {}", "E0020"), ("Delete a:", "E0020"), ("a {} b {} c (a b) {}", "E0022"),
        ("Include: <s.g>", "E0022"), ("Include: </etc/passwd>", "E0022"), ("Include: <none.g>", "E0022"),
        ("Include", "E0019"), ('a: { Q: "t(0 0)" }', "E0019"), ('a: { Q: "t(0 0 inf)" }', "E0019"),
        ('a: { Q: "z(0 0 1)" }', "E0019"), ("a: { Q: [1, 2] }", "E0019"), ("a: { Q: [0, 0, 0, 0] }", "E0019"),
        ("a: { shape: box, size: [1, 2] }", "E0022"), ("a: { shape: box, size: [1, 2, x] }", "E0022"),
        ("a: { shape: sphere }", "E0022"), ("a {} b (a) {} Edit a (b) {}", "E0022"),
        ("a: {} b (a): { joint: hingeX, limits: [1] }", "E0022"),
    ],
)  # fmt: skip
def test_bad_scenes_are_refused(command: Command, text: str, code: str) -> None:
    Path("s.g").write_text(text + "\n")
    told = refused(command, {code}, "s.g")
    assert code == "E0020" or "--> s.g:1:" in told


@pytest.mark.parametrize("written", ['"[-0.4, -0.3, 0, 0.707107, 0, 0, 0.707107]"', '"-.4 -.3 0 .707107 0 0 .707107"'])
def test_a_text_of_seven_numbers_is_a_pose_and_a_change_of_nothing_is_told(command: Command, written: str) -> None:
    box = f"a (w): {{ Q: {written}, shape: box, size: [.1, .1, .1] }}"
    Path("s.g").write_text(f"w: {{}}\n{box}\nEdit b: {{ mass: 1 }}\n")
    answer = command("import", "s.g", "-o", "o.tamp")
    assert answer.status == 0 and "W0019" in answer.told and "no frame `b`" in answer.told, answer.told
    assert "at (-0.4 m, -0.3 m, 0 m) heading 1.570796326" in Path("o.tamp").read_text()
