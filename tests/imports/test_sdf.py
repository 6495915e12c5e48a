"""Models of SDF become modules whose links are where the file puts them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tamplang.compiler.poses import about, compose, inverse, make

from .conftest import Command, problems, refused
from .kinematics import poses

WORLD = """<?xml version="1.0"?>
<sdf version="1.9"><world name="w">
<light name="sun"/>
<model name="ground"><static>true</static><link name="l"><collision name="c"><geometry><plane/></geometry></collision>
</link></model>
<model name="arm"><pose>1 2 0.5 0 0 0.5</pose>
 <link name="base"><pose>0 0 .1 0 0 0</pose>
  <collision name="c"><geometry><box><size>.1 .1 .2</size></box></geometry></collision>
  <inertial><mass>2</mass><pose>0 0 .1 0 0 0</pose></inertial></link>
 <frame name="f" attached_to="base"><pose degrees="true">0 0 .3 10 20 30</pose></frame>
 <link name="l1"><pose relative_to="f">.1 0 0 0 0 1</pose></link>
 <joint name="j1" type="revolute"><pose>0 .05 0 0 .3 0</pose><parent>base</parent><child>l1</child>
  <axis><xyz expressed_in="f">1 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
 <model name="hand"><pose relative_to="l1">0 0 .2 0 0 0</pose><link name="palm"/>
  <link name="finger"><pose>0 0 .1 0 0 0</pose></link>
  <joint name="fj" type="prismatic"><parent>palm</parent><child>finger</child><axis><xyz>0 1 0</xyz></axis></joint>
 </model>
 <joint name="weld" type="fixed"><parent>l1</parent><child>hand::palm</child></joint>
</model>
<model name="ball"><pose>0 0 1 0 0 0</pose><link name="l">
 <collision name="c"><geometry><sphere><radius>.05</radius></sphere></geometry></collision></link></model>
</world></sdf>
"""


def frame(x: float, y: float, z: float, roll: float = 0, pitch: float = 0, yaw: float = 0) -> np.ndarray:
    def turn(i: int, j: int, angle: float) -> np.ndarray:
        m = np.eye(4)
        m[i, i] = m[j, j] = math.cos(angle)
        m[i, j], m[j, i] = -math.sin(angle), math.sin(angle)
        return m

    moved = np.eye(4)
    moved[:3, 3] = x, y, z
    return moved @ turn(0, 1, yaw) @ turn(2, 0, pitch) @ turn(1, 2, roll)


def test_a_world_is_where_the_file_puts_it(command: Command) -> None:
    Path("w.sdf").write_text(WORLD)
    answer = command("import", "w.sdf", "-o", "w.tamp")
    assert answer.status == 0 and "w.sdf:4:" in answer.told and "hand::fj" in answer.told
    assert problems(command, "w.tamp") == []
    assert "object ball: sphere(0.05 m) at (0 m, 0 m, 1 m)" in Path("w.tamp").read_text()
    base, held = frame(0, 0, 0.1), frame(0, 0, 0.1) @ frame(0, 0, 0.3, *map(math.radians, (10, 20, 30)))
    first = held @ frame(0.1, 0, 0, 0, 0, 1)
    joint = first @ frame(0, 0.05, 0, 0, 0.3, 0)
    axis = held[:3, :3] @ [math.sqrt(0.5), math.sqrt(0.5), 0]
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(4)
    turn[:3, :3] += math.sin(0.7) * cross + (1 - math.cos(0.7)) * cross @ cross
    away = np.eye(4)
    away[:3, 3] = joint[:3, 3]
    turned = away @ turn @ np.linalg.inv(away) @ first
    finger = turned @ frame(0, 0, 0.2) @ frame(0, 0.3, 0.1)
    found = poses(Path("w_arm.urdf").read_text(), {"j1": 0.7, "hand::fj": 0.3})
    for name, wanted in (("l1", turned), ("hand::finger", finger)):
        assert found[name][:3] == pytest.approx((np.linalg.inv(base) @ wanted)[:3, 3], abs=1e-9)


def test_included_models_are_put_in_with_what_is_said_of_them(command: Command) -> None:
    """From the folders above, by name, also through others; a mesh lies beside the file that names it."""
    cube = [(x, y, z) for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)]
    for path, text in {
        "models/arm/model.config": "<model><sdf version='1.4'>old.sdf</sdf><sdf version='1.10'>new.sdf</sdf></model>",
        "models/arm/new.sdf": """<sdf version="1.9"><model name="arm"><pose>9 9 9 0 0 0</pose><link name="a"/>
