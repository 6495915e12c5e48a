"""What parts weigh, what joints bear, and how ends hold, as users state it."""

import math
from pathlib import Path

import numpy as np
import pytest

from tamplang.compiler.ir import ModuleType
from tamplang.compiler.physics.frames import poses
from tamplang.compiler.physics.masses import module_mass
from tamplang.compiler.physics.records import weaker
from tamplang.compiler.physics.start_loads import plainly_borne
from tamplang.compiler.physics.statics import loads
from tamplang.compiler.pipeline import check, compile_problem, compile_text
from tamplang.langs.formatter import format_source
from tamplang.langs.source import Source

EXAMPLES = Path(__file__).parents[2] / "examples"
TEXT = """import std.rules

module arm(drive: torque = 38 N m, part: mass = 2 kg) {
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 350 g
        holds pad(force 1 kN, moment 60 N m, friction 0.8) holds dock(force 110 N)
    joint j1: revolute(z) in -3 rad .. 3 rad torque drive bearing 100 N m rotor 0.02 kg m^2 mass 0.5 kg
    link 0.2 m: capsule(0.04 m) mass part
    effector B: gripper sphere(0.1 m) density 300 kg/m^3
    fact (linked A B)
}

task t(drive: torque = 38 N m) {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0) mass 3 kg holds pad(force 20 N)
    arm(drive) c: A on ground
    goal (on ground c.B)
}
"""


def test_powers_may_be_written_as_they_are_set() -> None:
    text = TEXT.replace("kg m^2", "kg m²").replace("kg/m^3", "kg/m³")
    kind, same = (compile_text(t)[0].world.modules["c"].type for t in (text, TEXT))
    assert kind.joints[0].rotor == same.joints[0].rotor and module_mass(kind) == module_mass(same)
    assert "kg m²" in format_source(Source("t.tamp", text))


def test_stated_numbers_reach_the_problem_in_si_units() -> None:
    problem, told = compile_text(TEXT)
    kind = problem.world.modules["c"].type
    (joint,), (link,) = kind.joints, kind.links
    assert (joint.torque, joint.bearing, joint.rotor, joint.mass) == (38.0, 100.0, 0.02, 0.5)
    assert joint.stated is not None and TEXT[joint.stated.start :].startswith("torque drive")
    assert link.mass == 2.0 and kind.effector("A").mass == pytest.approx(0.35)
    assert kind.effector("B").mass == pytest.approx(300.0 * 4.0 / 3.0 * math.pi * 0.1**3)
    pad, dock = kind.effector("A").holds
    assert (pad.manner, pad.force, pad.moment, pad.friction, pad.shear) == ("pad", 1000.0, 60.0, 0.8, math.inf)
    assert (dock.manner, dock.force) == ("dock", 110.0)
    assert problem.world.bodies["ground"].mass == 3.0
    assert module_mass(kind) == pytest.approx(0.35 + 0.5 + 2.0 + kind.effector("B").mass)
    assert problem.motions["stand"].borne == "pad" and problem.motions["stable"].borne is None
    assert told == ()


def test_the_weaker_side_counts_number_by_number() -> None:
    problem, _ = compile_text(TEXT)
    foot = problem.world.modules["c"].type.effector("A").holds[0]
    found = weaker(foot, problem.world.bodies["ground"].holds[0], "pad")
    assert found is not None and (found.force, found.moment, found.friction) == (20.0, 60.0, 0.8)
    assert weaker(None, None, "pad") is None


@pytest.mark.parametrize("given", ["12.5Nm", "12.5 N m", "0.0125kN m"])
def test_torques_are_given_on_the_command_line(given: str) -> None:
    problem, _ = compile_text(TEXT, parameters={"drive": given})
    assert problem.world.modules["c"].type.joints[0].torque == pytest.approx(12.5)


def test_the_formatter_keeps_statements() -> None:
    laid = format_source(Source("t.tamp", TEXT))
    assert compile_text(laid)[0].world == compile_text(TEXT)[0].world
    assert format_source(Source("t.tamp", laid)) == laid


FAULTS = [
    ("mass part", "mass 0 kg", "E0522", "must be positive"),
    ("mass part", "mass 3 m", "E0203", "must be a mass, not a length"),
    ("mass part", "mass 3", "E0203", "must be a mass, not a plain number"),
    ("mass part", "mass 1e9 kg", "E0522", "is more than 1e+06 kg"),
    ("mass part", "torque 3 N m", "E0522", "a link states no torque"),
    ("mass part", "mass 1 kg density 300 kg/m^3", "E0522", "said twice"),
    ("mass part", "holds bond(force 3 N)", "E0522", "a link holds nothing"),
    ("density 300 kg/m^3", "density -3 kg/m^3", "E0522", "must be positive"),
    ("density 300 kg/m^3", "mass 3 lb", "E0007", "unknown unit `lb`"),
    ("torque drive", "force 30 N", "E0522", "a revolute joint states no force"),
    ("torque drive", "brake 30 N", "E0203", "must be a torque, not a force"),
    ("torque drive", "brake 0 N m", "E0522", "must be positive"),
    ("torque drive", "torque 0 N m", "E0522", "must be positive"),
    ("torque drive", "torque 38 kg", "E0203", "must be a torque, not a mass"),
    ("rotor 0.02 kg m^2", "rotor 0.02 kg", "E0203", "must be a moment of inertia, not a mass"),
    ("holds dock(force 110 N)", "holds glue(force 110 N)", "E0522", "nothing holds as `glue`"),
    ("holds dock(force 110 N)", "holds dock(forse 110 N)", "E0522", "there is no strength `forse`"),
    ("holds dock(force 110 N)", "holds dock(force 110 N, force 2 N)", "E0522", "`force` is said twice"),
    ("holds dock(force 110 N)", "holds pad(force 110 N)", "E0522", "says twice how it holds"),
    ("holds dock(force 110 N)", "holds dock(friction 1000)", "E0522", "is more than 100"),
    ("link 0.2 m: capsule(0.04 m) mass part", "link 0.2 m mass part", "E0522", "without shape states no mass"),
]


