"""Single measures of the checker against figures known otherwise."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_sources
from tamplang.langs.source import Source
from tamplang.runtime.geometry.resampling import effector_poses
from tamplang.runtime.geometry.transforms import compose, inverse
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.plan_assembly import module_record
from tamplang.runtime.verify import geometry, shapes, verify
from tamplang.runtime.verify.findings import Findings
from tamplang.runtime.verify.guards import joint_frames
from tamplang.runtime.verify.happenings import happenings_of
from tamplang.runtime.verify.kinematics import Kinematics, check_kinematics, motion_of
from tamplang.runtime.verify.links import links_of
from tamplang.runtime.verify.motion import check_motion
from tamplang.runtime.verify.replay import replay
from tamplang.runtime.verify.sampler import Sampler, curves_of

from .motions import Maker

POSES = np.hstack([
    np.random.default_rng(1).normal(size=(20, 3)), Rotation.random(20, random_state=2).as_quat()
])  # fmt: skip


def test_rotations_agree_with_scipy() -> None:
    expected = Rotation.from_quat(POSES[:, 3:]).as_matrix()
    assert np.allclose(geometry.rotation_matrices(POSES[:, 3:]), expected, atol=1e-14)


def test_compose_and_inverse_agree_with_frames() -> None:
    whole = compose(POSES[:10], POSES[10:])
    first, second = geometry.frames(POSES[:10]), geometry.frames(POSES[10:])
    expected = first.compose(second)
    assert np.allclose(geometry.frames(whole).position, expected.position)
    assert np.allclose(geometry.frames(whole).rotation, expected.rotation)
    back = compose(inverse(POSES[:10]), whole)
    assert np.allclose(geometry.frames(back).rotation, second.rotation)
    assert np.allclose(expected.relative_to(first).position, second.position)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.3, math.pi])
def test_angles_are_accurate_near_zero(angle: float) -> None:
    turned = Rotation.from_rotvec([0.0, angle, 0.0]).as_matrix()
    assert geometry.angles(turned[None], np.eye(3)[None])[0] == pytest.approx(angle, abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "size"), [("box", (0.2, 0.3, 0.4)), ("sphere", (0.2,)), ("capsule", (0.1, 0.5)), ("cylinder", (0.1, 0.5))]
)
def test_heights_touch_the_floor(kind: str, size: tuple[float, ...]) -> None:
    """A thing whose lowest point is at height 0 touches a slab that ends there."""
    rotations = Rotation.random(10, random_state=3).as_matrix()
    ruler, slab = shapes.Ruler(), shapes.geometry("box", (10.0, 10.0, 1.0))
    for rotation, half in zip(rotations, shapes.heights(kind, size, rotations), strict=True):
        at = shapes.transform(np.array([0.0, 0.0, half]), rotation)
        floor = shapes.transform(np.array([0.0, 0.0, -0.5]), np.eye(3))
        assert ruler.distance(shapes.geometry(kind, size), at, slab, floor) == pytest.approx(0.0, abs=1e-5)


def test_good_plan_is_verified(hop: Plan) -> None:
    verdict = verify(hop)
    assert verdict.verified and not verdict.failures
    assert verdict.worst["slip_m"] < 1e-9
    assert verdict.worst["penetration_m"] < 1e-6
    assert {r.kind for r in verdict.residuals} == {"stand", "touch"}
    assert all(r.place is not None for r in verdict.residuals)


def test_foot_stays_between_samples(hop: Plan) -> None:
    kinematics = {m.name: Kinematics(m) for m in hop.modules}
    motion = motion_of(hop, kinematics)
    problem = problem_of(hop)
    story = replay(problem, hop, Findings())
    happenings = happenings_of(problem, hop, story.modes)
    links = links_of(problem, story.modes, motion, happenings, 1e-6)
    sampler = Sampler(problem.world, motion, kinematics, happenings, links, curves_of(hop))
    for phase, foot in enumerate(["A", "B", "A", "A"]):
        grid = sampler.grid(phase)
        assert len(grid.times) == 8 * (len(hop.splines[phase].knots) - 1) + 1 and grid.joined.all()
        placement = sampler.at(phase, grid.times)
        assert np.ptp(placement.frame(f"c.{foot}").position, axis=0).max() < 1e-9
        assert np.ptp(placement.frame("c.B" if foot == "A" else "c.A").position, axis=0).max() > 0.01


SWING = """
import std.crawler
import std.motion
predicate (waved c: module)
rule wave(c: module, k: 1 .. 2) {
    pre   k = 1 or (waved c)
    post  (waved c)
}
task wave() {
    object slab: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, 0)
    object bead: sphere(0.001 m) at (BEAD)
    crawler c: A on slab
    goal (waved c)
}
"""


def swing(bead: tuple[float, float, float]) -> Plan:
    """A stretched arm turns by 3 rad in 2 planner samples, 20 looks of the checker."""
    level = np.array([0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0])
    maker = Maker(SWING.replace("BEAD", ", ".join(f"{x:.6f} m" for x in bead)), "wave")
    maker.phase("wave", ("c", "1"), [level])
    maker.phase("wave", ("c", "2"), [level + 3.0 * np.eye(7)[0]], seconds=8.0, samples=2)
    return maker.plan()


def test_bead_between_looks_is_found() -> None:
    """The arm passes the bead between two looks, both 4 cm away: only the swept check sees it."""
    assert verify(swing((3.0, 0.0, 0.0))).verified
    angle = CubicSpline([0.0, 4.0, 8.0], [0.0, 1.5, 3.0], bc_type="clamped")(4.2)
    looks = CubicSpline([0.0, 4.0, 8.0], [0.0, 1.5, 3.0], bc_type="clamped")([4.0, 4.4])
    assert np.all(0.6 * np.sin(np.abs(looks - angle)) > 0.04)
    verdict = verify(swing((0.6 * math.cos(angle), 0.6 * math.sin(angle), 0.225)))
    (failure,) = verdict.failures
    assert failure.kind == "penetration_m" and failure.amount > 1e-3
    assert failure.between[1] == "bead" and failure.time == pytest.approx(8.2, abs=0.2)


def test_task_that_is_already_done() -> None:
    """A plan without phases has one sample."""
    text = SWING.replace("BEAD", "1 m, 0, 0").replace("goal (waved c)", "goal not (waved c)")
    plan = Maker(text, "wave").plan()
    assert plan.times == [0.0] and not plan.phases
    assert verify(plan).verified


def test_goal_is_told_in_the_notation_of_the_language(hop: Plan) -> None:
    assert hop.task.goal == "(shown ball)"


def random_module(draw: np.random.Generator) -> ir.Module:
    """A tree of revolute and prismatic joints with an effector on each."""
    joints, effectors = [], []
    for index in range(6):
        placement = (*draw.normal(size=3), *Rotation.random(rng=draw).as_quat())
        kind = "prismatic" if draw.random() < 0.3 else "revolute"
        parent = int(draw.integers(-1, index))
        joints.append(ir.Joint(f"j{index}", kind, parent, placement, tuple(draw.normal(size=3)), -2.0, 2.0, 0.0, 2.0))
        effectors.append(ir.Effector(f"E{index}", "effector", index, placement, None))
    kind_of_tree = ir.ModuleType("tree", tuple(joints), tuple(effectors), ())
    pose = (*draw.normal(size=3), *Rotation.random(rng=draw).as_quat())
    return ir.Module("t", kind_of_tree, pose, tuple(draw.uniform(-2, 2, size=6)))


@pytest.mark.parametrize("seed", range(5))
def test_kinematics_of_trees_agree(seed: int) -> None:
    """Pinocchio, the checker's, the assembler's and the guards' kinematics put every effector at the same place."""
    module = random_module(np.random.default_rng(seed))
    kinematics = Kinematics(module_record(module))
    joints = kinematics.joint_frames(np.array([module.pose]), np.array([module.joints]))
    assert kinematics.disagreement(np.array([module.pose]), np.array([module.joints]), joints) < 1e-12
    plain = joint_frames(module)
    for effector in module.type.effectors:
        frame = kinematics.effector(effector.name, joints)
        local = effector_poses(module, effector.name, np.array([module.joints]))
        chained = geometry.frames(compose(np.array([module.pose]), local))
        guarded = plain[effector.joint].compose(geometry.frames(effector.placement))
        for other in (chained, guarded):
            assert np.allclose(frame.position, other.position, atol=1e-12)
            assert np.allclose(frame.rotation, other.rotation, atol=1e-12)


