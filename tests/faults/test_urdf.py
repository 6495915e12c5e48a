"""URDFs as Pinocchio and RViz read them, and what no model needs, which is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from tamplang.compiler.ir import IDENTITY, ModuleType
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.poses import about, compose, joint_frames, orientation, roll_pitch_yaw

from .conftest import Faulty

PROGRAM = """import std.logic
predicate (lit)
rule light() { pre not (lit) post (lit) }
module robot from urdf "robot.urdf" { effector foot: gripper "base" sphere(1 cm) }
task t() { robot a: at (0, 0, 1 m) goal (lit) }
"""
BALL = '<collision><geometry><sphere radius="0.02"/></geometry></collision>'
JOINT = """<joint name="j" type="revolute"><parent link="base"/><child link="tool"/><origin xyz="0 0 0.1"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
ROBOT = f'<robot name="a"><link name="base"/><link name="tool">{BALL}</link>{JOINT}</robot>'
RING = "".join(
    f'<joint name="{a}{b}" type="fixed"><parent link="{a}"/><child link="{b}"/></joint>' for a, b in ("cd", "dc")
)
QUARTER = "0 0.7071067811865476 0 0.7071067811865476"

COLLADA = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 2 0 0 0 3</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
FLAT = """solid a
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid a
"""


def written(folder: Path, urdf: str | bytes) -> Path:
    (folder / "robot.urdf").write_bytes(urdf if isinstance(urdf, bytes) else urdf.encode())
    (folder / "program.tamp").write_text(PROGRAM)
    return folder / "program.tamp"


@pytest.mark.parametrize(
    "urdf",
    [
        ROBOT.replace("</robot>", '<gazebo><model><link name="loop"/><joint name="x"/></model></gazebo></robot>'),
        ROBOT.replace("</robot>", '<link_extra><link name="base"/></link_extra></robot>'),
        ROBOT.replace("</link>", '<extra><link name="base"/><collision/></extra></link>'),
        ROBOT.replace('velocity="1"', 'velocity="1" drake:acceleration="2"'),
        ROBOT.replace("</robot>", "<ros2:control><a:b c:d='e'/></ros2:control></robot>"),
        ROBOT.replace("<robot", '<robot xmlns="http://example.invalid/urdf"'),
        '<?xml version="1.0"?>' + ROBOT,
        '\n  <?xml version="1.0" encoding="utf-16"?>\n' + ROBOT,
        '<?xml version="1.0"?><!-- a -- b --->' + ROBOT,
        "<!-- <!DOCTYPE robot> -->" + ROBOT,
        "\ufeff" + ROBOT,
        ROBOT.replace("\n", "\r\n"),
        ('<?xml version="1.0" encoding="ISO-8859-1"?><!-- Größe -->' + ROBOT).encode("latin-1"),
        ROBOT.replace('name="a"', 'name="Größe"').encode("latin-1"),
        ROBOT.replace('name="j"', 'name="Gelenk über"'),
        ROBOT.encode("utf-16"),
        ROBOT.replace('"1" velocity="1"', '"inf" velocity="INF"').replace('name="a"', 'name="a" by="Q & A"'),
    ],
)
def test_what_others_read_is_read(faulty: Faulty, tmp_path: Path, urdf: str | bytes) -> None:
    process = faulty("check", written(tmp_path, urdf))
    assert (process.returncode, process.stdout) == (0, ""), process.stdout
    problem, _ = compile_problem(tmp_path / "program.tamp", None, {}, 0)
    (module,) = problem.world.modules.values()
    assert len(module.type.joints) == 1 and len(module.type.links) == 1


