"""What is imported can be solved at once: a task that takes in the scene and states a goal is all that is added."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from .conftest import Command

MJCF = """<mujoco model="lab arm">
 <compiler angle="degree"/>
 <worldbody>
  <geom name="floor" type="plane" size="2 2 .1"/>
  <body name="base" pos="0 0 .1">
   <geom type="box" size=".1 .1 .1"/>
   <body name="upper" pos="0 0 .1">
    <joint name="yaw" axis="0 0 1" range="-170 170"/>
    <geom type="capsule" fromto="0 0 0 0 0 .4" size=".04"/>
    <body name="lower" pos="0 0 .4">
     <joint name="bend" axis="0 1 0" range="-120 120"/>
     <geom type="capsule" fromto="0 0 0 0 0 .4" size=".03"/>
     <body name="hand" pos="0 0 .4">
      <joint name="roll" axis="0 1 0" range="-120 120"/><geom type="sphere" size=".04"/>
     </body>
    </body>
   </body>
  </body>
  <body name="ball" pos=".4 .2 .4"><freejoint/><geom type="sphere" size=".04"/></body>
 </worldbody>
</mujoco>
"""
RAI = """world {}
table (world): { shape: ssBox, size: [1.5 1.5 .1 .01], X: "t(0 0 .6)", contact: 1 }
stand (table): { Q: "t(0 -.3 .1)", shape: cylinder, size: [.1 .05], contact: 1 }
l1 (stand): { joint: hingeZ, pre: "t(0 0 .05)", limits: [-2 2] }
b1 (l1): { shape: capsule, size: [.3 .03], Q: "t(0 0 .15)", contact: 1 }
l2 (l1): { joint: hingeX, pre: "t(0 0 .3)", limits: [-2 2] }
b2 (l2): { shape: capsule, size: [.3 .03], Q: "t(0 0 .15)", contact: 1 }
l3 (l2): { joint: hingeX, pre: "t(0 0 .3)", limits: [-2 2] }
b3 (l3): { shape: capsule, size: [.3 .03], Q: "t(0 0 .15)", contact: 1 }
ball (table): { Q: "t(.3 .1 .3)", shape: sphere, size: [.03], contact: 1, joint: rigid }
"""


@pytest.mark.parametrize(("name", "text"), [("arm.xml", MJCF), ("arm.g", RAI)])
def test_an_arm_takes_a_ball(command: Command, tmp_path: Path, name: str, text: str) -> None:
    if name.endswith(".xml"):
        pytest.importorskip("mujoco")
    (tmp_path / name).write_text(text)
    assert command("import", name, "-o", "arm.tamp").status == 0
    assert command("check", "arm.tamp").told.strip() == "1 file, 0 errors, 0 warnings"
    (tmp_path / "t.tamp").write_text('import "arm.tamp"\ntask take() {\n    scene arm()\n    goal (held ball)\n}\n')
    answer = command("solve", "t.tamp", "--quiet", "--json")
    found = json.loads(answer.told)
    assert found["status"] == "solved" and found["verified"], answer.told
