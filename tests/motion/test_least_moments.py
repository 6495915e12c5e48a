"""The least moments that a reach asks for: never more than any posture bears, and enough to refuse what none does."""

import math
from itertools import pairwise

import numpy as np
import pytest

from tamplang.compiler import ir
from tamplang.compiler.physics.frames import poses
from tamplang.compiler.physics.statics import met, wrenches
from tamplang.compiler.physics.structure import structure
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.statics.least_moments import Region, Site, least_moments
from tamplang.runtime.planner.statics.nearness import AS_PLACED, radius_of

TEXT = """import std.rules

module arm {{
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 350 g holds pad(force 1 kN, moment {foot})
        holds dock(force 1 kN, shear 1 kN, moment 80 N m, twist 50 N m)
    joint j1: revolute(z) in -3 rad .. 3 rad torque 50 N m bearing 90 N m mass 0.5 kg
    joint j2: revolute(y) in -2 rad .. 2 rad home 0.3 rad torque 50 N m bearing 90 N m mass 0.5 kg
    link 0.4 m: capsule(0.04 m) mass 1 kg
    joint j3: revolute(y) in -2.5 rad .. 2.5 rad home 0.3 rad torque 50 N m bearing 90 N m mass 0.5 kg
    link 0.3 m: capsule(0.04 m) mass 500 g
    joint j4: prismatic(z) in 0 m .. 0.1 m home 0.05 m force 500 N bearing 90 N m mass 0.5 kg
    link 0.1 m: capsule(0.03 m) mass 300 g
    effector B: gripper sphere(0.05 m) mass 350 g holds pad(force 1 kN, moment {foot})
        holds dock(force 1 kN, shear 1 kN, moment 80 N m, twist 50 N m)
    fact (linked A B)
}}

task t(far: length = {far}) {{
    base ground: box(8 m, 8 m, 5 cm) at (0, 0, 0)
    object shelf: box(10 cm, 10 cm, 5 cm) at (far, 0, 0.5 m)
    object item: sphere(3 cm) on shelf mass 100 g
    fact (grippable item)
    arm c: A on ground at (0, 0)
    arm d: A on ground at (0, 3 m)
    arm e: A on ground at (0, -3 m)
    goal (held item)
    options {{ physics = statics, time = 20 s }}
}}
"""


def text(foot: str = "200 N m", far: str = "0.7 m") -> str:
    return TEXT.format(foot=foot, far=far)


def chain(problem: ir.Problem, random: np.random.Generator, count: int, bent: float) -> dict[str, np.ndarray]:
    """`count` arms, each docked to the one before: at 10 cm from it, in any direction. Where they bend
    little the first lies down."""
    found = {}
    for number, name in enumerate(list("cde")[:count]):
        module = problem.world.modules[name]
        values = np.array([*random.uniform(-bent, bent, 3), random.uniform(0.0, 0.1)])
        if bent < 1.0 and not number:
            values[1] = 1.5
        row = np.array([[*module.pose, *values]])
        if number:
            before = list("cde")[number - 1]
            at = poses(problem, found, {})
            place, turn = at.places[before, 3][0], at.turns[before, 3][0]
            end = np.asarray(problem.world.modules[before].type.effector("B").placement[:3])
            row[0, :3] = place + turn @ end + 0.1 * turn[:, 2]
            spin = random.normal(size=4)
            row[0, 3:7] = spin / np.linalg.norm(spin)
        found[name] = row
    return found


@pytest.mark.parametrize("count", [1, 2, 3])
def test_no_posture_bears_less_than_the_least_moment(count: int) -> None:
    problem, _ = compile_text(text())
    random, told, tight = np.random.default_rng(count), 0, 0.0
    names = list("cde")[:count]
    docks = [(f"{a}.B", f"{b}.A") for a, b in pairwise(names)]
    mode = frozenset({("stable", "ground", "c.A"), ("stand", "c.A", "ground")} | {("stable", *d) for d in docks})
    joined = frozenset({(frozenset({"ground", "c.A"}), AS_PLACED)} | {(frozenset(d), 0.1) for d in docks})
    built = structure(problem, mode)
    end = problem.world.modules[names[-1]].type.effector("B")
    site = Site((names[-1], end.joint), (end.placement[0], end.placement[1], end.placement[2]))
    for sample in range(80):
        rows = chain(problem, random, count, 0.1 if sample % 2 else 1.5)
        at = poses(problem, rows, {n: np.array([b.pose]) for n, b in problem.world.bodies.items()})
        tip = at.places[site.node][0] + at.turns[site.node][0] @ np.asarray(site.point)
        region = Region(site, ((float(tip[0]), float(tip[1])),), 0.0)
        borne = dict(zip(built.all, wrenches(problem, built, at, 1.0), strict=True))
        for edge, _, least, _ in least_moments(problem, mode, joined, region):
            force, moment = borne[edge]
            if edge.is_joint:
                place = at.places[edge.names[0], edge.joint]
                actual = float(np.linalg.norm(moment - np.cross(place, force)))
            else:
                actual = float(np.linalg.norm(met(problem, edge, at, force, moment)[1]))
            assert least <= actual + 1e-9
            told, tight = told + 1, max(tight, least / actual)
    assert told > 20 and tight > 0.5


def test_what_no_posture_bears_is_refused_before_any_posture_is_asked_for() -> None:
    def solved(foot: str) -> tuple[bool, dict[str, str]]:
        lines = text(foot, "0.85 m").splitlines()
        told = "\n".join(line for line in lines if "arm d" not in line and "arm e" not in line)
        outcome = solve(compile_text(told)[0], SolveOptions(time=20.0))
        return bool(outcome.plans), {r.actions[-1]: f"{r.bound}: {r.reason}" for r in outcome.statistics.refusals}

    assert solved("200 N m")[0]
    found, refused = solved("9.5 N m")
    (grasp,) = (told for action, told in refused.items() if action.startswith("grasp"))
    assert not found and grasp.startswith("statics") and "ground and c.A" in grasp and "in any posture" in grasp


def test_an_end_comes_as_far_from_its_frame_as_its_farthest_part() -> None:
    text = """type tool < effector
    module fork {
        effector T: tool union(box(2 cm, 2 cm, 2 cm) at (0, 0, 0), box(2 cm, 2 cm, 2 cm) at (20 cm, 0, 0))
        joint j: revolute(z) in -1 rad .. 1 rad
    }
    task t { fork f: at (0, 0, 0) goal 1 < 2 }"""
    assert radius_of(compile_text(text, "fork.tamp")[0], "f.T") == pytest.approx(math.hypot(0.21, 0.01, 0.01))
