"""Effectors of several convex shapes: a fork that comes astride of a brick, from text and from a URDF, and a hook."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

import tamplang
from tamplang import cli
from tamplang.compiler.pipeline import compile_problem

FORK = """union(box(12 cm, 4 cm, 1 cm),
        box(1 cm, 4 cm, 6 cm) at (APART, 0, 3.5 cm), box(1 cm, 4 cm, 6 cm) at (-APART, 0, 3.5 cm))"""
HOOK = "union(box(2 cm, 2 cm, 8 cm) at (0, 0, 4 cm), box(7 cm, 2 cm, 1 cm) at (25 mm, 0, 85 mm))"
ASTRIDE = """at switch position(A) - position(X) = (0, 0, 5 cm)
    at switch dot(axis(A, y), axis(X, x)) = 0"""
BRICK = "box(9 cm, 8 cm, 9 cm)"
BASKET = """union(box(8 cm, 8 cm, 2 cm), box(1 cm, 4 cm, 12 cm) at (35 mm, 0, 7 cm),
        box(1 cm, 4 cm, 12 cm) at (-35 mm, 0, 7 cm), box(8 cm, 4 cm, 1 cm) at (0, 0, 135 mm))"""
ARM = """module arm() {
    effector foot: flange cylinder(8 cm, 2 cm) at (0, 0, 1 cm) normal (0, 0, -1)
    link 12 cm: cylinder(6 cm)
    joint pan: revolute(z) in -170 deg .. 170 deg
    link 20 cm: capsule(5 cm)
    joint lift: revolute(y) in -120 deg .. 120 deg home 20 deg
    link 35 cm: capsule(4 cm)
    joint elbow: revolute(y) in -150 deg .. 150 deg home 90 deg
    link 30 cm: capsule(35 mm)
    joint w1: revolute(y) in -120 deg .. 120 deg home 60 deg
    joint w2: revolute(z) in -170 deg .. 170 deg
    link 6 cm: capsule(25 mm)
    effector tool: gripper TOOL at (0, 0, 3 cm) normal (0, 0, 1)
}"""
FROM_URDF = """module arm from urdf "arm.urdf" {
    effector foot: flange "base" cylinder(8 cm, 2 cm) at (0, 0, 1 cm) normal (0, 0, -1)
    effector tool: gripper "hand" at (0, 0, 3 cm)
    joint lift in -120 deg .. 120 deg home 20 deg
    joint elbow in -150 deg .. 150 deg home 90 deg
    joint w1 in -120 deg .. 120 deg home 60 deg
}"""
TASK = """
import std.logic
import std.motion
type flange < effector
ARM
placement (A: flange) on (Y: object) { (support A), (on Y A), [stable Y A] }
motion [held A: gripper, X: object] {
    at switch axis(A, z) = (0, 0, -1)
    HELD
}
rule pick(A: gripper, X: object) {
    pre (grippable X), not exists Z: object { (grasped A Z) }
    post (grasped A X), not (on ANY X), not [stable ANY X], not [rest X ANY], [held A X], [stable A X]
}
rule put(A: gripper, X Y: object) {
    pre (grasped A X), (tray Y)
    post not (grasped A X), not [stable A X], not [held A X], (on Y X), [stable Y X], [rest X Y]
}
task over() {
    base floor: box(3 m, 3 m, 4 cm) at (0, 0, -2 cm)
    object left: box(30 cm, 30 cm, 10 cm) at (45 cm, 30 cm, 5 cm)
    object right: box(30 cm, 30 cm, 10 cm) at (45 cm, -30 cm, 5 cm)
    object wall: box(40 cm, 2 cm, 30 cm) at (50 cm, 0, 15 cm)
    object brick: THING on left
    fact (grippable brick)
    fact (tray right)
    arm a: foot on floor
    goal (on right brick)
}
"""
LINKS = [  # name, height of its joint on the one before, axis, and its shape
    ("base", "0", "", '<origin xyz="0 0 0.1"/><geometry><cylinder radius="0.06" length="0.2"/></geometry>'),
    ("turn", "0.2", "0 0 1", '<origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.2"/></geometry>'),
    ("lift", "0.2", "0 1 0", '<origin xyz="0 0 0.18"/><geometry><box size="0.06 0.06 0.36"/></geometry>'),
    ("elbow", "0.38", "0 1 0", '<origin xyz="0 0 0.15"/><geometry><box size="0.05 0.05 0.28"/></geometry>'),
    ("w1", "0.32", "0 1 0", '<origin xyz="0 0 0.03"/><geometry><cylinder radius="0.02" length="0.06"/></geometry>'),
]
HAND = [  # the second prong is turned by a quarter
    '<origin xyz="0 0 0.03"/><geometry><box size="0.12 0.04 0.01"/></geometry>',
    '<origin xyz="0.055 0 0.065" rpy="0 1.5707963267948966 0"/><geometry><box size="0.06 0.04 0.01"/></geometry>',
    '<origin xyz="-0.055 0 0.065"/><geometry><box size="0.01 0.04 0.06"/></geometry>',
]


def program(
    tool: str = FORK.replace("APART", "5.5 cm"), arm: str = ARM, held: str = ASTRIDE, thing: str = BRICK
) -> str:
    return TASK.replace("ARM", arm).replace("TOOL", tool).replace("HELD", held).replace("THING", thing)


def urdf() -> str:
    found, below = ['<robot name="arm">'], ""
    for name, height, axis, shape in [*LINKS, ("hand", "0.06", "0 0 1", "")]:
        shapes = "".join(f"<collision>{s}</collision>" for s in ([shape] if shape else HAND))
        found.append(f'<link name="{name}">{shapes}</link>')
        if below:
            found.append(
                f'<joint name="{name}" type="revolute"><parent link="{below}"/><child link="{name}"/>'
                f'<origin xyz="0 0 {height}"/><axis xyz="{axis}"/>'
                '<limit lower="-2.9" upper="2.9" velocity="2" effort="100"/></joint>'
            )
        below = name
    return "\n".join([*found, "</robot>"])


def test_a_fork_carries_a_brick_over_a_wall(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, plan = tmp_path / "fork.tamp", tmp_path / "plan.json"
    source.write_text(program())
    assert cli.run(["solve", str(source), "--time", "60", "--out", str(plan)]) == 0, capsys.readouterr()
    saved = tamplang.read_plan(plan)
    assert saved.verify().verified and len(saved.actions) == 2
    for form, geoms in (("mjcf", ".//geom"), ("urdf", ".//collision")):
        assert cli.run(["export", str(plan), "--to", form, "--out", str(tmp_path / f"x.{form}")]) == 0
        found = ElementTree.parse(tmp_path / f"x.{form}").findall(geoms)
        sizes = [tuple(map(float, (g.get("size") or "0").split())) for g in found]
        sizes += [tuple(float(s) / 2 for s in b.get("size", "").split()) for g in found for b in g.iter("box")]
        assert sum(s == pytest.approx((0.005, 0.02, 0.03)) for s in sizes if len(s) == 3) == 2, form
    assert cli.run(["report", str(plan), "--out", str(tmp_path / "r.html")]) == 0


def test_prongs_that_are_too_near_to_each_other_are_refused(tmp_path: Path) -> None:
    """By the planner, and by the verifier in a plan that was made for a narrower brick."""
    near, narrow = FORK.replace("APART", "4.5 cm"), BRICK.replace("9 cm", "7 cm", 1)
    told = tamplang.loads(program(near)).solve(time=20.0)
    assert told.plan is None
    assert any("a.tool and brick would overlap by 5" in d.message for d in told.explanation), told.explanation
    made = tamplang.loads(program(near, thing=narrow)).solve(time=60.0)
    assert made.plan is not None and made.plan.verify().verified
    made.plan.save(tmp_path / "plan.json")
    data = json.loads((tmp_path / "plan.json").read_text().replace(narrow, BRICK))
    assert "parts" in data["needs"]
    next(b for b in data["bodies"] if b["name"] == "brick")["shape"]["size"][0] = 0.09
    for source in data["task"]["sources"]:
        source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()
    (tmp_path / "plan.json").write_text(json.dumps(data))
    failures = tamplang.read_plan(tmp_path / "plan.json").verify().failures
    assert [f for f in failures if f.between == ["a.tool", "brick"] and f.amount == pytest.approx(0.005, abs=2e-4)]


def test_a_hook_touches_a_basket_with_what_is_nearest(tmp_path: Path) -> None:
    result = tamplang.loads(program(HOOK, held="at switch gap(A, X) = 0", thing=BASKET)).solve(time=60.0)
    assert result.plan is not None and result.plan.verify().verified


def test_a_link_of_several_shapes_becomes_an_effector(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf())
    (tmp_path / "t.tamp").write_text(program(arm=FROM_URDF))
    problem, _ = compile_problem(tmp_path / "t.tamp")
    tool = problem.world.modules["a"].type.effector("tool")
    assert tool.shape is not None and tool.placement == pytest.approx((0.0, 0.0, 0.03, 0.0, 0.0, 0.0, 1.0))
    places = [(0.0, 0.0, 0.0), (0.055, 0.0, 0.035), (-0.055, 0.0, 0.035)]
    assert [part.at for part in tool.shape.parts] == [pytest.approx(at) for at in places]
    assert len(problem.world.modules["a"].type.links) == len(LINKS)
    result = tamplang.load(tmp_path / "t.tamp").solve(time=60.0)
    assert result.plan is not None and result.plan.verify().verified
