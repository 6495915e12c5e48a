"""Joints that follow others: planned with one unknown, both values in the plan file, and measured by the verifier."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pinocchio
import pytest

from tamplang.compiler.ir import Coupling, ModuleType
from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.compiler.poses import effector_pose
from tamplang.langs.diagnostics import SourceError
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.verify import verify
from tamplang.runtime.verify.splines import Spline

GANTRY = """
import std.rules

## Two hoists that follow one drive, and fingers of which one follows the other.
module gantry(ratio: real = 0.8, slow: speed = 0.5 m/s) {
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    link (0, 0, 1 m)
    joint dx: prismatic(x) in 0 m .. 2 m home 0.5 m
    joint dy: prismatic(y) in -1 m .. 1 m
    joint lower: prismatic(z) in -0.4 m .. 0 m speed slow acceleration 0.4 m/s^2
    joint lower = ratio * upper
    link (0, 0, -0.1 m): box(4 cm, 4 cm)
    joint upper: prismatic(z) in -0.6 m .. 0 m
    link (0, 0, -0.1 m): capsule(1 cm)
    branch {
        link (2 cm, 0, 0)
        joint left: prismatic(x) in 0 m .. 4 cm
        link (0, 0, -4 cm): capsule(4 mm)
    }
    branch {
        link (-2 cm, 0, 0)
        joint right: prismatic(x) in -6 cm .. -1 cm
        joint right = -left - 1 cm
        link (0, 0, -4 cm): capsule(4 mm)
    }
    effector B: gripper sphere(1 cm) at (0, 0, -6 cm) normal (0, 0, -1)
    fact (linked A B)
}
task pick(ratio: real = 0.8, slow: speed = 0.5 m/s) {
    object foot: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, -0.025 m)
    object table: box(0.5 m, 1.5 m, 0.1 m) at (1.7 m, 0, 0.03 m)
    object tray1: box(0.5 m, 1.5 m, 0.1 m) at (0.9 m, 0, 0.03 m)
    fact (tray tray1)
    object it: box(0.1 m, 0.1 m, 0.1 m) on table
    fact (grippable it)
    gantry(ratio = ratio, slow = slow) g: A on foot
    goal (on tray1 it)
}
"""


def solved(bound: str = "seq_path", **parameters: str) -> Plan:
    problem, _ = compile_text(GANTRY, "gantry.tamp", "pick", parameters)
    outcome = solve(problem, SolveOptions(seed=1, time=60.0, bound=bound))
    assert outcome.status == "solved"
    return outcome.plans[0]


@pytest.fixture(scope="module")
def plan() -> Plan:
    return solved()


def test_limits_of_both_joints_bound_the_leader() -> None:
    problem, _ = compile_text(GANTRY, "gantry.tamp", "pick", {"slow": "0.1 m/s"})
    lower, upper, left, right = problem.world.modules["g"].type.joints[2:]
    assert lower.follows == Coupling(3, 0.8, 0.0) and right.follows == Coupling(4, -1.0, -0.01)
    assert (upper.lower, upper.upper) == (-0.5, 0.0)
    assert upper.speed == pytest.approx(0.1 / 0.8) and upper.acceleration == pytest.approx(0.4 / 0.8)
    assert (left.lower, left.upper) == pytest.approx((0.0, 0.04)) and right.home == -0.01


@pytest.mark.parametrize("bound", ["seq_path", "path"])
def test_every_program_moves_a_follower_with_its_leader(bound: str, plan: Plan) -> None:
    chosen = plan if bound == "seq_path" else solved(bound, slow="0.1 m/s")
    assert chosen.verdict is not None and chosen.verdict.verified and chosen.needs == ["couplings"]
    assert chosen.verdict.worst["coupling_m"] < 1e-9
    moved = 0.0
    for spline in chosen.splines:
        knots = np.asarray(spline.knots)
        at = Spline(knots, np.asarray(spline.values))(np.linspace(knots[0], knots[-1], 997))
        moved = max(moved, float(np.ptp(at[:, 3])))
        assert at[:, 2] == pytest.approx(0.8 * at[:, 3], abs=1e-9) and at[:, 5] == pytest.approx(-at[:, 4] - 0.01)
    assert moved > 0.2


def follow_less(data: dict[str, Any]) -> None:
    """A follower that lags behind between the samples of a phase, its own limits kept, samples and all."""
    for spline in data["splines"]:
        rows = np.array(spline["values"])
        rows[1:-1, 5] += 1e-4 * np.sin(np.linspace(0, np.pi, len(rows)))[1:-1]
        spline["values"] = rows.tolist()
    track = data["tracks"][0]
    times, joints = np.array(data["times"]), np.array(track["joints"])
    for spline in data["splines"]:
        knots, inside = np.array(spline["knots"]), slice(None)
        inside = np.flatnonzero((times >= spline["knots"][0]) & (times <= spline["knots"][-1]))
        joints[inside, 5] = Spline(knots, np.array(spline["values"]))(times[inside])[:, 5]
    track["joints"] = joints.tolist()


def change_factor(data: dict[str, Any]) -> None:
    data["modules"][0]["joints"][2]["follows"]["factor"] = 0.8001


def drop_coupling(data: dict[str, Any]) -> None:
    del data["modules"][0]["joints"][2]["follows"]


def follow_itself(data: dict[str, Any]) -> None:
    data["modules"][0]["joints"][2]["follows"]["leader"] = 2


def drop_needs(data: dict[str, Any]) -> None:
    data["needs"] = []


@pytest.mark.parametrize(
    ("change", "kind"),
    [(follow_less, "coupling_m"), (change_factor, "scene"), (drop_coupling, "scene"), (follow_itself, "structure"),
     (drop_needs, "structure")],
)  # fmt: skip
def test_a_plan_whose_follower_goes_its_own_way_is_refused(
    plan: Plan, change: Callable[[dict[str, Any]], None], kind: str
) -> None:
    data = msgspec.to_builtins(plan)
    change(data)
    verdict = verify(msgspec.convert(data, Plan))
    assert not verdict.verified and kind in {f.kind for f in verdict.failures}


MIMIC = """<robot name="r"><link name="base"/><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="first" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.1" rpy="0.3 0 0"/>
  <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="before" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.1 0 0.2"/><axis xyz="0 0 1"/>
  <limit lower="-2" upper="2" effort="1" velocity="1"/><mimic joint="first" multiplier="-1.5" offset="0.2"/></joint>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="0 0 0.1"/><axis xyz="1 0 0"/>
  <limit lower="0" upper="0.2" effort="1" velocity="1"/></joint>
