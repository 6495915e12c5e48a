"""A robot that the world holds may be sunk into what it stands on: what never moves may overlap."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from scipy.spatial import ConvexHull

from .conftest import Command, problems
from .test_meshes import parts_of_urdf

ARM = """<mujoco><worldbody>{}
<body name="arm" pos="{}"><geom name="b" {} pos="0 0 .03"/><body name="l1" pos="0 0 .25">
<joint name="j1" axis="0 0 1" range="-170 170"/><geom type="box" size=".1 .03 .03" pos=".05 0 0"/></body></body>
</worldbody></mujoco>"""
FLOOR = '<geom name="floor" type="plane" size="2 2 .1"/>'
TABLE = '<geom name="t" type="box" size=".5 .5 .2" pos="1 0 -.2" euler="0 0 30"/>'


@pytest.mark.parametrize(
    ("scene", "place", "shape", "left"),
    [
        (FLOOR, "0 0 0", 'type="cylinder" size=".08 .1"', 16 * math.tan(math.pi / 16) * 0.08**2 * 0.13),
        (TABLE, "1 0 0", 'type="box" size=".1 .1 .1" euler="0 0 20"', 0.2 * 0.2 * 0.13),
        (FLOOR, "0 0 0", 'type="box" size=".1 .1 .1" euler="0 90 0"', 0.2 * 0.2 * 0.13),
    ],
)
def test_what_is_within_the_floor_is_cut_off(
    command: Command, scene: str, place: str, shape: str, left: float
) -> None:
    Path("m.xml").write_text(ARM.format(scene, place, shape))
    answer = command("import", "m.xml", "-o", "o.tamp")
    assert answer.status == 0 and "is sunk 70 mm into" in answer.told and "[W0019]" in answer.told
    assert problems(command, "o.tamp") == []
    root = Path("o_arm.urdf").read_text().partition("</link>")[0]
    Path("root.urdf").write_text(root + "</link></robot>")
    (part,) = parts_of_urdf("root.urdf")
    assert ConvexHull(part).volume == pytest.approx(left, rel=1e-6)
    assert sorted({round(z, 9) for z in part[:, 2]})[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("scene", "place"), [(TABLE, "1.45 0 0"), (FLOOR, "0 0 .07")])
def test_what_stands_beside_it_is_kept(command: Command, scene: str, place: str) -> None:
    Path("m.xml").write_text(ARM.format(scene, place, 'type="box" size=".1 .1 .1"'))
    answer = command("import", "m.xml", "-o", "o.tamp")
    assert answer.status == 0 and "sunk" not in answer.told
    assert 'size="0.2 0.2 0.2"' in Path("o_arm.urdf").read_text()
