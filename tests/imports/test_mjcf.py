"""MuJoCo's models become modules that move as MuJoCo moves them; what has no counterpart is told with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.importing.reading import import_files
from tamplang.compiler.poses import Pose, compose, inverse, make

from .conftest import Command, problems, refused
from .kinematics import apart, poses, spread

mujoco = pytest.importorskip("mujoco")
MODEL = """<mujoco model="t">
 <compiler angle="degree" eulerseq="xyz"/>
 <default><joint range="-90 90"/><geom condim="4"/></default>
 <asset><mesh name="tet" vertex="0 0 0  .1 0 0  0 .1 0  0 0 .1"/><material name="red"/></asset>
 <worldbody>
  <light pos="0 0 3"/>
  <geom name="floor" type="plane" size="0 0 1" material="red"/>
  <geom type="box" size=".1 .1 .1" pos="1 1 .1" euler="0 30 0"/>
  <include file="arm.xml"/>
  <body name="cube" pos="1 0 .1"><freejoint/><geom type="box" size=".05 .05 .05"/></body>
 </worldbody>
 <actuator><motor joint="j1" gear="2" forcerange="-3 5" forcelimited="true"/></actuator>
 <equality><joint joint1="f2" joint2="f1" polycoef="0 -1 0 0 0"/><weld body1="cube" body2="hand"/></equality>
 <keyframe><key qpos="1"/></keyframe>
</mujoco>
"""
ARM = """<mujocoinclude>
<body name="arm" pos="0.3 0.2 0.5" euler="10 20 30">
 <geom type="cylinder" size=".05 .1"/>
 <body name="l1" pos="0 0 .1" quat="1 .2 .3 .4">
  <joint name="j1" axis="1 1 0" pos="0.01 0.02 0.03" ref="20"/>
  <joint name="j1b" type="slide" axis="0 1 0" range="-.2 .3"/>
  <geom type="capsule" fromto="0 0 0 .2 0 .1" size=".03"/>
  <body name="fork" pos=".2 0 .1"><joint name="bb" type="ball" pos="0 0 .1" range="0 90"/>
    <geom type="mesh" mesh="tet"/> <geom type="ellipsoid" size=".1 .05 .02"/>
    <body name="hand" pos="0 0 .1"><joint name="f1" axis="0 0 1"/><geom size=".02"/></body>
    <body name="hand2" pos="0 0 .2"><joint name="f2" axis="0 0 1"/><geom size=".02"/></body>
  </body>
 </body>
