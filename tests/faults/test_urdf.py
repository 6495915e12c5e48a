"""URDFs as Pinocchio and RViz read them, and what no model needs, which is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem

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
QUARTER = "0 0.7071067811865476 0 0.7071067811865476"


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
        (ROBOT.replace('xyz="0 0 0.1"', 'rpy="0 0"'), "E0514", "rotation"),
        (ROBOT.replace("0.02", "-0.02"), "E0514", "size of -0.02"),
        (ROBOT.replace('name="a"', 'version="1.1"').replace("xyz=", 'quat_xyzw="0 0 0 0" xyz='), "E0514", "rotation"),
        (ROBOT.replace('name="a"', "version='1.1'").replace("<origin", "<origin quat_xyzw='0'"), "E0514", "rotation"),
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
