"""Kinematics of module types, places on supports, and overlaps at the start, against closed forms and Pinocchio."""

from __future__ import annotations

import math
import random
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.poses import between, compose, effector_pose, joint_frames, orientation, position, rotate, yaw
from tamplang.compiler.scenes.check_start import Volume, bounds, candidates, penetration
from tamplang.compiler.scenes.placing import module_pose, top_of
from tamplang.langs.diagnostics import SourceError

HEAD = "import std.crawler\nimport std.rules\n"
GROUND = "base ground: box(3 m, 2 m, 0.05 m) at (0, 0, 0)\n"


def task(items: str, declarations: str = "") -> str:
    return f"{HEAD}{declarations}\ntask t() {{\n{GROUND}{items}\ngoal (on ground c.B)\n}}\n"


def problem(items: str, declarations: str = "") -> ir.Problem:
    return compile_text(task(items, declarations))[0]


@cache
def crawler() -> ir.ModuleType:
    return problem("crawler c: A on ground").world.modules["c"].type


def test_crawler_is_that_of_the_design() -> None:
    made = crawler()
    heights, axes = [0, 0.15, 0.325, 0.5, 0.675, 0.85, 1.0], "zyzyzyz"
    frames = joint_frames(made, ir.IDENTITY, [0.0] * 7)
    for i, (joint, height, axis) in enumerate(zip(made.joints, heights, axes, strict=True)):
        assert (joint.name, joint.kind, joint.parent, joint.speed) == (f"j{i + 1}", "revolute", i - 1, 2.0)
        assert frames[i][2] == pytest.approx(height)
        assert joint.axis == ((0, 0, 1) if axis == "z" else (0, 1, 0))
        assert (joint.lower, joint.upper) == ((-3.1, 3.1) if axis == "z" else (-2.1, 2.1))
    assert [j.home for j in made.joints] == [0, 0.3, 0, -0.6, 0, 0.3, 0]
    assert [(e.name, e.type, e.joint, e.shape) for e in made.effectors] == [
        ("A", "gripper", -1, ir.Shape("sphere", (0.05,))),
        ("B", "gripper", 6, ir.Shape("sphere", (0.05,))),
    ]
    assert made.effectors[0].placement == (0, 0, 0, 1, 0, 0, 0)
    assert [link.joint for link in made.links] == [0, 1, 2, 3, 4, 5]
    assert [link.shape.size for link in made.links] == [
        pytest.approx((0.04, length)) for length in (0.15, 0.175, 0.175, 0.175, 0.175, 0.15)
    ]


def test_parameters_scale_a_module() -> None:
    made = problem("crawler(size = 2 m) c: A on ground").world.modules["c"]
    assert effector_pose(made.type, "B", [0.0] * 7)[:3] == pytest.approx((0, 0, 2))
    assert made.type.name == "crawler(size = 2)"


HAND = """module hand(long: length = 60 cm) {
    effector base: gripper box(10 cm, 10 cm, 4 cm) normal (0, 0, -1)
    joint slide: prismatic(x) in -50 cm .. 50 cm home 10 cm
    link (0, 20 cm, long): cylinder(3 cm)
    joint turn: revolute(-y) in -1 rad .. 1 rad home 0.5 rad speed 90 deg/s acceleration 4 rad/s^2
    link 30 cm: box(4 cm, 6 cm)
    effector tip: gripper sphere(3 cm) at (1 cm, 0, 0) normal (1, 0, 0)
}
"""


def test_elements_follow_each_other() -> None:
    made = problem("hand h: base on ground\ncrawler c: A on ground at (1 m, 0)", HAND).world.modules["h"].type
    slide, turn = made.joints
    assert (slide.kind, slide.axis, slide.speed, slide.home) == ("prismatic", (1, 0, 0), 0.5, 0.1)
    assert (turn.axis, turn.parent) == ((0, -1, 0), 0)
    assert turn.speed == pytest.approx(math.pi / 2)
    assert (slide.acceleration, turn.acceleration) == (1.0, 4.0)
    assert turn.placement[:3] == pytest.approx((0, 0.2, 0.6))
    slanted, straight = made.links
    assert slanted.shape.size == pytest.approx((0.03, math.hypot(0.2, 0.6)))
    along = rotate(orientation(slanted.placement), (0, 0, 1))
    assert along == pytest.approx((0, 0.2 / math.hypot(0.2, 0.6), 0.6 / math.hypot(0.2, 0.6)))
    assert straight.shape == ir.Shape("box", (0.04, 0.06, 0.3))
    tip = made.effector("tip")
    assert tip.placement[:3] == pytest.approx((0.01, 0, 0.3))
    assert rotate(orientation(tip.placement), (0, 0, 1)) == pytest.approx((1, 0, 0))


