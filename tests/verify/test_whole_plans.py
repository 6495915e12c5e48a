"""Whole plans just inside each limit of the table, which are verified, and just outside, which are not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from tamplang.runtime.plan import Plan
from tamplang.runtime.verify import verify
from tamplang.runtime.verify.limits import LIMITS

from .loaded import LOADED
from .motions import Maker
from .stamping import even, stamped
from .test_between import moving

TEXT = """
import std.logic
import std.motion
import std.rules

## Turns about z, and reaches out along x.
module arm {
    effector foot: gripper sphere(5 cm) normal (0, 0, -1)
    link 20 cm
    joint turn: revolute(z) in -1 rad .. 1 rad
    link (10 cm, 0, 0)
    joint slide: prismatic(x) in 0 m .. 20 cm
    branch {
        joint twin: revolute(x) in -1 rad .. 1 rad
        joint twin = turn / 2
        joint other: prismatic(y) in -1 m .. 1 m
        joint other = slide / 2
    }
    effector tip: gripper sphere(5 cm)
}

predicate (started)
motion [told X: effector, Y: object] { ROW }
rule wave(X: effector, Y: object) { pre not (started) post (started), [told X Y] }
rule again(X: effector, Y: object) { pre (started), (here Y) post (done X) }
predicate (here Y: object)
predicate (done X: effector)