<joint name="twin" type="prismatic"><parent link="b"/><child link="d"/><origin xyz="0 0 -0.1"/><axis xyz="-1 0 0"/>
  <limit lower="0" upper="0.3" effort="1" velocity="1"/><mimic joint="slide" multiplier="0.5"/></joint></robot>"""
TAMP = """import std.logic
predicate (lit)
rule light() { pre not (lit) post (lit) }
module robot from urdf "robot.urdf" {
    effector c: gripper "c" sphere(1 cm)
    effector d: gripper "d" sphere(1 cm)
    effector base: gripper "base" sphere(1 cm)
    MORE
}
task t() { robot a: at (0, 0, 1 m) goal (lit) }
"""


def compiled(folder: Path, urdf: str, more: str = "") -> ModuleType:
    (folder / "robot.urdf").write_text(urdf)
    (folder / "t.tamp").write_text(TAMP.replace("MORE", more))
    return compile_problem(folder / "t.tamp")[0].world.modules["a"].type


def test_mimic_of_a_urdf_is_what_pinocchio_makes_of_it(tmp_path: Path) -> None:
    kind = compiled(tmp_path, MIMIC)
    model = pinocchio.buildModelFromXML(MIMIC, mimic=True)
    data, random = model.createData(), np.random.default_rng(3)
    free = [j.name for j in kind.joints if j.follows is None]
    assert sorted(free) == ["first", "slide"] and model.nq == 2
    for _ in range(50):
        chosen = {j.name: random.uniform(j.lower, j.upper) for j in kind.joints}
        q = np.zeros(2)
        for name in free:
            q[model.joints[model.getJointId(name)].idx_q] = chosen[name]
        pinocchio.framesForwardKinematics(model, data, q)
        for name in ("c", "d"):
            ours = effector_pose(kind, name, [chosen[j.name] for j in kind.joints])
            theirs = pinocchio.SE3ToXYZQUAT(data.oMf[model.getFrameId(name)])
            assert ours[:3] == pytest.approx(theirs[:3], abs=1e-12)
            assert abs(np.dot(ours[3:], theirs[3:])) == pytest.approx(1.0, abs=1e-12)


def test_the_text_couples_joints_of_a_urdf_too(tmp_path: Path) -> None:
    bare = re.sub("<mimic[^>]*>", "", MIMIC)
    couplings = "joint before = -1.5 * first + 0.2 rad\n    joint twin = slide / 2"
    assert compiled(tmp_path, bare, couplings) == compiled(tmp_path, MIMIC)


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('joint="first"', 'joint="before"', "follows itself"),
        ('multiplier="0.5"', 'multiplier="half"', "not a number"),
        ('upper="0.2" effort="1" velocity="1"/>', 'upper="0.2"/><mimic joint="twin"/>', "circle"),
    ],
)
def test_a_mimic_that_makes_no_sense_is_refused(tmp_path: Path, old: str, new: str, word: str) -> None:
    assert old in MIMIC
    with pytest.raises(SourceError) as refused:
        compiled(tmp_path, MIMIC.replace(old, new))
    (error,) = refused.value.diagnostics
    assert error.code in ("E0514", "E0521") and word in error.message and error.span is not None


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('joint="first"', 'joint="fisrt"', "moves by itself"),
        ('multiplier="0.5"', 'multiplier="0"', "is fixed at 0"),
        ('multiplier="0.5"', 'multiplier="0.5" offset="-1"', "do not count"),
    ],
)
def test_a_mimic_that_other_readers_take_otherwise_is_told(
    tmp_path: Path, old: str, new: str, word: str
) -> None:
    assert old in MIMIC
    compiled(tmp_path, MIMIC.replace(old, new))
    _, told = compile_problem(tmp_path / "t.tamp")
    assert any(d.code == "W0010" and word in d.message and d.span is not None for d in told), told


def test_a_circle_of_text_and_urdf_is_told_at_the_text(tmp_path: Path) -> None:
    with pytest.raises(SourceError) as refused:
        compiled(tmp_path, MIMIC, "joint first = before")
    (error,) = refused.value.diagnostics
    assert error.code == "E0521" and "circle" in error.message and error.span is not None


def test_a_leader_starts_where_its_followers_can(tmp_path: Path) -> None:
    kind = compiled(tmp_path, MIMIC.replace('offset="0.2"', 'offset="3"'))
    first, before = (next(j for j in kind.joints if j.name == name) for name in ("first", "before"))
    assert (first.lower, first.upper) == pytest.approx((2 / 3, 1.0)) and first.home == pytest.approx(5 / 6)
    assert before.home == pytest.approx(3 - 1.5 * 5 / 6)