</body>
</mujocoinclude>
"""


def test_a_model_moves_as_in_mujoco(command: Command) -> None:
    Path("arm.xml").write_text(ARM)
    Path("m.xml").write_text(MODEL)
    answer = command("import", "m.xml", "-o", "task.tamp")
    assert answer.status == 0, answer.told
    for word in ("ball", "ellipsoid", "weld", "arm.xml:8:", "m.xml:13:"):
        assert word in answer.told
    assert problems(command, "task.tamp") == []
    assert command("fmt", "--check", "task.tamp").status == 0
    program = Path("task.tamp").read_text()
    assert "object cube: box(0.1 m, 0.1 m, 0.1 m)" in program
    arm = Path("task_arm.urdf").read_text()
    assert 'effort="10.0"' in arm and '<mimic joint="f1" multiplier="-1.0" offset="0.0"/>' in arm
    model = mujoco.MjModel.from_xml_path("m.xml")
    data = mujoco.MjData(model)
    for values in spread(["j1", "j1b", "bb.yaw", "bb.pitch", "bb.roll", "f1", "f2"], 4):
        for name in ("j1", "j1b", "f1", "f2"):
            data.joint(name).qpos[0] = values[name]
        turn = make((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        for axis, name in zip("zyx", ("yaw", "pitch", "roll"), strict=True):
            turn = compose(turn, apart(axis, values[f"bb.{name}"]))
        data.joint("bb").qpos[:] = [turn[6], *turn[3:6]]
        mujoco.mj_kinematics(model, data)
        found = poses(arm, values)
        for name in ("l1", "fork", "hand", "hand2"):
            same(compose(inverse(found["arm"]), found[name]), compose(inverse(world(data, "arm")), world(data, name)))


def world(data: mujoco.MjData, name: str) -> Pose:
    w, x, y, z = data.body(name).xquat.tolist()
    return (*data.body(name).xpos.tolist(), x, y, z, w)


def same(one: Pose, other: Pose) -> None:
    sign = 1 if sum(a * b for a, b in zip(one[3:], other[3:], strict=True)) > 0 else -1
    assert one[:3] == pytest.approx(other[:3], abs=1e-9)
    assert one[3:] == pytest.approx([sign * v for v in other[3:]], abs=1e-9)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("<mujoco>", "E0019"), ("<mujoco><worldbody><body/></worldbody></mujoco", "E0019"),
        ("<mujocoinclude/>", "E0019"), ("<mujoco/>", "E0020"), ("<mujoco><worldbody/></mujoco>", "E0020"),
        ('<mujoco><include file="/etc/passwd"/></mujoco>', "E0022"),
        ('<mujoco><include file="m.xml"/></mujoco>', "E0022"),
        ('<mujoco><include file="none.xml"/></mujoco>', "E0022"), ('<mujoco><include/></mujoco>', "E0022"),
        ('<mujoco><asset><mesh file="/etc/passwd"/></asset></mujoco>', "E0022"),
        ('<mujoco><asset><mesh file="none.stl"/></asset></mujoco>', "E0022"),
        ('<mujoco><asset><mesh file="bad.stl"/></asset><worldbody><geom mesh="bad"/></worldbody></mujoco>', "E0019"),
        ('<!DOCTYPE a [<!ENTITY b "c">]><mujoco/>', "E0019"), ("<mujoco>" + "<body>" * 200, "E0019"),
        ('<mujoco><worldbody><geom size="-1"/></worldbody></mujoco>', "E0019"),
        ('<mujoco><worldbody><geom type="tube" size="1"/></worldbody></mujoco>', "E0019"),
        ('<mujoco><worldbody><geom type="mesh" mesh="no"/></worldbody></mujoco>', "E0019"),
        ('<mujoco><worldbody><body name="a"/><body name="a"/></worldbody></mujoco>', "E0019"),
        ('<mujoco><worldbody><body><joint/></body></worldbody></mujoco>', "E0019"),
        ('<mujoco><worldbody><body pos="nan 0 0"><joint/><geom size="1"/></body></worldbody></mujoco>', "E0019"),
        ('<mujoco><worldbody><joint/><geom size="1"/></worldbody></mujoco>', "E0019"),
        ('<mujoco><compiler nonsense="1"/><worldbody><geom size="1"/></worldbody></mujoco>', "E0019"),
        ('<mujoco><worldbody><replicate count="999999999"><geom size="1"/></replicate></worldbody></mujoco>', "E0022"),
    ],
)  # fmt: skip
def test_bad_models_are_refused_with_their_place(command: Command, text: str, code: str) -> None:
    Path("m.mjcf").write_text(text)
    Path("m.xml").write_text(text)
    Path("bad.stl").write_bytes(b"not a mesh at all")
    told = refused(command, {code}, "m.mjcf" if "m.xml" not in text else "m.xml")
    assert code == "E0020" or "--> " in told or "[E0021]" in told, told


def test_a_thousand_lines(command: Command) -> None:
    bodies = "".join(f'<body name="b{k}" pos="{k} 0 0"><joint/>\n<geom size=".1"/></body>\n' for k in range(400))
    Path("m.xml").write_text(f"<mujoco>\n<worldbody>\n{bodies}</worldbody></mujoco>")
    assert len(import_files(["m.xml"]).beside) == 400
