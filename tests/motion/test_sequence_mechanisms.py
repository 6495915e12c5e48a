"""P_seq and P_path beyond the crawler: sliding joints, rows within one module, `during` rows, two hands on a bar."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tamplang.compiler.ir import (
    Action,
    Effector,
    Fact,
    Joint,
    Module,
    ModuleType,
    MotionPredicate,
    Number,
    Problem,
    Row,
    Shape,
)
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.initial_guesses import effector_pose
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.path.whole_path import solve_path
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Phase, Skeleton

from .fixtures import X, Y, box, call, climb_together, crawler, make_problem, motion, switch

OPEN = MotionSettings(collisions=False, slices=10)
ORIGIN = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def gantry_type() -> ModuleType:
    """Three sliding joints x, y, z that carry a hand H; foot F is the module frame."""
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    joints = tuple(
        Joint(name, "prismatic", i - 1, ORIGIN, axis, -1.0, 1.0, 0.0, 1.0)
        for i, (name, axis) in enumerate(zip("xyz", axes, strict=True))
    )
    foot = Effector("F", "gripper", -1, (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), Shape("sphere", (0.05,)))
    hand = Effector("H", "gripper", 2, (0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0), Shape("sphere", (0.05,)))
    return ModuleType("gantry", joints, (foot, hand), ())


def with_motions(problem: Problem, *extra: MotionPredicate) -> Problem:
    return replace(problem, motions=problem.motions | {m.name: m for m in extra})


def gantry(at: tuple[float, float, float], added: set[Fact], *extra: MotionPredicate) -> Skeleton:
    module = Module("g", gantry_type(), (0.0, 0.0, 0.075, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    bodies = [box("floor", (2.0, 2.0, 0.05), (0.0, 0.0, 0.0)), box("thing", (0.1, 0.1, 0.1), at, movable=True)]
    init: set[Fact] = {("stable", "floor", "g.F")}
    problem = with_motions(make_problem(bodies, [module], init, "gantry"), *extra)
    mode = frozenset(init)
    return Skeleton(problem, (Phase(Action("reach", ()), mode, frozenset(added)),), mode | added)


def test_sliding_joints_reach() -> None:
    skeleton = gantry((0.5, -0.4, 0.8), {("touch", "g.H", "thing")})
    result = solve_sequence(skeleton, OPEN, Seed(0), Budget(20.0))
    assert result.feasible
    slot = result.configurations[1].modules["g"]
    hand = effector_pose(skeleton.problem.world.modules["g"], "H", slot)
    outside = np.maximum(np.abs(np.array(hand[:3]) - [0.5, -0.4, 0.8]) - 0.05, 0.0)
    assert np.linalg.norm(outside) == pytest.approx(0.05, abs=1e-4)


def test_sliding_joints_have_ends() -> None:
    result = solve_sequence(gantry((2.5, 0.0, 0.8), {("touch", "g.H", "thing")}), OPEN, Seed(0), Budget(20.0))
    assert not result.feasible
    assert result.violations[0].amount > 0.1


def test_rows_between_two_effectors_of_one_module() -> None:
    spread = motion("spread", switch(call("gap", X, Y), "=", Number(0.7), 1))
    skeleton = gantry((0.0, 0.0, 5.0), {("spread", "g.H", "g.F")}, spread)
    result = solve_sequence(skeleton, OPEN, Seed(0), Budget(20.0))
    assert result.feasible
    module, slot = skeleton.problem.world.modules["g"], result.configurations[1].modules["g"]
    ends = [np.array(effector_pose(module, e, slot)[:3]) for e in "HF"]
    assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(0.8, abs=1e-4)


def low_hand() -> MotionPredicate:
    """Its first argument stays below 0.6 m, its second above the ground."""
    below = Row("during", call("top", X), "<=", Number(0.6), 1)
    return motion("low", below, Row("during", call("top", Y), ">=", Number(0), 1))


def test_during_rows_bind_along_the_path() -> None:
    """The hand must stay low from the start of the phase although the touch alone would let it rise."""
    skeleton = gantry((0.6, 0.0, 0.3), {("touch", "g.H", "thing")}, low_hand())
    phase = skeleton.phases[0]
    mode = phase.mode | {("low", "g.H", "thing")}
    skeleton = Skeleton(skeleton.problem, (replace(phase, mode=mode),), mode | phase.added)
    sequence = solve_sequence(skeleton, OPEN, Seed(0), Budget(20.0))
    assert sequence.feasible
    result = solve_path(skeleton, OPEN, Seed(0), Budget(20.0), sequence)
    assert result.feasible
    module = skeleton.problem.world.modules["g"]
    heights = [effector_pose(module, "H", slot)[2] + 0.05 for slot in result.paths[0].modules["g"][1:]]
    assert max(heights) <= 0.6 + 1e-3


def test_during_rows_refuse() -> None:
    skeleton = gantry((0.6, 0.0, 0.9), {("touch", "g.H", "thing")}, low_hand())
    phase = skeleton.phases[0]
    mode = phase.mode | {("low", "g.H", "thing")}
    result = solve_sequence(
        Skeleton(skeleton.problem, (replace(phase, mode=mode),), mode | phase.added), OPEN, Seed(0), Budget(20.0)
    )
    assert not result.feasible
    assert {v.names[0] for v in result.violations} & {"low", "touch"}


def test_two_robots_carry_one_thing() -> None:
    """Both hold the bar (a closed chain), then put it down at another place: no code knows of loops."""
    bodies = [
        box("ground", (4.0, 4.0, 0.05), (0.0, 0.0, 0.0)),
        box("shelf", (0.4, 1.0, 0.04), (0.35, 0.0, 0.5)),
        box("bar", (0.06, 0.8, 0.06), (0.5, 0.0, 0.6), movable=True),
    ]
    modules = [crawler("p", 0.0, -0.5, 0.025, 0.0), crawler("q", 0.0, 0.5, 0.025, 0.0)]
    feet: set[Fact] = {("stable", "ground", "p.A"), ("stable", "ground", "q.A")}
    problem = make_problem(bodies, modules, feet, "carry")
    held = frozenset((name, hand, "bar") for name in ("stable", "touch") for hand in ("p.B", "q.B"))
    laid = frozenset({("rest", "bar", "shelf"), ("stable", "shelf", "bar")})
    phases = (
        Phase(Action("take", ()), frozenset(feet), held),
        Phase(Action("lay", ()), frozenset(feet) | held, laid),
    )
    skeleton = Skeleton(problem, phases, frozenset(feet) | laid)
    sequence = solve_sequence(skeleton, OPEN, Seed(0), Budget(20.0))
    assert sequence.feasible
    assert sequence.configurations[2].bodies["bar"][2] == pytest.approx(0.55, abs=1e-4)
    result = solve_path(skeleton, OPEN, Seed(0), Budget(20.0), sequence)
    assert result.feasible
    track = result.paths[1]
    for name in "pq":
        hand = np.array([effector_pose(problem.world.modules[name], "B", s)[:3] for s in track.modules[name]])
        distance = np.linalg.norm(hand - track.bodies["bar"][:, :3], axis=1)
        assert np.ptp(distance) < 1e-4


def test_idle_robots_stay_where_they_are() -> None:
    skeleton = climb_together(1, n=4, grasp=False)
    idle = crawler("idle", -1.2, 0.6, 0.025)
    world = replace(skeleton.problem.world, modules=dict(skeleton.problem.world.modules) | {"idle": idle})
    objects = dict(skeleton.problem.objects) | {"idle": "crawler", "idle.A": "gripper", "idle.B": "gripper"}
    standing: frozenset[Fact] = frozenset({("stable", "ground", "idle.A"), ("stand", "idle.A", "ground")})
    phases = tuple(replace(p, mode=p.mode | standing) for p in skeleton.phases)
    problem = replace(skeleton.problem, world=world, objects=objects)
    result = solve_sequence(
        Skeleton(problem, phases, skeleton.final_mode | standing), MotionSettings(), Seed(0), Budget(20.0)
    )
    assert result.feasible
    for configuration in result.configurations:
        assert configuration.modules["idle"] == pytest.approx(np.array([*idle.pose, *idle.joints]))