def test_frames_that_pinocchio_does_not_find_are_refused(hop: Plan) -> None:
    kinematics = {m.name: Kinematics(m) for m in hop.modules}
    motion, findings = motion_of(hop, kinematics), Findings()
    check_kinematics(motion, kinematics, findings)
    assert not findings.failures
    motion.joint_frames["c"][3].position[motion.ranges[1][1]] += 1e-6
    check_kinematics(motion, kinematics, findings)
    (failure,) = findings.failures
    assert failure.kind == "kinematics" and failure.amount == pytest.approx(1e-6) and failure.between == ["c"]


def test_only_bodies_are_known_to_rest(hop: Plan) -> None:
    """Effectors and modules move by their joints, which their poses do not show."""
    motion = motion_of(hop, {m.name: Kinematics(m) for m in hop.modules})
    last = len(motion.times) - 1
    assert motion.rests("left", 0, last) and motion.rests("ball", 0, 1)
    assert not any(motion.rests(name, 0, last) for name in ("ball", "c", "c.A", "c.B"))


def test_module_without_joints() -> None:
    """A rigid module stands, and another one waves beside it."""
    text = SWING.replace("BEAD", "1 m, 0, 0").replace(
        "rule wave", "module pole() { effector F: effector sphere(0.05 m) normal (0, 0, -1) }\nrule wave"
    ).replace("crawler c: A on slab", "crawler c: A on slab\n    pole p: at (0.6 m, 0.6 m, 0.1 m)")
    maker = Maker(text, "wave")
    maker.phase("wave", ("c", "1"), [np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0])])
    plan = maker.plan()
    assert plan.tracks[1].joints[0] == []
    assert verify(plan).verified, verify(plan).failures