@pytest.mark.parametrize(
    ("urdf", "code", "word"),
    [
        ('<!DOCTYPE robot [<!ENTITY a "1">]>' + ROBOT, "E0513", "document type"),
        ("<!DOCTYPE robot>" + ROBOT, "E0513", "document type"),
        ('<!DOCTYPE robot SYSTEM "file:///etc/hostname">' + ROBOT, "E0513", "document type"),
        (ROBOT.replace("0.02", "&a;"), "E0513", "not XML"),
        (ROBOT.replace("</robot>", "<x>" * 50_000 + "</x>" * 50_000 + "</robot>"), "E0513", "nested too deeply"),
        (ROBOT.replace("</robot>", "<x>" * 50_000), "E0513", "nested too deeply"),
        ("", "E0513", "empty"),
        (b"\0" * 100, "E0513", "not a text"),
        (ROBOT[:-3], "E0513", "not XML"),
        (ROBOT.replace("0 0 0.1", "0 0 ٣ 1"), "E0514", "three numbers"),
        (ROBOT.replace("0 0 0.1", "0 0 nan"), "E0514", "three numbers"),
        (ROBOT.replace("0 0 0.1", "$(optenv AT 0 0 1)"), "E0514", "made by `xacro"),
        (ROBOT.replace('xyz="0 0 0.1"', 'rpy="0 0"'), "E0514", "rotation"),
        (ROBOT.replace("0.02", "-0.02"), "E0514", "size of -0.02"),
        (ROBOT.replace('name="a"', 'version="1.1"').replace("xyz=", 'quat_xyzw="0 0 0 0" xyz='), "E0514", "rotation"),
        (ROBOT.replace('name="a"', "version='1.1'").replace("<origin", "<origin quat_xyzw='0'"), "E0514", "rotation"),
        ("<sdf version='1.7'><model name='a'/></sdf>", "E0513", "this is SDF"),
        ("<mujoco model='a'/>", "E0513", "this is MJCF"),
        (ROBOT.replace("</robot>", "<xacro:arm prefix='${side}'/></robot>"), "E0513", "xacro FILE.xacro"),
        (ROBOT.replace('lower="-1" upper="1"', ""), "E0514", "write `joint j in -90 deg"),
        (ROBOT.replace('lower="-1"', 'lower="2"'), "E0514", "are empty: 2 .. 1"),
        (ROBOT.replace('xyz="0 1 0"', 'xyz="0 0 0"'), "E0514", "axis of joint `j` is zero"),
        (ROBOT.replace('"revolute"', '"hinge"'), "E0514", "of type `hinge`"),
        (ROBOT.replace('parent link="base"', 'parent link="bse"'), "E0514", "no parent link `bse`"),
        (ROBOT.replace('<link name="base"/>', '<link name="base"/><link name="base"/>'), "E0514", "two links"),
        (ROBOT.replace("</robot>", JOINT.replace('"j"', '"k"') + "</robot>"), "E0514", "hangs on two joints"),
        (ROBOT.replace("</robot>", '<link name="c"/><link name="d"/>' + RING + "</robot>"), "E0514", "hangs on itself"),
        (ROBOT.replace("</robot>", '<link name="spare"/></robot>'), "E0514", "2: `base`, `spare`"),
        (ROBOT.replace("<sphere", '<mesh filename="lost.stl"/><sphere'), "E0515", 'no mesh file "lost.stl"'),
    ],
)
def test_what_is_no_robot_is_refused(
    faulty: Faulty, tmp_path: Path, urdf: str | bytes, code: str, word: str
) -> None:  # fmt: skip
    process = faulty("check", written(tmp_path, urdf))
    assert process.returncode == 1 and f"error[{code}]" in process.stdout and word in process.stdout


@pytest.mark.parametrize(
    "shape", ['<box size="0 0 0"/>', '<box size="1 1 0"/>', '<sphere radius="0"/>', '<cylinder radius="0" length="1"/>']
)
def test_a_shape_without_volume_is_left_out(faulty: Faulty, tmp_path: Path, shape: str) -> None:
    program = written(tmp_path, ROBOT.replace('<sphere radius="0.02"/>', shape))
    process = faulty("check", program, "--format", "json")
    assert process.returncode == 0
    assert [d["code"] for d in json.loads(process.stdout)] == ["W0010"]
    problem, _ = compile_problem(program, None, {}, 0)
    assert problem.world.modules["a"].type.links == ()


@pytest.mark.parametrize(
    ("version", "counts"), [("1.1", True), ("1.2", True), ("1.0", False), ("", False), ("1", False), ("x", False)]
)
def test_quaternions_count_as_pinocchio_has_it(faulty: Faulty, tmp_path: Path, version: str, counts: bool) -> None:
    turned = ROBOT.replace('<origin xyz="0 0 0.1"', f'<origin xyz="0 0 0.1" quat_xyzw="{QUARTER}"')
    turned = turned.replace("<collision>", f'<collision><origin xyz="0 0 0.3" quat_xyzw="{QUARTER}"/>')
    program = written(tmp_path, turned.replace('name="a"', f'name="a" version="{version}"' if version else 'name="a"'))
    process = faulty("check", program)
    assert process.returncode == 0
    assert ("W0010" in process.stdout) != counts
    problem, _ = compile_problem(program, None, {}, 0)
    robot = problem.world.modules["a"].type
    expected = [float(n) for n in QUARTER.split()] if counts else [0.0, 0.0, 0.0, 1.0]
    assert robot.joints[0].placement[3:] == pytest.approx(expected)
    assert robot.links[0].placement[3:] == pytest.approx(expected)


