"""Loads that several feet share: planner and verifier, by different programs and solvers."""

import numpy as np
import pytest
from scipy.optimize import linprog

from tamplang.compiler import ir
from tamplang.compiler.physics.frames import poses
from tamplang.compiler.physics.least_ratio import least_ratios
from tamplang.compiler.physics.statics import loads
from tamplang.compiler.physics.strength_rows import StrengthRows
from tamplang.compiler.physics.structure import structure
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.motion.keyframes.bearing_rows import bearing_groups
from tamplang.runtime.planner.motion.nlp.unknowns import UnknownsLayout
from tamplang.runtime.planner.plan_assembly import module_record
from tamplang.runtime.planner.statics.settings import STATICS
from tamplang.runtime.skeleton import start_configuration
from tamplang.runtime.verify.geometry import Frames, frames
from tamplang.runtime.verify.kept_poses import kept
from tamplang.runtime.verify.kinematics import Kinematics
from tamplang.runtime.verify.statics import node_loads, wrenches_of
from tamplang.runtime.verify.strengths import Joined, joined, judge

TEXT = """import std.rules

module arch {{
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 350 g holds pad(force {pull}, moment {moment})
    joint j1: revolute(y) in -2 rad .. 2 rad torque 40 N m mass 0.5 kg
    link 0.5 m: capsule(0.04 m) mass 2 kg
    joint j2: revolute(y) in -3 rad .. 3 rad torque 40 N m mass 0.5 kg
    link 0.5 m: capsule(0.04 m) mass 2 kg
    joint j3: revolute(y) in -3 rad .. 3 rad torque 40 N m mass 0.5 kg
    effector B: gripper sphere(0.05 m) mass 350 g holds pad(force {pull}, moment {moment})
    fact (linked A B)
}}

task t() {{
    base ground: box(4 m, 4 m, 5 cm) at (0, 0, 0)
    base other: box(4 m, 4 m, 5 cm) at (0, 0, -3 m)
    arch c: A on ground
    goal (on ground c.B)
}}
"""
MODE = frozenset({
    ("stable", "ground", "c.A"), ("stand", "c.A", "ground"), ("stable", "other", "c.B"), ("stand", "c.B", "other"),
})  # fmt: skip
COUNT = 6


Wrenches = dict[Joined, tuple[np.ndarray, np.ndarray]]


def both(pull: str, moment: str) -> tuple[np.ndarray, np.ndarray, float]:
    """The worst ratios `(T,)` of planner and verifier in random postures, and what of the weight is out of balance."""
    problem, mine, nodes, edges = in_random_postures(pull, moment)
    found = wrenches_of(problem, edges, nodes, node_loads(problem, nodes, None), 1.5)
    return mine, worst_ratios(problem, nodes, found), off_balance(problem, found)


def in_random_postures(
    pull: str, moment: str
) -> tuple[ir.Problem, np.ndarray, dict[tuple[str, int], Frames], tuple[Joined, ...]]:
    """A problem, the planner's worst ratios `(T,)`, and of the verifier where all is and what is joined."""
    problem, _ = compile_text(TEXT.format(pull=pull, moment=moment))
    module, random = problem.world.modules["c"], np.random.default_rng(0)
    rows = np.array([[*module.pose, *random.uniform(-1.0, 1.0, 3)] for _ in range(COUNT)])
    bodies = {n: np.repeat(np.array([b.pose]), COUNT, 0) for n, b in problem.world.bodies.items()}
    assert len(structure(problem, MODE).loops) == 1
    mine = np.max([load.ratio for load in loads(problem, MODE, poses(problem, {"c": rows}, bodies), 1.5)], axis=0)
    placed = Kinematics(module_record(module)).joint_frames(rows[:, :7], rows[:, 7:])
    nodes = {("c", joint): frame for joint, frame in placed.items()}
    nodes |= {(n, -1): frames(b) for n, b in bodies.items()}
    edges = joined(problem, MODE, kept(problem, MODE))
    return problem, mine, nodes, edges


