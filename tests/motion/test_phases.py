"""P_seqPath: phases between given switches, on small arms and on the crawlers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tamplang.compiler.ir import (
    IDENTITY,
    Action,
    Arith,
    Body,
    Effector,
    Joint,
    Link,
    Module,
    ModuleType,
    Number,
    Shape,
)
from tamplang.compiler.motion.collision import contacts, pose_matrix
from tamplang.runtime.budget import Budget, OutOfTime
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.phases import Reason, UnsupportedPhase, polish, solve_sequence_path
from tamplang.runtime.planner.motion.phases.joint_forest import link_frames, phase_tree
from tamplang.runtime.planner.motion.phases.phase_batch import Batch
from tamplang.runtime.planner.motion.phases.phase_geometry import make_parts
from tamplang.runtime.planner.motion.phases.proximity import close
from tamplang.runtime.planner.motion.phases.rrt_connect import sampled_starts
from tamplang.runtime.planner.motion.phases.smoothing import Schedule, smooth_paths
from tamplang.runtime.planner.motion.phases.swept_check import sweep
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import BoundResult, Breach, Configuration, Phase, Skeleton, start_configuration

from .fixtures import (
    CRAWLER,
    MOTIONS,
    X,
    Y,
    box,
    call,
    climb_alone,
    climb_together,
    crawler,
    make_problem,
    motion,
    pick_and_place,
    switch,
)

SETTINGS = MotionSettings()
Fact = tuple[str, ...]


def planar_arm(links: int, length: float = 0.4, speed: float = 2.0, prismatic: bool = False) -> ModuleType:
    """An arm that moves in the x-y plane; effector A is its fixed foot, B its tip."""
    joints, shapes = [], []
    for i in range(links):
        kind, axis = ("prismatic", (1.0, 0.0, 0.0)) if prismatic and i == 1 else ("revolute", (0.0, 0.0, 1.0))
        limit = 0.3 if kind == "prismatic" else 2.8
        at = (length if i else 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        joints.append(Joint(f"j{i + 1}", kind, i - 1, at, axis, -limit, limit, 0.0, speed))
        turn = math.sqrt(0.5)
        middle = (length / 2, 0.0, 0.0, 0.0, turn, 0.0, turn)
        shapes.append(Link(i, middle, Shape("capsule", (0.03, length - 0.1))))
    ball = Shape("sphere", (0.04,))
    foot = Effector("A", "gripper", -1, IDENTITY, ball)
    tip = Effector("B", "gripper", links - 1, (length, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), ball)
    return ModuleType("arm", tuple(joints), (foot, tip), tuple(shapes))


def arm_scene(
    kind: ModuleType, bodies: Sequence[Body], first: Sequence[float], *later: Sequence[float]
) -> tuple[Skeleton, list[Configuration]]:
    """An arm on a small foot plate that goes from one set of joint values to the next."""
    foot = box("foot", (0.05, 0.05, 0.05), (0.0, 0.0, -0.065))
    module = Module("arm", kind, IDENTITY, tuple(first))
    mode: set[Fact] = {("stable", "foot", "arm.A")}
    problem = make_problem([foot, *bodies], [module], mode, "arm")
    phases = tuple(Phase(Action("move", ()), frozenset(mode), frozenset()) for _ in later)
    configurations = [start_configuration(problem)]
    for values in later:
        configurations.append(configurations[0].copy())
        configurations[-1].modules["arm"][7:] = values
    return Skeleton(problem, phases, frozenset(mode)), configurations


def solve(scene: tuple[Skeleton, list[Configuration]], seed: int = 0) -> BoundResult:
    return solve_sequence_path(*scene, SETTINGS, Seed(seed), Budget(100.0))


def penetration(skeleton: Skeleton, result: BoundResult) -> float:
    """How deep the links' capsules overlap boxes on a dense spline, at points on their axes; below 0: clear."""
    from scipy.interpolate import CubicSpline

    worst = -math.inf
    for path in result.paths:
        for name, samples in path.modules.items():
            kind = skeleton.problem.world.modules[name].type
            knots = np.arange(len(samples))
            values = CubicSpline(knots, samples[:, 7:], bc_type="clamped")(np.linspace(0, knots[-1], 401))
            for joints in values:
                frames = link_frames(kind, np.concatenate([samples[0, :7], joints]))
                points = [axis_points(frames[link.joint], link) for link in kind.links]
                for body in skeleton.problem.world.bodies.values():
                    away = np.abs(np.concatenate(points) - body.pose[:3]) - np.array(body.shape.size) / 2
                    worst = max(worst, float((0.03 - np.linalg.norm(np.maximum(away, 0.0), axis=1)).max()))
    return worst


