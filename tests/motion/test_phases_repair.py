"""P_seqPath between slices and next to contacts: what is repaired, what it keeps clear of, and what polishing saves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamplang.compiler.ir import IDENTITY, Action, Body, Effector, Joint, Link, Module, ModuleType, Shape
from tamplang.compiler.motion.collision import PhaseContacts, contacts, taper
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.phases import solve_sequence_path
from tamplang.runtime.planner.motion.phases.attempts import (
    PhaseGroup,
    attempt,
    drawn_in,
    homeward,
    polish_groups,
    start_group,
    straight,
)
from tamplang.runtime.planner.motion.phases.contact_margins import (
    BOTH,
    END,
    FULL,
    NEVER,
    START,
    kind_of,
    share_table,
)
from tamplang.runtime.planner.motion.phases.joint_forest import phase_tree
from tamplang.runtime.planner.motion.phases.penalty import penalty
from tamplang.runtime.planner.motion.phases.phase_batch import Batch
from tamplang.runtime.planner.motion.phases.phase_geometry import make_parts
from tamplang.runtime.planner.motion.phases.proximity import close
from tamplang.runtime.planner.motion.phases.smoothing import Schedule, path_cost, smooth_paths
from tamplang.runtime.planner.motion.phases.swept_check import sweep
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Configuration, Phase, Skeleton, start_configuration

from .fixtures import box, make_problem, pick_and_place
from .test_phases import arm_scene, planar_arm

SETTINGS = MotionSettings()


def cart_type() -> ModuleType:
    """A ball of 5 cm that slides in the plane; effector A stays, B is the ball."""
    joints = tuple(
        Joint(f"j{i + 1}", "prismatic", i - 1, IDENTITY, axis, -9.0, 9.0, 0.0, 2.0)
        for i, axis in enumerate(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    )
    ball = Shape("sphere", (0.05,))
    return ModuleType("arm", joints, (Effector("A", "gripper", -1, IDENTITY, None),), (Link(1, IDENTITY, ball),))


def cart_scene(bodies: list[Body], *ends: tuple[float, float]) -> tuple[Skeleton, list[Configuration]]:
    """A cart that slides from one place to the next."""
    foot = box("foot", (0.05, 0.05, 0.05), (0.0, 0.0, -0.5))
    mode = frozenset({("stable", "foot", "arm.A")})
    problem = make_problem([foot, *bodies], [Module("arm", cart_type(), IDENTITY, ends[0])], set(mode), "cart")
    configurations = [start_configuration(problem) for _ in ends]
    for configuration, values in zip(configurations, ends, strict=True):
        configuration.modules["arm"][7:] = values
    phases = tuple(Phase(Action("move", ()), mode, frozenset()) for _ in ends[1:])
    return Skeleton(problem, phases, mode), configurations


def group_of(skeleton: Skeleton, configurations: list[Configuration], phases: list[int]) -> PhaseGroup:
    world, pairs = skeleton.problem.world, [(configurations[p], configurations[p + 1]) for p in phases]
    trees = [
        phase_tree(skeleton.problem, p, skeleton.phases[p], *ends) for p, ends in zip(phases, pairs, strict=True)
    ]
    parts = [make_parts(tree, world) for tree in trees]
    return start_group(Batch(parts, pairs, world, contacts(skeleton), SETTINGS.slices, SETTINGS.margin))


def test_a_post_between_two_slices_is_passed_after_repair() -> None:
    """The ball makes 0.4 m per slice half-way, and the post is in its way where no slice is."""
    scene = cart_scene([box("post", (0.02, 0.02, 0.3), (0.2, 0.01, 0.0))], (-2.8, 0.0), (2.8, 0.0))
    group = group_of(*scene, [0])
    inner, _ = smooth_paths(group.batch, straight(group.batch), Schedule(), Budget(20.0))
    path = group.batch.with_ends(inner)
    assert not any(len(found.row) for found in close(group.batch.coarse, path, SETTINGS.margin))
    assert not sweep(group.batch, path).clean[0]
    attempt(group, np.arange(1), straight(group.batch), Schedule(), Budget(20.0))
    assert group.solved[0] and group.detour[0]
    away = np.linalg.norm(np.maximum(np.abs(dense(group.paths[0]) - [0.2, 0.01]) - 0.01, 0.0), axis=1) - 0.05
    assert 1e-3 <= away.min() < 0.06


def test_what_is_passed_between_two_looks_is_looked_at_closer() -> None:
    """At 40 mm per look the ball is clear of a bead at both looks around it, and 2 mm deep, or 0.5 mm, half-way."""
    clean = []
    for deep in (2e-3, 5e-4):
        plain = group_of(*cart_scene([], (-2.8, 0.0), (2.8, 0.0)), [0])
        looks = (plain.batch.stored @ plain.paths)[0, :, 0]
        middle = float(looks[100:102].mean())
        bead = Body("bead", "object", Shape("sphere", (0.001,)), (middle, 0.051 - deep, 0.0, 0.0, 0.0, 0.0, 1.0), False)
        group = group_of(*cart_scene([bead], (-2.8, 0.0), (2.8, 0.0)), [0])
        ball = np.abs(looks - middle).min()
        assert np.hypot(ball, 0.051 - deep) > 0.051
        clean.append(bool(sweep(group.batch, group.paths).clean[0]))
    assert clean == [False, True]


def dense(path: np.ndarray) -> np.ndarray:
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(np.arange(len(path)), path, bc_type="clamped")(np.linspace(0, len(path) - 1, 2001)))


def test_the_first_bent_start_goes_towards_home() -> None:
    scene = cart_scene([], (-2.0, 1.0), (2.0, 1.0))
    batch = group_of(*scene, [0]).batch
    assert homeward(batch, 1.0)[0, 9] == pytest.approx([0.0, 0.0])
    assert homeward(batch, 0.5)[0, 9] == pytest.approx([0.0, 0.5])


def test_a_way_that_winds_is_straightened_but_stays_clear() -> None:
    post = Body("post", "object", Shape("box", (0.1, 0.4, 0.4)), (0.5, 0.1, 0.0, 0.0, 0.0, 0.0, 1.0), False)
    for bodies, most in (([], 1.3), ([post], 3.0)):
        group = group_of(*cart_scene(bodies, (0.0, 0.0), (1.0, 0.0)), [0])
        line = straight(group.batch)
        least = group.cost[0]
        wave = np.sin(np.pi * np.arange(1, group.batch.slices) / group.batch.slices)[None, :, None]
        crowd = 0.5 * np.sin(3.0 * np.pi * np.arange(1, group.batch.slices) / group.batch.slices)[None, :, None]
        winding = group.batch.with_ends(line - 0.9 * wave * [0.0, 1.0] + crowd * [1.0, 0.0])
        assert sweep(group.batch, winding).clean[0]
        group.paths, group.solved[:] = winding.copy(), True
        group.cost = path_cost(group.batch, winding)
        polish_groups([group], Seed(0), Budget(20.0))
        assert sweep(group.batch, group.paths).clean[0]
        assert group.cost[0] < most * least < path_cost(group.batch, winding)[0]


def test_a_path_that_runs_from_limit_to_limit_is_drawn_in_until_its_spline_keeps_them() -> None:
    skeleton, configurations = cart_scene([], (0.0, 0.0), (0.01, 0.0))
    batch = group_of(skeleton, configurations, [0]).batch
    batch.joints.lower[:], batch.joints.upper[:] = 0.0, 0.02
    line = batch.with_ends(straight(batch))
    inner = np.zeros((1, batch.slices - 1, 2))
    inner[:, batch.slices // 3 :, 0] = 0.02
    paths = batch.with_ends(inner)
    assert not sweep(batch, paths).clean[0]
    drawn = drawn_in(batch, paths)
    assert sweep(batch, drawn).clean[0]
    assert np.abs(drawn - line).max() > 0.1 * np.abs(paths - line).max()
    assert np.array_equal(drawn_in(batch, line), line)


def test_sliding_joints_make_no_jumps() -> None:
    """9 m in 20 slices are more than 0.5 m per slice."""
    far = group_of(*cart_scene([], (-4.5, 0.0), (4.5, 0.0)), [0])
    checked = sweep(far.batch, far.paths)
    assert checked.step[0] > 0.0 and not checked.clean[0]
    result = solve_sequence_path(*cart_scene([], (-4.5, 0.0), (4.5, 0.0)), SETTINGS, Seed(0), Budget(20.0))
    assert result.feasible and np.abs(np.diff(result.paths[0].modules["arm"][:, 7:], axis=0)).max() <= 0.5
    near = group_of(*cart_scene([], (-2.0, 0.0), (2.0, 0.0)), [0])
    assert sweep(near.batch, near.paths).clean[0]


def test_kinds_of_pairs_fade_as_contacts_do() -> None:
    one, two, three, four = (("a", name) for name in ("b", "c", "d", "e"))
    contact = PhaseContacts(frozenset({one}), frozenset({two, four}), frozenset({three, four}))
    assert [kind_of(contact, name, "a") for name in "bcdef"] == [NEVER, START, END, BOTH, FULL]
    times = np.linspace(0.0, 20.0, 41)
    table = share_table(times, 20)
    for objects, kind in ((two, START), (three, END), (four, BOTH), (("a", "f"), FULL)):
        assert np.array_equal(table[kind], taper(contact, objects, times, 20))
    assert taper(contact, one, times, 20) is None and np.isneginf(table[NEVER]).all()


def test_repair_sees_the_true_shapes_of_what_is_put_down() -> None:
    """The straight way drags a cube over the table. Without the spheres that the optimiser goes by, only closely it is
    seen, and seen to be lifted by what its joints do."""
    skeleton = pick_and_place(2)
    sequence = solve_sequence(skeleton, SETTINGS, Seed(0), Budget(20.0))
    batch = group_of(skeleton, sequence.configurations, [1, 3]).batch
    random = np.random.default_rng(0)
    inner = straight(batch)
    inner += 1e-3 * random.normal(size=inner.shape)  # flat on flat is a kink
    found = []
    for seen in (batch.take(np.arange(len(batch))), batch.looking(2)):
        seen.coarse.ignore_collisions()
        found.append(penalty(seen, inner, 1e3))
        step = 1e-8 * random.normal(size=inner.shape)
        change = penalty(seen, inner + step, 1e3).value - penalty(seen, inner - step, 1e3).value
        slope = 2.0 * (found[-1].gradient * step).sum(axis=(1, 2))
        assert change == pytest.approx(slope, rel=1e-2, abs=1e-9)
    assert (found[1].value > found[0].value).any()


def test_polishing_saves_cost_and_says_how_much() -> None:
    scene = cart_scene([box("post", (0.02, 0.02, 0.3), (0.2, 0.01, 0.0))], (-2.8, 0.0), (2.8, 0.0))
    raw = solve_sequence_path(*scene, replace(SETTINGS, polish=False), Seed(0), Budget(20.0))
    fine = solve_sequence_path(*scene, SETTINGS, Seed(0), Budget(20.0))
    assert raw.feasible and fine.feasible and raw.cost_before is None
    assert fine.cost_before == raw.cost and fine.cost < 0.99 * raw.cost


def test_hard_phases_fail_soon_when_switches_can_be_drawn_anew() -> None:
    walls = [box("east", (1.0, 0.06, 0.3), (0.62, 0.0, 0.0)), box("west", (1.0, 0.06, 0.3), (-0.62, 0.0, 0.0))]
    scene = arm_scene(planar_arm(2, 0.4), walls, (0.8, 0.2), (-0.8, -0.2))
    soon = solve_sequence_path(*scene, SETTINGS, Seed(0), Budget(100.0), thorough=False)
    late = solve_sequence_path(*scene, SETTINGS, Seed(0), Budget(100.0))
    assert not soon.feasible and not late.feasible and soon.iterations < late.iterations


def test_a_dearer_path_does_not_replace_a_cheaper_one() -> None:
    group = group_of(*cart_scene([], (-1.0, 0.0), (1.0, 0.0)), [0])
    attempt(group, np.arange(1), straight(group.batch), Schedule(), Budget(20.0))
    assert group.solved.all()
    paths, cost = group.paths.copy(), group.cost.copy()
    attempt(group, np.arange(1), homeward(group.batch, 0.0) + 0.3, Schedule(iterations=0), Budget(20.0))
    assert np.array_equal(group.paths, paths) and np.array_equal(group.cost, cost)