def worst_ratios(problem: ir.Problem, nodes: dict[tuple[str, int], Frames], found: Wrenches) -> np.ndarray:
    figures = [f for edge, wrench in found.items() for f in judge(problem, edge, nodes, *wrench, 1.5)]
    return np.max([figure.amounts for figure in figures], axis=0)


def off_balance(problem: ir.Problem, found: Wrenches) -> float:
    """Newtons by which what both feet bear differs from the weight."""
    feet = [force for edge, (force, _) in found.items() if not edge.joint_of]
    assert len(feet) == 2
    weight = np.array([0.0, 0.0, -9.81 * (2 * 0.35 + 3 * 0.5 + 2 * 2.0)])
    return float(np.abs(sum(feet) - weight).max())


def test_planner_and_verifier_find_the_same_least_ratio() -> None:
    mine, theirs, off = both("1 kN", "120 N m")
    assert off < 1e-6
    assert np.all(theirs <= 1.001 * mine) and np.all(theirs >= 0.9 * mine)


def test_the_verifier_takes_a_told_share_that_keeps_strengths_and_no_other() -> None:
    problem, _, nodes, edges = in_random_postures("1 kN", "120 N m")
    weights = node_loads(problem, nodes, None)
    best = wrenches_of(problem, edges, nodes, weights, 1.5)
    squeeze = np.array([3.0, 0.0, 0.0])
    strong = np.where(np.arange(COUNT) < 3, 1.0, 1e3)[:, None] * squeeze
    feet = [e for e in best if not e.joint_of]
    assert all(e.near == ("", -1) for e in feet)
    told = {e: (best[e][0] + sign * strong, best[e][1]) for e, sign in zip(feet, (1.0, -1.0), strict=True)}
    told[feet[0]] = told[feet[0]][0] + 0.01, told[feet[0]][1]
    found = wrenches_of(problem, edges, nodes, weights, 1.5, told)
    assert off_balance(problem, found) < 1e-6
    assert np.all(worst_ratios(problem, nodes, found) <= 1.0)
    for edge in feet:
        assert np.abs(found[edge][0] - told[edge][0])[:3].max() < 0.02
        assert found[edge][0][3:] == pytest.approx(best[edge][0][3:])
    without = wrenches_of(problem, edges, nodes, weights, 1.5, {feet[0]: told[feet[0]]})
    assert without[feet[0]][0] == pytest.approx(best[feet[0]][0])


def test_two_feet_bear_what_one_could_not() -> None:
    problem, _ = compile_text(TEXT.format(pull="1 kN", moment="6 N m"))
    rows = np.array([[*problem.world.modules["c"].pose, 1.4, 0.1, 0.0]])
    at = poses(problem, {"c": rows}, {n: np.array([b.pose]) for n, b in problem.world.bodies.items()})
    alone = frozenset(f for f in MODE if "c.A" in f)
    one, two = (max(float(x.ratio[0]) for x in loads(problem, mode, at)) for mode in (alone, MODE))
    assert one > 2.0 and two < 0.7 * one
    assert two == pytest.approx(max(float(x.ratio[0]) for x in loads(problem, MODE, at)), rel=1e-6)


def test_rows_of_closed_loops_change_as_the_best_share_does() -> None:
    problem, _ = compile_text(TEXT.format(pull="100 N", moment="30 N m"))
    start = start_configuration(problem)
    layout = UnknownsLayout(problem.world, start)
    for _ in range(2):
        layout.add_slice(["c"])
    (group,) = bearing_groups(problem, layout, [(t, t - 1, MODE) for t in (1, 2)])
    assert group.shape == (2, 1)
    random = np.random.default_rng(1)
    x = layout.pack(dict.fromkeys(range(3), start))
    x += np.tile([*[0.0] * 7, 1.0, 1.0, 1.0], 2) * random.normal(0, 0.5, 20)
    z = np.concatenate([layout.constants, x])
    slopes, places = group.jacobians(z, slice(None))
    for column in range(7, 10):
        step = np.zeros(len(z))
        step[places[:, column]] = 1e-5
        found = (group.residuals(z + step) - group.residuals(z - step)) / 2e-5
        assert found == pytest.approx(slopes[:, :, column], rel=1e-3, abs=1e-4)
    at = poses(problem, {"c": np.stack([layout.unpack(x, t).modules["c"] for t in (1, 2)])},
               {n: np.repeat(np.array([b.pose]), 2, 0) for n, b in problem.world.bodies.items()})  # fmt: skip
    worst = np.max([load.ratio for load in loads(problem, MODE, at, 1.5 / STATICS.room)], axis=0)
    assert np.all(worst <= group.residuals(z)[:, 0] + 1.0 + 1e-6)
    assert np.all(group.residuals(z)[:, 0] + 1.0 <= 1.09 * worst)