task reach() {
    base slab: box(20 cm, 20 cm, 5 cm) at (0, 0, -2.5 cm)
    object bead: sphere(1 cm) at (BEAD)
    fact (here slab)
    arm a: foot on slab
    arm b: at (0, 2 m, 1 m)
    goal (done a.tip)
}
"""
FAR = "3 m, 0, 0"
NO_ROW = "during top(X) >= -1 m"


def joints(turn: float, slide: float, twin: float = 0.0, other: float = 0.0) -> np.ndarray:
    """Joint values of the arm; those that follow are off by `twin` and `other`."""
    return np.array([turn, slide, turn / 2 + twin, slide / 2 + other])


HOME, OUT = joints(0.0, 0.0), joints(0.0, 0.1)


def plan(row: str = NO_ROW, bead: str = FAR, first: np.ndarray = OUT, second: np.ndarray = OUT) -> Plan:
    """The arm goes to joint values, and then to others; the literal holds from the first switch on."""
    maker = Maker(TEXT.replace("ROW", row).replace("BEAD", bead), "reach")
    maker.phase("wave", ("a.tip", "slab"), [first])
    maker.phase("again", ("a.tip", "slab"), [second])
    return maker.plan()


def at_switch(value: str, known: float) -> Callable[[float], Plan]:
    return lambda x: plan(f"at switch {value} = {known + x:.12f}")


def changed(change: Callable[[dict[str, Any], float], object]) -> Callable[[float], Plan]:
    """The plan, whose record is changed by an amount."""

    def made(x: float) -> Plan:
        data = msgspec.to_builtins(plan(bead="3 m, 0, 1 cm"))
        change(data, x)
        return msgspec.convert(data, Plan)

    return made


def middle(data: dict[str, Any]) -> int:
    return len(data["times"]) // 4


def second_phase(data: dict[str, Any]) -> range:
    return range(len(data["times"]) // 2, len(data["times"]))


def move_start(data: dict[str, Any], x: float) -> None:
    for pose in data["tracks"][0]["poses"]:
        pose[0] += x


def turn_start(data: dict[str, Any], x: float) -> None:
    for pose in data["tracks"][0]["poses"]:
        pose[3:] = Rotation.from_rotvec([0.0, 0.0, x]).as_quat().tolist()


def jump(data: dict[str, Any], x: float) -> None:
    for k in second_phase(data):
        data["tracks"][0]["poses"][k][0] += x


def jump_joint(data: dict[str, Any], x: float) -> None:
    for k in second_phase(data):
        data["tracks"][0]["joints"][k][0] += x
        data["tracks"][0]["joints"][k][2] += x / 2


def off_its_spline(data: dict[str, Any], x: float) -> None:
    data["tracks"][0]["joints"][middle(data)][0] += x


def move_sample(data: dict[str, Any], x: float) -> None:
    data["tracks"][0]["poses"][middle(data)][1] += x


def turn_sample(data: dict[str, Any], x: float) -> None:
    data["tracks"][0]["poses"][middle(data)][3:] = Rotation.from_rotvec([0.0, x, 0.0]).as_quat().tolist()


def stretch(data: dict[str, Any], x: float) -> None:
    data["tracks"][0]["poses"][middle(data)][6] *= 1.0 + x


def shift_time(data: dict[str, Any], x: float) -> None:
    data["phases"][1]["end"] += x


def through_the_switch(data: dict[str, Any], x: float) -> None:
    """One spline through both phases, at rate `x` at the switch between them, which binds the arm."""
    whole = data["phases"][1]["end"]
    knots = [0.0, whole / 2, whole]
    unit = CubicSpline(knots, [0.0, 0.5, 1.0], bc_type="clamped")
    size = x / float(unit(whole / 2, 1))
    slide = CubicSpline(knots, [0.0, 0.5 * size, size], bc_type="clamped")
    values = [joints(float(slide(t)), 0.0).tolist() for t in knots]
    data["splines"] = [{"module": "a", "from": 0, "until": 1, "knots": knots, "values": values}]
    for k, time in enumerate(data["times"]):
        data["tracks"][0]["joints"][k] = joints(float(slide(time)), 0.0).tolist()


def drift(data: dict[str, Any], x: float) -> None:
    """Of the arm that nothing holds."""
    data["tracks"][1]["poses"][middle(data)][0] += x


def twist(data: dict[str, Any], x: float) -> None:
    data["tracks"][1]["poses"][middle(data)][3:] = Rotation.from_rotvec([0.0, x, 0.0]).as_quat().tolist()


def on_course(change: Callable[[list[float], float], None]) -> Callable[[float], Plan]:
    """A sledge on its course, which is changed at one sample."""

    def made(x: float) -> Plan:
        data = msgspec.to_builtins(moving("moves sledge along (-1.2 m, 0, 0), (0, 0, 0) at 2 m/s from 1 s"))
        poses = data["body_tracks"][0]["poses"]
        change(poses[-1], x)
        return msgspec.convert(data, Plan)

    return made


def move(pose: list[float], x: float) -> None:
    pose[1] += x


def turn(pose: list[float], x: float) -> None:
    pose[3:] = Rotation.from_rotvec([0.0, 0.0, x]).as_quat().tolist()


def stuck(x: float) -> Plan:
    """A joint that is locked at 2 s still moves afterwards."""
    data = msgspec.to_builtins(moving("fail c at 2 s: locked"))
    knots = np.linspace(0.0, 8.0, 41)
    start = np.array(data["modules"][0]["start"])
    way = x * (0.5 - 0.5 * np.cos(2.0 * np.pi * knots / 8.0))
    values = (start + way[:, None] * np.eye(7)[1]).tolist()
    data["splines"] = [{"module": "c", "from": 0, "until": 0, "knots": knots.tolist(), "values": values}]
    return stamped(msgspec.convert(data, Plan), even(2))


WHOLE: dict[str, Callable[[float], Plan]] = {
    "position_m": lambda x: plan(f"at switch bottom(X) = {0.2 + x:.12f} m"),
    "gap_m": lambda x: plan(f"at switch gap(X, Y) = {0.2 + x:.12f} m", first=HOME),
    "orientation_rad": at_switch("dot(axis(X, x), axis(Y, y))", 0.0),
    "residual": at_switch("bottom(X) / radius(X)", 4.0),
    "during_m": lambda x: plan(f"during bottom(X) = {0.2 + x:.12f} m"),
    "during": lambda x: plan(f"during bottom(X) / radius(X) = {4.0 + x:.12f}"),
    "slip_m": lambda x: plan("keep position(X)", second=joints(0.0, 0.1 + x)),
    "slip_rad": lambda x: plan("keep axis(X, x)", second=joints(x, 0.1)),
    "penetration_m": lambda x: plan(bead=f"{0.1 + 0.1 + 0.05 + 0.01 - x:.12f} m, 0, 0.25 m"),
    "joint_limit_rad": lambda x: plan(second=joints(1.0 + x, 0.1)),
    "joint_limit_m": lambda x: plan(second=joints(0.0, 0.2 + x)),
    "start_m": changed(move_start),
    "start_rad": changed(turn_start),
    "jump_m": changed(jump),
    "jump_rad": changed(jump_joint),
    "spline_rad": changed(off_its_spline),
    "sample_m": changed(move_sample),
    "sample_rad": changed(turn_sample),
    "switch_rad_s": changed(through_the_switch),
    "rest_m": changed(drift),
    "rest_rad": changed(twist),
    "coupling_rad": lambda x: plan(second=joints(0.0, 0.1, twin=x)),
    "coupling_m": lambda x: plan(second=joints(0.0, 0.1, other=x)),
    "course_m": on_course(move),
    "course_rad": on_course(turn),
    "stuck_rad": stuck,
    "quaternion": changed(stretch),
    "time_s": changed(shift_time),
    **LOADED,
}
"""Plans whose figure of a kind is the amount that is given."""


@pytest.mark.parametrize("kind", WHOLE)
def test_a_whole_plan_just_inside_a_limit_is_verified_and_one_just_outside_is_not(kind: str) -> None:
    inside, outside = (verify(WHOLE[kind](share * LIMITS[kind])) for share in (0.9, 1.1))
    assert inside.verified, inside.failures
    assert inside.worst[kind] == pytest.approx(0.9 * LIMITS[kind], rel=0.02)
    assert kind in {f.kind for f in outside.failures}
    assert outside.worst[kind] == pytest.approx(1.1 * LIMITS[kind], rel=0.02)


def test_every_limit_of_the_table_has_its_whole_plan() -> None:
    assert LIMITS.keys() == WHOLE.keys()