def axis_points(frame: np.ndarray, link: Link) -> np.ndarray:
    """Points `(9, 3)` on the axis of a capsule link."""
    heights = np.linspace(-0.5, 0.5, 9) * link.shape.size[1]
    local = np.stack([0 * heights, 0 * heights, heights, 1 + 0 * heights])
    return (frame @ pose_matrix(link.placement) @ local)[:3].T


def test_a_free_phase_takes_the_time_of_its_limits_and_ends_at_rest() -> None:
    result = solve(arm_scene(planar_arm(2), [], (0.0, 0.0), (0.3, -0.2)))
    assert result.feasible and result.bound == "seq-path" and len(result.paths) == 1
    path = result.paths[0]
    assert 0.15 <= path.duration < 1.0
    assert path.modules["arm"].shape == (SETTINGS.slices + 1, 9)
    assert path.modules["arm"][0, 7:] == pytest.approx([0.0, 0.0])
    assert path.modules["arm"][-1, 7:] == pytest.approx([0.3, -0.2])
    assert result.iterations > 0 and result.seconds > 0.0 and result.cost > 0.0


def test_slow_joints_take_longer() -> None:
    from scipy.interpolate import CubicSpline

    result = solve(arm_scene(planar_arm(2, speed=0.5), [], (-1.0, 0.0), (1.0, 0.5)))
    path = result.paths[0]
    times = np.linspace(0, path.duration, SETTINGS.slices + 1)
    spline = CubicSpline(times, path.modules["arm"][:, 7:], bc_type="clamped")
    fastest = np.abs(spline(np.linspace(0, path.duration, 2001), 1)).max()
    assert 0.49 < fastest <= 0.5
    assert path.duration * 100 == pytest.approx(round(path.duration * 100))


def test_a_path_that_tunnels_between_slices_is_caught() -> None:
    slab = box("slab", (0.5, 0.004, 0.3), (0.55, 0.0, 0.0))
    skeleton, configurations = arm_scene(planar_arm(1, 0.8), [slab], (-1.4,), (1.4,))
    tree = phase_tree(skeleton.problem, 0, skeleton.phases[0], configurations[0], configurations[1])
    world = skeleton.problem.world
    parts, states = [make_parts(tree, world)], [(configurations[0], configurations[1])]
    batch = Batch(parts, states, world, contacts(skeleton), 5, 0.0)
    path = np.linspace(-1.4, 1.4, 6)[None, :, None]
    assert not any(len(found.row) for found in close(batch.coarse, path, 0.01))
    assert not sweep(batch, path).clean[0]
    assert sweep(batch, path).clearance[0] < -0.02


def test_a_phase_around_a_wall_is_solved() -> None:
    wall = box("wall", (0.5, 0.06, 0.3), (0.85, 0.0, 0.0))
    scene = arm_scene(planar_arm(3, 0.33), [wall], (0.7, -0.2, 0.1), (-0.7, 0.2, -0.1))
    result = solve(scene)
    assert result.feasible, result.violations
    assert penetration(scene[0], result) <= 0.0


def test_a_phase_through_a_gap_is_solved() -> None:
    walls = [box("near", (0.3, 0.06, 0.3), (0.42, 0.0, 0.0)), box("far", (0.4, 0.06, 0.3), (1.03, 0.0, 0.0))]
    first, last = (0.9, 0.3, -0.5), (0.6, -0.4, -1.75)
    scene = arm_scene(planar_arm(3, 0.35), walls, first, last)
    result = solve(scene)
    assert result.feasible, result.violations
    assert penetration(scene[0], result) <= 0.0