def test_all_faults_of_a_file_are_told_at_once_where_they_are(faulty: Faulty, tmp_path: Path) -> None:
    wrong = ROBOT.replace("0.02", "nought").replace('lower="-1" upper="1" ', "").replace("</link>", "</link>\n")
    process = faulty("check", written(tmp_path, wrong), "--format", "json")
    found = [(d["code"], Path(d["file"]).name, d["line"]) for d in json.loads(process.stdout)]
    assert found == [("E0514", "robot.urdf", 1), ("E0514", "robot.urdf", 3)], process.stdout


def module_of(folder: Path, urdf: str, items: str = "") -> ModuleType:
    program = written(folder, urdf)
    program.write_text(PROGRAM.replace("sphere(1 cm) }", f"sphere(1 cm) {items} }}"))
    problem, _ = compile_problem(program, None, {}, 0)
    return problem.world.modules["a"].type


def test_the_module_says_what_the_file_leaves_open(tmp_path: Path) -> None:
    open_ended = ROBOT.replace('lower="-1" upper="1" ', "").replace('"j"', '"left hinge"')
    given = 'joint "left hinge" in -90 deg .. 30 deg home -1 rad speed 2 rad/s acceleration 3 rad/s^2'
    (joint,) = module_of(tmp_path, open_ended, given).joints
    assert (joint.lower, joint.upper, joint.home) == pytest.approx((-math.pi / 2, math.pi / 6, -1.0))
    assert (joint.speed, joint.acceleration) == (2.0, 3.0)
    narrowed = module_of(tmp_path, ROBOT, "joint j in -10 deg .. 10 deg").joints[0]
    assert (narrowed.lower, narrowed.upper, narrowed.speed) == pytest.approx((-math.pi / 18, math.pi / 18, 1.0))


@pytest.mark.parametrize(
    ("items", "code"),
    [
        ("joint k in 0 rad .. 1 rad", "E0117"),
        ("joint j in 1 rad .. 0 rad", "E0508"),
        ("joint j in 0 m .. 1 m", "E0203"),
        ("joint j home 2 rad", "E0508"),
        ("joint j: revolute(y) in 0 rad .. 1 rad", "E0508"),
    ],
)
def test_what_the_module_says_must_fit_the_file(faulty: Faulty, tmp_path: Path, items: str, code: str) -> None:
    program = written(tmp_path, ROBOT)
    program.write_text(PROGRAM.replace("sphere(1 cm) }", f"sphere(1 cm) {items} }}"))
    process = faulty("check", program, "--format", "concise")
    assert process.returncode == 1 and f" {code} " in process.stdout, process.stdout


def test_limits_without_a_way_fix_a_joint_where_they_are(faulty: Faulty, tmp_path: Path) -> None:
    urdf = ROBOT.replace('lower="-1" upper="1"', 'lower="0.5" upper="0.5"')
    module = module_of(tmp_path, urdf)
    assert module.joints == () and module.links[0].joint == -1
    assert module.links[0].placement == pytest.approx((0, 0, 0.1, 0, math.sin(0.25), 0, math.cos(0.25)))
    assert "W0010" in faulty("check", tmp_path / "program.tamp").stdout


@pytest.mark.parametrize("limits", ['lower="-inf" upper="inf"', 'lower="-1e16" upper="1e16"'])
@pytest.mark.parametrize(("kind", "least", "most"), [("revolute", 3.0, 7.0), ("prismatic", 1.0, 100.0)])
def test_limits_that_stand_for_none_leave_a_way_that_can_be_searched(
    tmp_path: Path, limits: str, kind: str, least: float, most: float
) -> None:
    urdf = ROBOT.replace("revolute", kind)
    (joint,) = module_of(tmp_path, urdf.replace('lower="-1" upper="1"', limits)).joints
    assert -most < joint.lower < -least and least < joint.upper < most and joint.home == 0.0
    (joint,) = module_of(tmp_path, urdf.replace('upper="1"', 'upper="1e16"').replace("-1", "200")).joints
    assert joint.lower == 200.0 and 200.0 + least < joint.upper < 200.0 + most
    _, warnings = compile_problem(tmp_path / "program.tamp", None, {}, 0)
    assert [w.code for w in warnings] == ["W0010"] and "200 .. 1e+16" in warnings[0].message


