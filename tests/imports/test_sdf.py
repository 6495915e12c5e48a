"""Models of SDF become modules whose links are where the file puts them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

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