def test_sampling_finds_a_way_round_the_wall() -> None:
    wall = box("wall", (0.5, 0.06, 0.3), (0.85, 0.0, 0.0))
    skeleton, states = arm_scene(planar_arm(3, 0.33), [wall], (0.7, -0.2, 0.1), (-0.7, 0.2, -0.1))
    tree = phase_tree(skeleton.problem, 0, skeleton.phases[0], states[0], states[1])
    world = skeleton.problem.world
    parts = [make_parts(tree, world)]
    batch = Batch(parts, [(states[0], states[1])], world, contacts(skeleton), SETTINGS.slices, SETTINGS.margin)
    starts = np.array(sampled_starts(batch, 0, np.random.default_rng(0), Budget(20.0), 60, (5, 10, 15)))
    assert starts.shape == (3, SETTINGS.slices - 1, 3)
    several = batch.take(np.zeros(3, dtype=np.intp)).looking(2)
    inner, _ = smooth_paths(several, starts, Schedule(weight=1e5, widening=1.6), Budget(20.0))
    assert sweep(several, several.with_ends(inner)).clean.any()


def test_an_impossible_phase_names_the_wall() -> None:
    walls = [box("east", (1.0, 0.06, 0.3), (0.62, 0.0, 0.0)), box("west", (1.0, 0.06, 0.3), (-0.62, 0.0, 0.0))]
    result = solve(arm_scene(planar_arm(2, 0.4), walls, (0.8, 0.2), (-0.8, -0.2)))
    assert not result.feasible
    worst = result.violations[0]
    assert worst.phase == 0 and worst.unit == "m" and worst.amount > 0.0
    assert worst.kind == Breach.COLLISION and worst.names[1] in {"east", "west"}


def test_a_switch_beyond_a_joint_limit_names_the_joint() -> None:
    result = solve(arm_scene(planar_arm(2), [], (0.0, 0.0), (0.3, 2.9)))
    assert not result.feasible
    worst = result.violations[0]
    assert (worst.kind, worst.names, worst.unit) == (Breach.JOINT_LIMIT, ("arm", "j2"), "rad")
    assert result.violations[0].amount == pytest.approx(0.1, abs=0.01)


def test_too_large_a_motion_for_the_slices_gets_more_slices() -> None:
    skeleton, states = arm_scene(planar_arm(2), [], (-2.5, 0.0), (2.5, 0.0))
    result = solve_sequence_path(skeleton, states, MotionSettings(slices=6), Seed(0), Budget(20.0))
    assert result.feasible
    joints = result.paths[0].modules["arm"][:, 7:]
    assert len(joints) > 7 and np.abs(np.diff(joints, axis=0)).max() <= 0.5


def test_a_blocked_switch_is_reported_without_solving() -> None:
    block = box("block", (0.2, 0.2, 0.2), (0.8, 0.0, 0.0))
    result = solve(arm_scene(planar_arm(2), [block], (1.5, 0.0), (0.0, 0.0)))
    assert not result.feasible and result.iterations == 0 and not result.paths
    assert (result.violations[0].kind, result.violations[0].names) == (Breach.COLLISION, ("arm.B", "block"))
    assert result.violations[0].amount == pytest.approx(0.14, abs=0.01)


def test_without_collisions_everything_passes() -> None:
    block = box("block", (0.2, 0.2, 0.2), (0.8, 0.0, 0.0))
    skeleton, states = arm_scene(planar_arm(2), [block], (1.5, 0.0), (0.0, 0.0))
    settings = MotionSettings(collisions=False)
    assert solve_sequence_path(skeleton, states, settings, Seed(0), Budget(20.0)).feasible


def test_modules_need_no_shapes() -> None:
    bare = replace(planar_arm(2), links=(), effectors=tuple(replace(e, shape=None) for e in planar_arm(2).effectors))
    assert solve(arm_scene(bare, [], (0.0, 0.0), (0.4, 0.2), (0.5, 0.0))).feasible


def test_a_phase_without_motion_stays() -> None:
    result = solve(arm_scene(planar_arm(2), [], (0.2, 0.1), (0.2, 0.1), (0.5, 0.0)))
    assert result.feasible
    assert np.ptp(result.paths[0].modules["arm"], axis=0).max() == 0.0
    assert np.ptp(result.paths[1].modules["arm"], axis=0).max() > 0.2


