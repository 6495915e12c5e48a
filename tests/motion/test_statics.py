"""Robots bear themselves: loads of the planner and of the verifier, and what the user is told."""

import io
import math
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from msgspec import UNSET
from msgspec.structs import replace

from tamplang.compiler import ir
from tamplang.compiler.physics.frames import poses
from tamplang.compiler.physics.statics import loads
from tamplang.compiler.pipeline import check, compile_text
from tamplang.runtime.export.tables import arrays
from tamplang.runtime.plan_forces import StaticsRecord
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.verify import verify
from tamplang.runtime.verify.check import check as judge

ARM = """import std.rules

module arm(drive: torque = {drive}) {{
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 350 g
        holds pad(force 1 kN, moment {foot}, friction 0.8) holds grip(force {grip}, friction 0.6)
    joint j1: revolute(z) in -3 rad .. 3 rad torque drive bearing 100 N m mass 0.5 kg
    joint j2: revolute(y) in -2 rad .. 2 rad home {home} torque drive bearing 100 N m mass 0.5 kg
    link 0.5 m: capsule(0.04 m) mass 1 kg
    joint j3: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque drive bearing 100 N m mass 0.5 kg
    link 0.4 m: capsule(0.04 m) mass 1 kg
    joint j4: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque drive bearing 100 N m
    link 0.1 m: capsule(0.04 m) mass 200 g
    effector B: gripper sphere(0.05 m) mass 350 g
        holds pad(force 1 kN, moment {foot}, friction 0.8) holds grip(force {grip}, friction 0.6)
    fact (linked A B)
}}

task t() {{
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object shelf: box(40 cm, 40 cm, 5 cm) at (0.5 m, 0, {high})
    object item: box(6 cm, 6 cm, 6 cm) on shelf mass {item}
    fact (grippable item)
    arm c: A on ground at (0, 0)
    goal (held item)
    options {{ physics = {physics}, time = 30 s, slices = 10 }}
}}
"""


def text(
    drive: str = "60 N m", foot: str = "120 N m", grip: str = "200 N", home: str = "0.2 rad", item: str = "1 kg",
    physics: str = "statics", high: str = "0.3 m",
) -> str:  # fmt: skip
    return ARM.format(drive=drive, foot=foot, grip=grip, home=home, item=item, physics=physics, high=high)


def solved(program: str) -> object:
    problem, _ = compile_text(program)
    return solve(problem, SolveOptions(time=60.0))


def at_start(problem: ir.Problem) -> dict[tuple[str, str], float]:
    modules = {n: np.array([[*m.pose, *m.joints]]) for n, m in problem.world.modules.items()}
    at = poses(problem, modules, {n: np.array([b.pose]) for n, b in problem.world.bodies.items()})
    found = loads(problem, problem.init_motion, at)
    return {(load.edge.names[1], load.kind): float(load.amount[0]) for load in found}


def test_an_arm_held_out_level_needs_the_moment_of_its_weights() -> None:
    problem, _ = compile_text(text(home=f"{math.pi / 2} rad", physics="none").replace("home 0.2 rad", "home 0 rad"))
    found = at_start(problem)
    weights = [(1.0, 0.25), (0.5, 0.5), (1.0, 0.7), (0.2, 0.95), (0.35, 1.0)]
    moment = 9.81 * sum(mass * lever for mass, lever in weights)
    assert found["j2", "torque"] == pytest.approx(moment)
    assert found["j1", "torque"] == pytest.approx(0.0, abs=1e-9)
    assert found["j1", "bearing"] == pytest.approx(moment)
    assert found["j4", "torque"] == pytest.approx(9.81 * (0.2 * 0.05 + 0.35 * 0.1))


def test_the_planner_keeps_to_its_strengths_and_the_verifier_measures_them() -> None:
    outcome = solved(text())
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
    assert 0.1 < verdict.worst["torque_ratio"] <= 1.0
    assert {"bearing_ratio", "dock_ratio", "foot_ratio"} <= verdict.worst.keys()


