"""Modules with planar joints, branches and more than two effectors, and modules taken from URDF texts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tamplang.compiler import ir
from tamplang.compiler.extents import box_sides
from tamplang.compiler.module_parts import own_pairs
from tamplang.compiler.pipeline import check, compile_problem, compile_sources, compile_text
from tamplang.compiler.poses import effector_pose, position

PROGRAMS = Path(__file__).parents[1] / "programs"

WAGON = """
import std.logic
predicate (lit)
rule light() { pre not (lit) post (lit) }
module wagon(side: length = 50 cm) {
    joint drive: planar(x, y) in (-5 m, -4 m) .. (5 m, 4 m) home (1 m, 0 m) speed 0.8 m/s
    link 6 cm: box(side, side)
    effector hook: gripper sphere(2 cm) at (side / 2, 0, -3 cm) normal (1, 0, 0)
    branch {
        link (side / 2, side / 2, 0)
        joint lift: prismatic(z) in 0 m .. 10 cm
        link 10 cm: cylinder(2 cm)
        effector left: gripper sphere(4 cm)
        branch {
            joint tilt: revolute(y) in -1 rad .. 1 rad
            link 20 cm
            effector tip: gripper sphere(4 cm)
        }
    }
    link 20 cm: cylinder(2 cm)
    effector top: gripper sphere(4 cm)
}
task haul() {
    base floor: box(4 m, 4 m, 5 cm) at (0, 0, 0)
    wagon w: at (0, 0, 30 cm)
    goal (lit)
}
"""


def test_planar_joint_and_branches() -> None:
    problem, _ = compile_text(WAGON)
    module = problem.world.modules["w"].type
    assert [(j.name, j.kind, j.parent) for j in module.joints] == [
        ("drive.x", "prismatic", -1),
        ("drive.y", "prismatic", 0),
        ("drive.turn", "revolute", 1),
        ("lift", "prismatic", 2),
        ("tilt", "revolute", 3),
    ]
    assert [(j.lower, j.upper, j.home, j.speed) for j in module.joints[:2]] == [(-5, 5, 1, 0.8), (-4, 4, 0, 0.8)]
    assert [(e.name, e.joint) for e in module.effectors] == [("hook", 2), ("left", 3), ("tip", 4), ("top", 2)]
    quarter = math.pi / 2
    values = [1.0, 2.0, quarter, 0.05, quarter / 2]
    tip = position(effector_pose(module, "tip", values))
    assert tip == pytest.approx((1 - 0.25, 2 + 0.25 + 0.2 * math.sin(quarter / 2), 0.21 + 0.2 * math.cos(quarter / 2)))
    assert position(effector_pose(module, "top", values)) == pytest.approx((1, 2, 0.26))
    assert position(effector_pose(module, "hook", values)) == pytest.approx((1, 2.25, 0.03))


def test_module_from_urdf(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(PROGRAMS / "good")
    problem, warnings = compile_problem("arm_from_urdf.tamp")
    module = problem.world.modules["a"].type
    assert warnings == ()
    assert [(j.name, j.kind, j.parent, j.home) for j in module.joints] == [
        ("waist", "revolute", -1, 0.0),
        ("elbow", "revolute", 0, 0.0),
        ("reach", "prismatic", 1, 0.15),
    ]
    assert [link.shape.kind for link in module.links] == ["cylinder", "capsule", "box"]
    assert module.effector("tool").shape == ir.Shape("sphere", (0.03,))
    turn, reach = 0.5 + 0.4, 0.3 + 0.2 + 0.1
    tool = position(effector_pose(module, "tool", [0.0, 0.4, 0.2]))
    assert tool == pytest.approx((reach * math.sin(turn), 0, 0.52 + reach * math.cos(turn)))


def test_problem_from_urdf_compiles_again_without_the_disk(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(PROGRAMS / "good")
    problem, _ = compile_problem("arm_from_urdf.tamp")
    monkeypatch.chdir(tmp_path)
    again, _ = compile_sources(problem.sources, files=problem.files)
    assert again == problem


def _write_stl(path: Path, corners: np.ndarray) -> None:
    lines = ["solid wedge"]
    for a, b, c in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        lines += ["facet normal 0 0 1", "outer loop"]
        lines += ["vertex " + " ".join(map(str, corners[i])) for i in (a, b, c)]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid wedge"]))


def test_urdf_gives_speeds_and_accelerations_or_leaves_them_to_the_defaults() -> None:
    problem, _ = compile_problem(PROGRAMS / "good" / "arm_from_urdf.tamp")
    rates = {j.kind: (j.speed, j.acceleration) for j in problem.world.modules["a"].type.joints if j.name != "j1"}
    assert (1.5, 3.0) in [(j.speed, j.acceleration) for j in problem.world.modules["a"].type.joints]
    assert rates["prismatic"] == (0.2, 1.0)


def test_mesh_becomes_its_hull(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "meshes").mkdir()
    _write_stl(tmp_path / "meshes" / "wedge.stl", np.array([[0, 0, 0], [2, 0, 0], [0, 4, 0], [0, 0, 6.0]]))
    Path("arm.urdf").write_text("""<robot name="arm"><link name="base"><collision>
        <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/>
        <geometry><mesh filename="package://arm/meshes/wedge.stl" scale="0.1 0.1 0.1"/></geometry>
        </collision></link></robot>""")
    Path("task.tamp").write_text("""module arm from urdf "arm.urdf" { effector A: "base" sphere(1 cm) }
        predicate (lit)
        rule light() { pre not (lit) post (lit) }
        task t() { arm a: at (0, 0, 0) goal (lit) }""")
    problem, warnings = compile_problem("task.tamp")
    told = 'the mesh "package://arm/meshes/wedge.stl" is replaced by its hull'
    taken = "no folder of the name of its package holds it, so meshes/wedge.stl is taken"
    assert [(w.code, w.message) for w in warnings] == [("W0006", f"{told}; {taken}")]
    assert warnings[0].span is not None and warnings[0].span.file == "arm.urdf"
    (link,) = problem.world.modules["a"].type.links
    assert link.shape.kind == "convex" and box_sides(link.shape) == pytest.approx((0.2, 0.4, 0.6))
    assert len(link.shape.size) == 3 * 4
    assert position(link.placement) == pytest.approx((1 - 0.2, 0.1, 0.3))
    assert check("task.tamp") == warnings
    Path("arm.urdf").unlink()
    (tmp_path / "meshes" / "wedge.stl").unlink()
    assert compile_sources(problem.sources, files=problem.files) == (problem, warnings)


def test_a_mesh_is_found_in_the_folders_of_its_model_where_one_alone_is_called_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "urdf").mkdir()
    for folder in ("meshes/seven/hit", "meshes/seven/seen"):
        (tmp_path / folder).mkdir(parents=True)
        _write_stl(tmp_path / folder / "wedge.stl", np.array([[0, 0, 0], [2, 0, 0], [0, 4, 0], [0, 0, 6.0]]))
    Path("urdf/arm.urdf").write_text("""<robot name="arm"><link name="base"><collision><geometry>
        <mesh filename="package://hit/wedge.stl"/></geometry></collision></link></robot>""")
    Path("task.tamp").write_text("""module arm from urdf "urdf/arm.urdf" { effector A: "base" sphere(1 cm) }
        predicate (lit)
        rule light() { pre not (lit) post (lit) }
        task t() { arm a: at (0, 0, 0) goal (lit) }""")
    problem, warnings = compile_problem("task.tamp")
    assert "holds it, so meshes/seven/hit/wedge.stl is taken" in warnings[0].message
    assert len(problem.world.modules["a"].type.links) == 1
    assert compile_sources(problem.sources, files=problem.files) == (problem, warnings), "without the disk, too"
    (tmp_path / "other" / "hit").mkdir(parents=True)
    (tmp_path / "other" / "hit" / "wedge.stl").write_text("solid a\nendsolid a\n")
    (wrong,) = [w for w in check("task.tamp") if w.is_error]
    assert wrong.code == "E0515" and "several are called so: meshes/seven/hit/wedge.stl, other" in wrong.message


def test_what_is_remembered_of_meshes_is_what_is_found(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    _write_stl(tmp_path / "wedge.stl", np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]))
    mesh = '<collision><geometry><mesh filename="wedge.stl"/></geometry></collision>'
    links = "".join(f'<link name="{name}">{mesh}</link>' for name in "abc")
    joint = """<joint name="j{0}" type="revolute"><parent link="{0}"/><child link="{1}"/><origin xyz="0.3 0 0"/>
        <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
    Path("arm.urdf").write_text(f"<robot name='arm'>{links}{joint.format(*'ab')}{joint.format(*'bc')}</robot>")
    Path("task.tamp").write_text("""module arm from urdf "arm.urdf" { effector A: "a" sphere(1 cm) }
        predicate (lit)
        rule light() { pre not (lit) post (lit) }
        task t() { arm a: at (0, 0, 0) goal (lit) }""")
    own_pairs.cache_clear()
    type_ = compile_problem("task.tamp")[0].world.modules["a"].type
    found = own_pairs(type_)
    assert len(found) == 2 and found[0][2] > 0.2
    kept = {file: file.read_bytes() for file in (tmp_path / "cache" / "tamplang").glob("*.json")}
    assert {file.name.partition("-")[0] for file in kept} == {"mesh", "pairs"}
    for damage in (bytes, lambda b: b[:-9], lambda b: b.replace(b"0.", b"9."), lambda b: b""):
        for file, content in kept.items():
            file.write_bytes(damage(content))
        own_pairs.cache_clear()
        again = compile_problem("task.tamp")[0].world.modules["a"].type
        assert again == type_ and own_pairs(again) == found
        assert {file: file.read_bytes() for file in kept} == kept, "what was spoilt is made anew"