def test_a_held_thing_that_turns_in_place_slips(hop: Plan) -> None:
    data = msgspec.to_builtins(hop)
    for pose in data["body_tracks"][0]["poses"][-50:]:
        pose[3:] = [0.0, 0.0, math.sin(0.05), math.cos(0.05)]
    failures = verify(msgspec.convert(data, Plan)).failures
    assert ["c.B", "ball"] in [f.between for f in failures if f.kind == "sample_rad"]


def problem_of(plan: Plan) -> ir.Problem:
    sources = [Source(s.path, s.text) for s in plan.task.sources]
    return compile_sources(sources, plan.task.name, {}, plan.task.seed)[0]


def measure_motion(plan: Plan, findings: Findings) -> None:
    """The measures of the motion alone, which a plan whose modules are not those of its scene never gets to."""
    problem = problem_of(plan)
    motion = motion_of(plan, {m.name: Kinematics(m) for m in plan.modules})
    story = replay(problem, plan, findings)
    check_motion(problem, plan, motion, curves_of(plan), happenings_of(problem, plan, story.modes), findings)


@pytest.mark.parametrize("joint", [0, 1, 3])
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_both_limits_of_a_joint_are_measured(hop: Plan, joint: int, side: str) -> None:
    data = msgspec.to_builtins(hop)
    values = [row[joint] for row in data["tracks"][0]["joints"]]
    sign = 1 if side == "lower" else -1
    data["modules"][0]["joints"][joint][side] = (min(values) if side == "lower" else max(values)) + 0.1 * sign
    plan, findings = msgspec.convert(data, Plan), Findings()
    measure_motion(plan, findings)
    assert findings.measures["joint_limit_rad"].amount == pytest.approx(0.1, abs=5e-3)


def test_the_splines_keep_the_limits_too(hop: Plan) -> None:
    data = msgspec.to_builtins(hop)
    highest = max(row[1] for row in data["tracks"][0]["joints"])
    data["modules"][0]["joints"][1]["upper"] = highest + 0.1
    data["splines"][1]["values"][5][1] = highest + 0.2
    plan, findings = msgspec.convert(data, Plan), Findings()
    measure_motion(plan, findings)
    assert findings.measures["joint_limit_rad"].amount >= 0.1 - 1e-9