def pinocchio_pose(pose: ir.Pose) -> pin.SE3:
    return pin.XYZQUATToSE3(np.array(pose))


@given(st.lists(st.floats(-2, 2), min_size=7, max_size=7))
@settings(max_examples=30, deadline=None)
def test_forward_kinematics_agree_with_pinocchio(values: list[float]) -> None:
    made = crawler()
    model = pin.Model()
    parent = 0
    for joint in made.joints:
        kind = pin.JointModelRevoluteUnaligned(np.array(joint.axis))
        parent = model.addJoint(parent, kind, pinocchio_pose(joint.placement), joint.name)
    data = model.createData()
    pin.forwardKinematics(model, data, np.array(values))
    frames = joint_frames(made, ir.IDENTITY, values)
    for i in range(7):
        assert np.allclose(pinocchio_pose(frames[i]).homogeneous, data.oMi[i + 1].homogeneous, atol=1e-12)


angles = st.floats(-3.1, 3.1)


@given(st.sampled_from("AB"), st.floats(-1, 1), st.floats(-1, 1), angles)
@settings(max_examples=50, deadline=None)
def test_a_foot_stands_on_its_point(effector: str, x: float, y: float, heading: float) -> None:
    made = crawler()
    pose = module_pose(made, effector, (x, y, 0.5), heading)
    foot = compose(pose, effector_pose(made, effector, [j.home for j in made.joints]))
    assert position(foot) == pytest.approx((x, y, 0.55))
    assert rotate(orientation(foot), (0, 0, 1)) == pytest.approx((0, 0, -1), abs=1e-9)
    axis = rotate(orientation(pose), (1, 0, 0))
    level = math.hypot(axis[0], axis[1])
    assert (axis[0] / level, axis[1] / level) == pytest.approx((math.cos(heading), math.sin(heading)), abs=1e-9)


def test_places_turn_with_their_support() -> None:
    made = problem(
        "object table: box(1 m, 1 m, 0.4 m) on ground at (0.5 m, 0.2 m) heading 90 deg\n"
        "object cup: cylinder(5 cm, 10 cm) on table at (0.3 m, 0.1 m) heading 30 deg\n"
        "crawler c: A on table at (-0.3 m, 0) heading 10 deg"
    )
    table, cup = made.world.bodies["table"], made.world.bodies["cup"]
    assert table.pose[:3] == pytest.approx((0.5, 0.2, 0.225))
    assert cup.pose[:3] == pytest.approx((0.4, 0.5, 0.475))
    assert cup.pose[3:] == pytest.approx(yaw(math.radians(120)))
    module = made.world.modules["c"]
    assert module.pose[:3] == pytest.approx((0.5, -0.1, 0.475))
    assert module.pose[3:] == pytest.approx(yaw(math.radians(100)))


def test_placements_give_the_first_state() -> None:
    made = problem("object cup: sphere(4 cm) on ground at (1 m, 0)\ncrawler c: A on ground")
    assert made.init == {
        ("on", "ground", "cup"), ("on", "ground", "c.A"), ("support", "c.A"), ("linked", "c.A", "c.B"),
        ("linked", "c.B", "c.A"),
    }  # fmt: skip
    assert made.init_motion == {("stable", "ground", "cup"), ("stable", "ground", "c.A"), ("stand", "c.A", "ground")}


def test_only_what_a_rule_can_carry_is_movable() -> None:
    made = problem(
        "object cup: sphere(4 cm) on ground at (1 m, 0)\nobject mug: sphere(4 cm) on ground at (1 m, 0.5 m)\n"
        "fact (grippable cup)\nfact (tray ground)\ncrawler c: A on ground"
    )
    assert {b.name for b in made.world.bodies.values() if b.movable} == {"cup"}


unit_vectors = st.tuples(angles, angles).map(
    lambda a: (math.cos(a[0]) * math.cos(a[1]), math.sin(a[0]) * math.cos(a[1]), math.sin(a[1]))
)


@given(unit_vectors, unit_vectors)
def test_smallest_turn(a: ir.Vec3, b: ir.Vec3) -> None:
    turn = between(a, b)
    assert rotate(turn, a) == pytest.approx(b, abs=1e-6)
    assert sum(c * c for c in turn) == pytest.approx(1)


def random_volume(source: random.Random, name: str) -> Volume:
    kind = source.choice(["box", "sphere", "capsule", "cylinder"])
    count = {"box": 3, "sphere": 1}.get(kind, 2)
    shape = ir.Shape(kind, tuple(source.uniform(0.05, 0.4) for _ in range(count)))
    q = np.array([source.gauss(0, 1) for _ in range(4)])
    q /= np.linalg.norm(q)
    pose: ir.Pose = (source.uniform(-1, 1), source.uniform(-1, 1), source.uniform(-1, 1), *map(float, q))
    return Volume(name, name, shape, pose, bounds(shape, pose), None, name)