def test_a_prismatic_joint_slides() -> None:
    result = solve(arm_scene(planar_arm(2, prismatic=True), [], (0.0, -0.1), (0.4, 0.2)))
    assert result.feasible
    assert result.paths[0].modules["arm"][-1, 7:] == pytest.approx([0.4, 0.2])


def random_boxes(random: np.random.Generator) -> list[Body]:
    found = []
    for k in range(3):
        angle, away = random.uniform(-3.0, 3.0), random.uniform(0.25, 1.0)
        x, y = random.uniform(0.05, 0.4, 2).tolist()
        found.append(box(f"box[{k}]", (x, y, 0.3), (away * math.cos(angle), away * math.sin(angle), 0.0)))
    return found


def test_accepted_paths_in_random_worlds_are_clear() -> None:
    accepted = 0
    for seed in range(24):
        random = np.random.default_rng(seed)
        arm, bodies = planar_arm(3, 0.33), random_boxes(random)
        scene = arm_scene(arm, bodies, random.uniform(-2, 2, 3).tolist(), random.uniform(-2, 2, 3).tolist())
        result = solve(scene, seed)
        if result.feasible:
            accepted += 1
            assert penetration(scene[0], result) < -1e-3
    assert accepted >= 4


def test_same_seed_same_path() -> None:
    wall = box("wall", (0.5, 0.06, 0.3), (0.85, 0.0, 0.0))
    scene = arm_scene(planar_arm(3, 0.33), [wall], (0.7, -0.2, 0.1), (-0.7, 0.2, -0.1))
    one, two = solve(scene, 3), solve(scene, 3)
    assert np.array_equal(one.paths[0].modules["arm"], two.paths[0].modules["arm"]) and one.cost == two.cost


def test_polish_never_costs_more() -> None:
    wall = box("wall", (0.5, 0.06, 0.3), (0.85, 0.0, 0.0))
    scene = arm_scene(planar_arm(3, 0.33), [wall], (0.7, -0.2, 0.1), (-0.7, 0.2, -0.1))
    first = solve(scene)
    better = polish(scene[0], first, SETTINGS, Seed(0), Budget(20.0))
    assert better.feasible and better.cost <= first.cost
    assert penetration(scene[0], better) <= 0.0


def test_a_spent_budget_ends_the_bound() -> None:
    with pytest.raises(OutOfTime):
        solve_sequence_path(*arm_scene(planar_arm(2), [], (0.0, 0.0), (0.3, 0.2)), SETTINGS, Seed(0), Budget(0.0))


def test_two_feet_on_the_ground_close_the_chain() -> None:
    """Two joints between two fixed feet cannot move at all."""
    skeleton, configurations = arm_scene(planar_arm(2), [], (0.0, 0.0), (0.3, 0.2))
    both = skeleton.phases[0].mode | {("stable", "foot", "arm.B")}
    closed = Skeleton(skeleton.problem, (Phase(Action("move", ()), both, frozenset()),), both)
    with pytest.raises(UnsupportedPhase) as caught:
        phase_tree(closed.problem, 0, closed.phases[0], configurations[0], configurations[1])
    assert caught.value.reason is Reason.CLOSED and caught.value.names == ("arm",)
    still = [configurations[0], configurations[0].copy()]
    assert solve_sequence_path(closed, still, SETTINGS, Seed(0), Budget(10.0)).feasible


def test_rows_hold_along_the_way() -> None:
    """The straight way stretches the arm to 1.2 m; a row that binds all the time forbids it."""
    skeleton, configurations = arm_scene(planar_arm(3), [], (0.9, -1.2, 0.4), (-0.9, 1.2, -0.4))
    span = call("norm", Arith("-", (call("position", X), call("position", Y))))
    near = motion("near", replace(switch(span, "<=", Number(1.1), 1), when="during"))
    problem = replace(skeleton.problem, motions={**MOTIONS, "near": near})
    mode = skeleton.phases[0].mode | {("near", "arm.B", "arm.A")}
    bound = Skeleton(problem, (Phase(Action("move", ()), mode, frozenset()),), mode)
    free = solve_sequence_path(skeleton, configurations, SETTINGS, Seed(0), Budget(20.0))
    blind = replace(SETTINGS, collisions=False)
    kept = solve_sequence_path(bound, configurations, blind, Seed(0), Budget(20.0))
    assert free.feasible and kept.feasible
    assert longest(free) > 1.15 and longest(kept) <= 1.102