<include><uri>model://tip</uri><name>hand</name><pose>0 0 .5 0 0 .2</pose></include>
<joint name="j" type="revolute"><parent>a</parent><child>hand::j</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></sdf>""",
        "models/tip/model.sdf": """<sdf version="1.6"><model name="tip"><link name="j"><collision name="c"><geometry>
<mesh><uri>cube.obj</uri></mesh></geometry></collision></link><link name="k"><pose>0 0 .1 0 0 0</pose></link>
<joint name="k" type="prismatic"><parent>j</parent><child>k</child><axis><xyz>0 1 0</xyz></axis></joint>
</model></sdf>""",
        "models/tip/cube.obj": "".join(f"v {x} {y} {z}\n" for x, y, z in cube)
        + "".join(f"f {a} {b} {c}\n" for a, b, c in (
            (1, 2, 4), (1, 4, 3), (5, 8, 6), (5, 7, 8), (1, 6, 2), (1, 5, 6), (3, 4, 8), (3, 8, 7), (1, 3, 7),
            (1, 7, 5), (2, 6, 8), (2, 8, 4))),
        "models/worlds/w.sdf": """<sdf version="1.9"><world name="w"><include><uri>model://arm</uri><name>left</name>
<pose>1 2 3 0 0 0</pose></include>
<include><uri>model://arm</uri><name>right</name><pose>1 -2 3 0 0 0</pose></include>
<include><uri>model://lost</uri></include></world></sdf>""",
    }.items():  # fmt: skip
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_text(text)
    answer = command("import", "models/worlds/w.sdf", "-o", "w.tamp")
    assert answer.status == 0 and "`include` of `model://lost` is left out: no folder above" in answer.told
    assert "joint `hand::k` is called as another part is, and becomes `hand::k_joint`" in answer.told
    assert problems(command, "w.tamp") == []
    program = Path("w.tamp").read_text()
    assert "(1 m, 2 m, 3 m)" in program and "(1 m, -2 m, 3 m)" in program
    robot = Path("w_right.urdf").read_text()
    assert robot.count("<convex") == 1
    found = poses(robot, {"j": 0.4, "hand::k_joint": 0.3})
    wanted = frame(0, 0, 0.5, 0, 0, 0.6) @ frame(0, 0.3, 0.1)
    assert found["hand::k"][:3] == pytest.approx(wanted[:3, 3], abs=1e-9)


@pytest.mark.parametrize(("version", "axis"), [("1.4", (0, 1)), ("1.5", (-1, 0))])
def test_axes_of_old_files_are_those_of_the_model(command: Command, version: str, axis: tuple[float, float]) -> None:
    inner = MOVING.replace("0 0 1", "0 1 0").replace('"b"/>', '"b"><pose>1 0 0 0 0 1.5707963267948966</pose></link>')
    Path("m.sdf").write_text(f"<sdf version='{version}'><model name='m'>{inner}</model></sdf>")
    assert command("import", "m.sdf", "-o", "o.tamp").status == 0
    quaternion = poses(Path("o_m.urdf").read_text(), {"j": 0.6})["b"][3:]
    turned = compose(make((0, 0, 0), quaternion), inverse(make((0, 0, 0), about((0, 0, 1), math.pi / 2))))
    assert turned[3:5] == pytest.approx([math.sin(0.3) * a for a in axis], abs=1e-9)


def test_joints_may_name_frames_and_models_for_their_links(command: Command) -> None:
    inner = MOVING.replace("<parent>a", "<parent>f").replace("<child>b", "<child>m::g")
    nested = '<model name="m"><pose>1 0 0 0 0 0</pose><link name="b"/><frame name="g"/></model>'
    held = '<frame name="f" attached_to="a"><pose>0 0 9 0 0 0</pose></frame>'
    inner = inner.replace('<link name="b"/>', held + nested)
    Path("m.sdf").write_text(f"<sdf version='1.9'><model name='r'>{inner}</model></sdf>")
    answer = command("import", "m.sdf", "-o", "o.tamp")
    assert answer.status == 0, answer.told
    assert poses(Path("o_r.urdf").read_text(), {"j": 0.6})["m::b"][:3] == pytest.approx((1, 0, 0), abs=1e-9)