@pytest.mark.parametrize(("old", "new", "code", "message"), FAULTS, ids=[f[1] for f in FAULTS])
def test_bad_statements_are_told_where_they_stand(tmp_path: Path, old: str, new: str, code: str, message: str) -> None:
    path = tmp_path / "t.tamp"
    path.write_text(TEXT.replace(old, new))
    found = [d for d in check(path) if d.is_error]
    assert [d.code for d in found] == [code]
    assert message in found[0].message
    assert found[0].help
    assert found[0].span is not None and found[0].span.line == TEXT[: TEXT.index(old)].count("\n") + 1


ROBOT = """<robot name="r"><link name="base"/><link name="l">
<inertial><origin xyz="0 0 0.2" rpy="0 0 1.5707963267948966"/><mass value="{mass}"/>
<inertia ixx="{xx}" ixy="0" ixz="0" iyy="2" iyz="0" izz="2.5"/></inertial>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="base"/><child link="l"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="{effort}" velocity="1"/></joint></robot>"""
MODULE = """import std.rules
module r from urdf "r.urdf" {{
    effector A: gripper "base" sphere(0.05 m) normal (0, 0, -1) mass 100 g
    effector B: gripper "l" sphere(0.05 m) at (0, 0, 0.3 m) mass 200 g
}}
task t() {{
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    r c: A on ground
    goal (on ground c.B)
}}
"""


def from_urdf(folder: Path, mass: object, xx: object, effort: object) -> ModuleType:
    (folder / "r.urdf").write_text(ROBOT.format(mass=mass, xx=xx, effort=effort))
    (folder / "t.tamp").write_text(MODULE.format())
    return compile_problem(folder / "t.tamp")[0].world.modules["c"].type


def test_a_urdf_states_masses_and_torques(tmp_path: Path) -> None:
    kind = from_urdf(tmp_path, 3, 1, 7)
    (weight,) = kind.inertials
    assert kind.joints[0].torque == 7.0
    assert weight.mass == 3.0 and weight.joint == 0 and weight.centre == pytest.approx((0.0, 0.0, 0.2))
    assert weight.inertia == pytest.approx((2.0, 0.0, 0.0, 1.0, 0.0, 2.5))
    assert module_mass(kind) == pytest.approx(3.3)


def test_no_effort_and_no_mass_in_a_urdf_state_nothing(tmp_path: Path) -> None:
    kind = from_urdf(tmp_path, 0, 1, 0)
    assert kind.joints[0].torque == math.inf and kind.inertials == () and kind.links[0].mass is None


@pytest.mark.parametrize(("mass", "xx"), [(3, 9), (3, -1), (-2, 1), (2e9, 1), ("x", 1)])
def test_an_inertia_that_no_body_has_is_told_and_left_out(tmp_path: Path, mass: object, xx: object) -> None:
    (tmp_path / "r.urdf").write_text(ROBOT.format(mass=mass, xx=xx, effort=1))
    (tmp_path / "t.tamp").write_text(MODULE.format())
    found = [d for d in check(tmp_path / "t.tamp") if d.code == "W0010" or d.is_error]
    assert [d.code for d in found] == ["W0010"]
    assert "link `l`" in found[0].message and found[0].span is not None and found[0].span.file.endswith("r.urdf")
    assert from_urdf(tmp_path, mass, xx, 1).inertials == ()


@pytest.mark.parametrize(
    ("example", "parameters", "bears"),
    [("payload", {}, True), ("tow", {}, True), ("real_climb", {}, True), ("real_climb", {"drive": "2 N m"}, False)],
)
def test_plain_sums_tell_what_bears_itself_at_the_start(example: str, parameters: dict[str, str], bears: bool) -> None:
    text = (EXAMPLES / f"{example}.tamp").read_text().replace("physics = dynamics", "physics = none")
    problem, _ = compile_text(text, "t.tamp", None, parameters)
    world = problem.world
    modules = {n: np.array([[*m.pose, *m.joints]]) for n, m in world.modules.items()}
    at = poses(problem, modules, {n: np.array([b.pose]) for n, b in world.bodies.items()})
    worst = max(float(load.ratio[0]) for load in loads(problem, problem.init_motion, at, 1.5))
    assert plainly_borne(problem) == bears and (worst <= 1.0) == bears


def test_boxes_that_overlap_weigh_once_by_density() -> None:
    sides = (1, 10, 4.5, 0), (1, 10, -4.5, 0), (10, 1, 0, 4.5), (10, 1, 0, -4.5)
    walls = "".join(f", box({x} cm, {y} cm, 10 cm) at ({a} cm, {b} cm, 5 cm)" for x, y, a, b in sides)
    cup = f"object cup: union(box(10 cm, 10 cm, 1 cm) at (0, 0, 0){walls})"
    cup += " on ground at (0.5 m, 0.5 m) density 2000 kg/m^3"
    problem, _ = compile_text(TEXT.replace("    arm(drive)", f"    {cup}\n    arm(drive)"))
    assert problem.world.bodies["cup"].mass == pytest.approx(2000 * (100 + 36 * 10 - 36 * 0.5) * 1e-6)