@pytest.mark.parametrize("seed", range(5))
def test_no_overlap_escapes_the_sweep(seed: int) -> None:
    source = random.Random(seed)
    volumes = [random_volume(source, str(i)) for i in range(25)]
    swept = {frozenset((a.name, b.name)) for a, b in candidates(volumes)}
    deep = {
        frozenset((a.name, b.name))
        for i, a in enumerate(volumes)
        for b in volumes[:i]
        if penetration(a, b) > 2e-3
    }
    assert deep
    assert deep <= swept


@pytest.mark.parametrize(
    ("height", "overlap"), [(0.0655, None), (0.065, None), (0.0642, None), (0.06, 5), (0.045, 20)]
)
def test_resting_in_contact_is_no_overlap(height: float, overlap: int | None) -> None:
    text = task(f"object ball: sphere(0.04 m) at (1 m, 0, {height} m)\ncrawler c: A on ground")
    found = [d for d in compile_text(text)[1] if d.code == "W0012"]
    if overlap is None:
        assert not found
    else:
        assert len(found) == 1 and f"by {overlap} mm" in found[0].message


def test_tops_of_shapes() -> None:
    shapes = [("box", (1, 2, 3), 1.5), ("sphere", (0.5,), 0.5), ("cylinder", (1, 2), 1), ("capsule", (1, 2), 2)]
    assert [top_of(ir.Shape(kind, size)) for kind, size, _ in shapes] == [top for *_, top in shapes]


LIFT = """type deck < effector
module lift(tilt: angle = 0 deg) {
    effector foot: deck box(20 cm, 20 cm, 2 cm) at (0, 0, 1 cm) normal (0, 0, -1)
    link 10 cm
    joint up: prismatic(z) in 0 m .. 50 cm home 30 cm
    joint tip: revolute(y) in -1 rad .. 1 rad home tilt
    effector plate: deck box(40 cm, 30 cm, 2 cm) at (10 cm, 0, 0)
}
placement (A: deck) on (Y: object) { (on Y A), [stable Y A] }
"""


def test_things_and_robots_stand_on_ends_of_robots_where_these_are_at_home() -> None:
    """Worked out by hand: the floor is at 2.5 cm, the plate's middle 40 cm above that and 10 cm to the side, turned."""
    lift = "lift l: foot on ground at (1 m, 0) heading 90 deg\n"
    things = "object cup: box(2 cm, 4 cm, 6 cm) on l.plate at (3 cm, 4 cm)\ncrawler c: A on l.plate at (-10 cm, 0)"
    made = problem(lift + things, LIFT)
    assert position(made.world.bodies["cup"].pose) == pytest.approx((0.96, 0.13, 0.025 + 0.4 + 0.01 + 0.03))
    assert position(made.world.modules["c"].pose) == pytest.approx((1.0, 0.0, 0.025 + 0.4 + 0.01 + 0.05))
    assert {("stable", "l.plate", "cup"), ("stable", "l.plate", "c.A")} <= made.init_motion


@pytest.mark.parametrize(
    ("items", "said", "hint"),
    [
        ("lift(tilt = 5 deg) l: foot on ground", "the top of `l.plate` is not level at the start", "`home`"),
        ("lift plate: foot on ground", "`plate` is not a body that can carry", "`plate.foot`, `plate.plate`"),
    ],
)
def test_what_cannot_carry_is_told(items: str, said: str, hint: str) -> None:
    on = "plate" if "lift plate" in items else "l.plate"
    with pytest.raises(SourceError) as told:
        problem(f"{items}\nobject cup: box(2 cm, 4 cm, 6 cm) on {on}\ncrawler c: A on ground", LIFT)
    (found,) = told.value.diagnostics
    assert said in found.message and hint in (found.help or "")


def test_a_placement_of_the_program_counts_before_one_that_it_imports() -> None:
    own = "predicate (lies X: object, Y: object)\nplacement (X: object) on (Y: object) { (lies X Y) }\n"
    made = problem("object cup: box(2 cm, 4 cm, 6 cm) on ground\ncrawler c: A on ground at (0, 50 cm)", own)
    assert ("lies", "cup", "ground") in made.init
    with pytest.raises(SourceError) as told:
        problem("crawler c: A on ground", own + "placement (X: object) on (Y: object) { (on Y X) }\n")
    (found,) = (d for d in told.value.diagnostics if d.code == "E0110")
    assert "the placement of `object` on `object` is declared twice" in found.message