def test_planar_and_floating_joints_become_joints_of_the_module(tmp_path: Path) -> None:
    flat = module_of(tmp_path, ROBOT.replace("revolute", "planar"), "joint j in (-1 m, -2 m) .. (3 m, 4 m)")
    assert [(j.name, j.kind, j.lower, j.upper) for j in flat.joints][:2] == [
        ("j.x", "prismatic", -1.0, 3.0),
        ("j.y", "prismatic", -2.0, 4.0),
    ]
    tip = flat.links[0]
    middle = compose(joint_frames(flat, IDENTITY, [0.3, 0.2, 0.7])[tip.joint], tip.placement)
    assert middle[1] == pytest.approx(0.0), "it moves in the plane across its axis, y"
    assert math.hypot(middle[0], middle[2] - 0.1) == pytest.approx(math.hypot(0.3, 0.2))
    assert orientation(middle) == pytest.approx(about((0.0, 1.0, 0.0), 0.7))
    free = module_of(tmp_path, ROBOT.replace("revolute", "floating"))
    assert [j.name for j in free.joints] == [f"j.{n}" for n in ("x", "y", "z", "yaw", "pitch", "roll")]
    tip = free.links[0]
    moved = compose(joint_frames(free, IDENTITY, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])[tip.joint], tip.placement)
    assert moved == pytest.approx((0.1, 0.2, 0.4, *roll_pitch_yaw(0.6, 0.5, 0.4)))


def test_joints_that_turn_any_way_and_roots_that_are_only_named_are_taken_as_others_do(tmp_path: Path) -> None:
    ball = module_of(tmp_path, ROBOT.replace("revolute", "spherical"))
    assert [j.name for j in ball.joints] == ["j.yaw", "j.pitch", "j.roll"]
    moved = compose(joint_frames(ball, IDENTITY, [0.4, 0.5, 0.6])[ball.links[0].joint], ball.links[0].placement)
    assert moved == pytest.approx((0.0, 0.0, 0.1, *roll_pitch_yaw(0.6, 0.5, 0.4)))
    hung = '<joint name="k" type="fixed"><origin xyz="1 0 0"/><parent link="world"/><child link="base"/></joint>'
    robot = module_of(tmp_path, ROBOT.replace("</robot>", f"{hung}</robot>"))
    assert robot.effectors[0].placement[:3] == (1.0, 0.0, 0.0) and len(robot.joints) == 1
    _, (warning,) = compile_problem(tmp_path / "program.tamp", None, {}, 0)
    assert warning.code == "W0010" and "`world` is not declared" in warning.message
    robot = module_of(tmp_path, ROBOT.replace("0 0 0.1", "0, 0 0.1").replace("0 1 0", "0,1,0"))
    assert robot.joints[0].placement[:3] == (0.0, 0.0, 0.1) and robot.joints[0].axis == (0.0, 1.0, 0.0)
    _, (warning,) = compile_problem(tmp_path / "program.tamp", None, {}, 0)
    assert "commas in `xyz`" in warning.message


def test_capsules_count_from_version_1_1_on(faulty: Faulty, tmp_path: Path) -> None:
    old = ROBOT.replace('<sphere radius="0.02"/>', '<capsule radius="0.02" length="0.1"/>')
    assert module_of(tmp_path, old).links == ()
    assert "W0010" in faulty("check", tmp_path / "program.tamp").stdout
    (link,) = module_of(tmp_path, old.replace('name="a"', 'name="a" version="1.1"')).links
    assert link.shape.kind == "capsule" and link.shape.size == (0.02, 0.1)


def test_a_collada_mesh_has_its_own_unit_and_keeps_its_axes(faulty: Faulty, tmp_path: Path) -> None:
    (tmp_path / "part.dae").write_text(COLLADA)
    program = written(tmp_path, ROBOT.replace('<sphere radius="0.02"/>', '<mesh filename="part.dae" scale="2 2 2"/>'))
    problem, (warning,) = compile_problem(program, None, {}, 0)
    (link,) = problem.world.modules["a"].type.links
    corners = sorted(zip(*[iter(link.shape.size)] * 3, strict=True))
    sides = [max(c[k] for c in corners) - min(c[k] for c in corners) for k in range(3)]
    assert sides == pytest.approx([0.002, 0.004, 0.006])
    assert warning.code == "W0006" and "0.001 m" in warning.message and "Y_UP" in warning.message
    again, _ = compile_problem(program, None, {}, 0)
    assert again == problem, "what was remembered is what was read"


@pytest.mark.parametrize("mesh", ["solid a\nendsolid a\n", "\0" * 80, FLAT])
def test_a_mesh_without_a_body_is_left_out(faulty: Faulty, tmp_path: Path, mesh: str) -> None:
    (tmp_path / "part.stl").write_text(mesh)
    program = written(tmp_path, ROBOT.replace('<sphere radius="0.02"/>', '<mesh filename="part.stl"/>'))
    process = faulty("check", program)
    assert process.returncode == 0 and "W0010" in process.stdout and "left out" in process.stdout, process.stdout