def test_models_that_include_each_other_are_left_out(command: Command) -> None:
    """A file that takes in itself ends; so does one of few lines that takes in more than a memory holds."""
    two = "<include><uri>{0}.sdf</uri><name>x</name></include><include><uri>{0}.sdf</uri><name>y</name></include>"
    ball = '<collision name="c"><geometry><sphere><radius>1</radius></sphere></geometry></collision>'
    for k in range(20):
        inner = two.format(f"m{k + 1}") if k < 19 else two.format("m0")
        model = f'<model name="m"><link name="l">{ball}</link>{inner}</model>'
        Path(f"m{k}.sdf").write_text(f'<sdf version="1.9">{model}</sdf>')
    answer = command("import", "m0.sdf", "-o", "o.tamp")
    assert answer.status == 0 and "8 inside each other" in answer.told
    assert 2 <= Path("o.tamp").read_text().count("sphere") <= 1000


LINKS = '<link name="a"/><link name="b"/>'
JOINT = '<joint name="j" type="revolute"><parent>a</parent><child>b</child>{}</joint>'
MOVING = LINKS + JOINT.format("<axis><xyz>0 0 1</xyz></axis>")


@pytest.mark.parametrize(
    ("inner", "code"),
    [
        ("<model", "E0019"), ("", "E0020"), ("<model name='m'/>", "E0020"),
        ("<include><uri>x</uri></include>", "E0020"),
        (f"<model name='m'>{LINKS}{LINKS}</model>", "E0022"), ("<model name='m'><link/></model>", "E0022"),
        (f"<model name='m'>{LINKS}{JOINT.format('<axis><xyz>0 0 0</xyz></axis>')}</model>", "E0022"),
        (f"<model name='m'>{LINKS}{JOINT.format('<axis><xyz>0 x 0</xyz></axis>')}</model>", "E0019"),
        (f"<model name='m'>{LINKS}{JOINT.format('<axis><xyz>0 nan 1</xyz></axis>')}</model>", "E0019"),
        (f"<model name='m'>{MOVING.replace('<child>b', '<child>c')}</model>", "E0022"),
        (f"<model name='m'>{MOVING.replace('<child>b', '<child>a')}</model>", "E0022"),
        (f"<model name='m'>{MOVING}<link name='c'><pose relative_to='no'>0 0 0 0 0 0</pose></link></model>", "E0022"),
        (f"<model name='m'>{MOVING}<frame name='f' attached_to='f'/></model>", "E0022"),
        (f"<model name='m'>{MOVING}<frame name='f' attached_to='g'/><frame name='g' attached_to='f'/></model>",
         "E0022"),
        (f"<model name='m'><pose>1 2</pose>{MOVING}</model>", "E0019"),
        (f"<model name='m'><pose>1 2 inf 0 0 0</pose>{MOVING}</model>", "E0019"),
        (f"<model name='m'><pose>1e300 2 0 0 0 0</pose>{MOVING}</model>", "E0022"),
        (f"<model name='m'><pose rotation_format='quat_xyzw'>1 2 0 0 0 0 0</pose>{MOVING}</model>", "E0022"),
        (f"<model name='m'>{LINKS}" + JOINT.format(
            "<axis><xyz>0 0 1</xyz><limit><lower>2</lower><upper>1</upper></limit></axis>") + "</model>", "E0022"),
        (f"<model name='m'>{LINKS}" + JOINT.format(
            "<axis><xyz expressed_in='x'>0 0 1</xyz></axis>") + "</model>", "E0022"),
        ("<a>" * 150, "E0019"),
    ],
)  # fmt: skip
def test_bad_files_are_refused(command: Command, inner: str, code: str) -> None:
    Path("m.sdf").write_text(f"<sdf version='1.9'>{inner}</sdf>")
    told = refused(command, {code}, "m.sdf")
    assert code == "E0020" or "1e+300" in told or "--> m.sdf:1:" in told