def test_a_plan_for_stronger_drives_is_refused_for_weaker_ones() -> None:
    plan = replace(solved(text()).plans[0], statics=UNSET, needs=[])
    torque = plan.verdict.worst["torque_ratio"] * 60.0
    weaker, _ = compile_text(text(drive=f"{0.95 * torque} N m"))
    enough, _ = compile_text(text(drive=f"{1.01 * torque} N m"))
    kinds = {f.kind for f in judge(plan, weaker).failures}
    assert kinds == {"torque_ratio"}
    assert judge(plan, enough).verified


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"item": "100 kg", "grip": "9 kN"}, "is too weak"),
        ({"item": "30 kg", "drive": "900 N m"}, "do not hold together"),
    ],
)
def test_what_is_too_heavy_is_refused_with_the_line_of_its_strength(changes: dict[str, str], told: str) -> None:
    program = text(**changes)
    outcome = solved(program)
    assert outcome.status in ("exhausted", "budget")
    messages = [d for d in outcome.explanation if told in d.message]
    assert messages, [d.message for d in outcome.explanation]
    line = program.splitlines()[messages[0].span.line - 1]
    assert "torque drive" in line or "holds pad" in line
    figures = r": [\d.e+]+ N m (at|right after) the switch, 1\.5 times, is more than (60|120|900|\d+) N m"
    figures += r"|: 294 N after the action, 1\.5 times, is more than \d+ N"
    assert any(re.search(figures, m.message) for m in messages), [m.message for m in messages]


def test_a_plan_tells_weights_strengths_and_torques() -> None:
    problem, _ = compile_text(text(physics="dynamics"))
    plan = solve(problem, SolveOptions(time=60.0)).plans[0]
    told = plan.statics
    assert plan.verdict.verified and "statics" in plan.needs
    own = {(w.name, w.joint): w.mass for w in told.weights}
    assert own["item", -1] == 1.0 and own["c", -1] == pytest.approx(0.35 + 0.5)
    assert {d.torque for d in told.drives} == {60.0}
    greatest = max(abs(v) for t in told.torques for row in t.values for v in row)
    assert 0.1 < greatest * 1.5 / 60.0 <= plan.verdict.worst["torque_ratio"] + 1e-6
    with zipfile.ZipFile(io.BytesIO(arrays(plan, None))) as archive:
        given = np.load(io.BytesIO(archive.read("c/torque.npy")))
    moving = max(abs(v) for t in told.torques for row in t.values for v in row if t.phase < len(plan.phases))
    assert np.abs(given).max() == pytest.approx(moving, rel=0.05)
    (held,) = [t for t in told.torques if t.phase == len(plan.phases)]
    assert len(held.values) == 1 and max(map(abs, held.values[0])) == pytest.approx(greatest, rel=1e-6)

    def kinds(change: Callable[[StaticsRecord], StaticsRecord]) -> set[str]:
        return {f.kind for f in judge(replace(plan, statics=change(told)), problem).failures}

    first, *others = told.torques
    more = replace(first, values=[[v + 2.0 for v in row] for row in first.values])
    assert kinds(lambda s: replace(s, torques=[more, *others])) == {"statics"}
    lighter = [replace(w, mass=0.9 * w.mass) if w.name == "item" else w for w in told.weights]
    assert kinds(lambda s: replace(s, weights=lighter)) == {"scene"}
    assert kinds(lambda s: replace(s, drives=[replace(d, torque=80.0) for d in s.drives])) == {"scene"}
    assert {f.kind for f in judge(replace(plan, needs=[]), problem).failures} == {"structure"}


def test_no_physics_says_nothing_of_forces() -> None:
    verdict = solved(text(item="20 kg", physics="none")).plans[0].verdict
    assert verdict.verified and "torque_ratio" not in verdict.worst


def test_dynamics_takes_the_time_that_drives_need() -> None:
    still = solved(text(physics="statics")).plans[0]
    needed = still.verdict.worst["torque_ratio"] * 60.0
    moving = solved(text(physics="dynamics", drive=f"{1.1 * needed} N m")).plans[0]
    assert moving.verdict.verified and moving.verdict.worst["torque_ratio"] > 0.5
    assert verify(moving).verified


def test_a_scene_that_cannot_stand_is_told_with_joint_and_figures(tmp_path: Path) -> None:
    path = tmp_path / "t.tamp"
    path.write_text(text(home="1.2 rad", drive="9 N m", high="1.5 m"))
    (found,) = [d for d in check(path) if d.code == "E0523"]
    assert "joint j2 of c" in found.message and "9 N m" in found.message
    assert found.labels and path.read_text().splitlines()[found.labels[0].span.line - 1].count("torque drive") == 1


def test_what_states_no_mass_is_told_with_the_density(tmp_path: Path) -> None:
    path = tmp_path / "t.tamp"
    path.write_text(text().replace(" mass 200 g", ""))
    (found,) = [d for d in check(path) if not d.is_error]
    assert found.code == "W0018" and "1000 kg/m^3" in found.message
    path.write_text(text(physics="none").replace(" mass 200 g", ""))
    assert check(path) == ()