def longest(result: BoundResult) -> float:
    """The farthest that the tip of the three-jointed arm gets from its foot."""
    angles = np.cumsum(result.paths[0].modules["arm"][:, 7:], axis=1)
    return float(np.hypot(0.4 * np.cos(angles).sum(axis=1), 0.4 * np.sin(angles).sum(axis=1)).max())


def test_a_still_robot_is_an_obstacle() -> None:
    """A second crawler stands where the straight way of the first leads."""
    bodies = [box("ground", (3.0, 3.0, 0.05), (0.0, 0.0, -0.025))]
    moving, still = crawler("m", 0.0, 0.0, 0.0, 0.0), crawler("s", 0.7, 0.0, 0.0, 0.0)
    mode: set[Fact] = {("stable", "ground", "m.A"), ("stable", "ground", "s.A")}
    problem = make_problem(bodies, [moving, still], mode, "still")
    configurations = [start_configuration(problem) for _ in range(2)]
    for configuration, yaw in zip(configurations, (0.8, -0.8), strict=True):
        configuration.modules["m"][7:] = [yaw, 1.1, 0.0, 0.0, 0.0, 0.3, 0.0]
        configuration.modules["s"][7:] = 0.0
    skeleton = Skeleton(problem, (Phase(Action("move", ()), frozenset(mode), frozenset()),), frozenset(mode))
    result = solve_sequence_path(skeleton, configurations, SETTINGS, Seed(0), Budget(20.0))
    assert result.feasible, result.violations
    path = result.paths[0].modules["m"]
    assert np.array_equal(result.paths[0].modules["s"], np.tile(configurations[0].modules["s"], (21, 1)))
    for row in path:
        for frame in link_frames(CRAWLER, row).values():
            assert math.hypot(frame[0, 3] - 0.7, frame[1, 3]) >= 0.08 or frame[2, 3] > 1.0


@pytest.mark.parametrize("make", [lambda: climb_alone(8), lambda: climb_together(2, n=8), lambda: pick_and_place(3)])
def test_the_benchmarks_between_solved_switches(make: object) -> None:
    assert callable(make)
    skeleton: Skeleton = make()
    sequence = solve_sequence(skeleton, SETTINGS, Seed(0), Budget(20.0))
    assert sequence.feasible
    result = solve_sequence_path(skeleton, sequence.configurations, SETTINGS, Seed(0), Budget(20.0))
    assert result.feasible, result.violations
    assert len(result.paths) == len(skeleton) and len(result.configurations) == len(skeleton) + 1
    for index, path in enumerate(result.paths):
        before, after = result.configurations[index], result.configurations[index + 1]
        for name, samples in path.modules.items():
            assert samples[0] == pytest.approx(before.modules[name], abs=1e-9)
            assert same_pose(samples[-1], after.modules[name]) and len(samples) == SETTINGS.slices + 1
            kind = skeleton.problem.world.modules[name].type
            for fact in skeleton.phases[index].mode:
                if fact[0] == "stable" and fact[1] in skeleton.problem.world.bodies and fact[2].startswith(name + "."):
                    joint = kind.effector(fact[2].rpartition(".")[2]).joint
                    feet = np.array([link_frames(kind, row)[joint][:3, 3] for row in samples])
                    assert np.ptp(feet, axis=0).max() < 1e-9 or joint >= 0
        for name, samples in path.bodies.items():
            assert same_pose(samples[-1], after.bodies[name])
            assert same_pose(samples[0], before.bodies[name])
        for name, given in sequence.configurations[index + 1].modules.items():
            assert after.modules[name][:3] == pytest.approx(given[:3], abs=1e-4)


def same_pose(one: np.ndarray, two: np.ndarray) -> bool:
    """Equal poses and joint values, up to the sign of the quaternion."""
    sign = 1.0 if one[3:7] @ two[3:7] > 0 else -1.0
    turned = np.concatenate([one[:3], sign * one[3:7], one[7:]])
    return bool(np.abs(turned - two).max() < 1e-9)