def rows(random: np.random.Generator, kind: str, samples: int = 4) -> StrengthRows:
    """Rows that a structure could have: those of a loop in many directions, all of one edge, rows twice, rows of what
    must not lift; samples that are near each other."""
    edges, loops, count = 4, int(random.integers(1, 4)), int(random.integers(8, 60))
    first, last = (random.normal(size=(count, 6)) for _ in range(2))
    functionals = np.stack([first + (last - first) * 0.05 * t for t in range(samples)])
    if kind == "twice":
        functionals[:, count // 2 :] = functionals[:, : count - count // 2]
    if kind == "one way":
        functionals[:, :, 1:] = 0.0
    signs = random.choice([-1.0, 0.0, 1.0], size=(edges, loops))
    grows = np.ones(count, dtype=bool) if kind != "rests" else random.uniform(size=count) < 0.7
    owners = random.integers(0, edges, count)
    if kind == "twice":
        owners[count // 2 :] = owners[: count - count // 2]
    return StrengthRows(
        functionals, owners, random.uniform(size=count) < 0.6, grows,
        np.repeat(random.normal(size=(1, edges, 6)), samples, 0), signs, np.zeros((samples, 3)),
    )  # fmt: skip


def least_by_highs(given: StrengthRows, sample: int) -> float:
    """The least worst ratio, with 100 times what lifts, by another method."""
    slopes, hung = given.slopes()[sample], given.told(np.zeros((len(given.hung), given.unknowns)))[sample]
    both = given.both
    a = np.concatenate([slopes, -slopes[both]])
    b = np.concatenate([-hung, hung[both]])
    own = np.concatenate([given.grows, given.grows[both]])
    a = np.concatenate([a, -1.0 * own[:, None], -1.0 * ~own[:, None]], axis=1)
    free: list[tuple[float | None, float | None]] = [(None, None)] * given.unknowns
    found = linprog([*[0.0] * given.unknowns, 1.0, 100.0], a, b, bounds=[*free, (0, None), (0, None)])
    assert found.status == 0
    return float(found.fun)


@pytest.mark.parametrize("kind", ["any", "twice", "one way", "rests"])
def test_the_least_ratio_is_that_of_another_method_on_degenerate_programs_too(kind: str) -> None:
    random = np.random.default_rng(7)
    for _ in range(12):
        given = rows(random, kind)
        for sample, share in enumerate(least_ratios(given)):
            told, eased = given.told(np.repeat(share.taken[None], 4, 0))[sample], share.ratio
            assert share.ratio == pytest.approx(least_by_highs(given, sample), rel=1e-3, abs=2e-3)
            if kind != "rests":
                assert np.all(told <= eased + 1e-8) and np.all(told[given.both] >= -eased - 1e-8)
            assert np.all(share.weights[~given.both] >= 0.0)


def test_the_share_is_the_same_far_from_the_origin() -> None:
    problem, _ = compile_text(TEXT.format(pull="1 kN", moment="6 N m"))
    rows = np.array([[*problem.world.modules["c"].pose, 1.4, 0.1, 0.0]])
    found = []
    for far in (0.0, 300.0):
        moved = rows + np.array([far, -far, 0.0, *[0.0] * 7])
        at = poses(problem, {"c": moved}, {n: np.array([b.pose]) for n, b in problem.world.bodies.items()})
        found.append(max(float(x.ratio[0]) for x in loads(problem, MODE, at)))
    assert found[1] == pytest.approx(found[0], rel=1e-6)
