"""Exports tell the masses that the texts state, whether the plan asks for physics or not."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml

import msgspec
import mujoco
import numpy as np
import pytest

from benchmarks.trust.checker.forces import mass_of as checked_mass
from tamplang.compiler.motion.distances import DistanceShape, mass
from tamplang.compiler.physics.masses import body_mass
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.engine.model import build
from tamplang.runtime.export import write
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.verify.inertia import mass_of

from .loaded import ALL_MASS, MOMENT, OUT, reaching

LIFTED = """import std.rules
module arm {
    effector A: gripper sphere(5 cm) normal (0, 0, -1) mass 350 g holds pad(force 1 kN, moment 1 kN m)
    joint j1: revolute(z) in -3 rad .. 3 rad torque 1 kN m
    joint j2: revolute(y) in -2 rad .. 2 rad home 0.2 rad torque 1 kN m
    link 0.5 m: capsule(4 cm) mass 1 kg
    joint j3: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque 1 kN m
    link 0.4 m: capsule(4 cm) mass 1 kg
    joint j4: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque 1 kN m
    link 0.1 m: capsule(4 cm) mass 200 g
    effector B: gripper sphere(5 cm) mass 350 g holds grip(force 40 N)
    fact (linked A B)
}
task t() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object shelf: box(40 cm, 40 cm, 5 cm) at (0.5 m, 0, 0.3 m)
    object cup: union(box(20 cm, 6 cm, 6 cm) at (0, 0, 0), box(6 cm, 6 cm, 12 cm) at (-2 cm, 0, 3 cm),
        box(5 cm, 10 cm, 2 cm) at (-2 cm, 1 cm, 4 cm), sphere(2 cm) at (12 cm, 0, 0)) on shelf DENSITY
    fact (grippable cup)
    arm c: A on ground at (0, 0)
    goal (held cup)
    options { physics = statics, safety = 1, slices = 10, time = 60 s }
}
"""
BOXES = [((0, 0, 0), (20, 6, 6)), ((-2, 0, 3), (6, 6, 12)), ((-2, 1, 4), (5, 10, 2))]
"""Middles and sides of those of the cup, cm."""


@pytest.mark.parametrize("physics", ["statics", "none"])
def test_masses_and_efforts_are_the_stated_ones(physics: str, tmp_path: Path) -> None:
    plan = reaching(physics=physics, hoist="torque 7 N m mass 250 g")
    write(plan, "urdf", tmp_path / "a.urdf")
    root = Xml.parse(tmp_path / "a.urdf").getroot()
    assert sum(float(m.get("value")) for m in root.iter("mass")) == pytest.approx(ALL_MASS + 0.25)
    limits = {j.get("name"): j.find("limit") for j in root.iter("joint")}
    efforts = {name: float(limit.get("effort")) for name, limit in limits.items() if limit is not None}
    assert efforts["a.lift"] == 7.0 and efforts["a.turn"] == 1000.0
    write(plan, "mjcf", tmp_path / "a.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))
    # A frame that weighs nothing gets a gram, as the engine has none without a mass.
    assert model.body("a").subtreemass[0] == pytest.approx(ALL_MASS + 0.25, abs=2e-3)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.qacc[:] = 0.0
    mujoco.mj_inverse(model, data)
    lift = data.qfrc_inverse[int(model.joint("a.lift").dofadr[0])]
    assert abs(lift) == pytest.approx(MOMENT - 9.81 * OUT, rel=1e-6) and np.isfinite(data.qfrc_inverse).all()


def test_boxes_of_a_union_weigh_once_wherever_they_are_weighed(tmp_path: Path) -> None:
    problem, _ = compile_text(LIFTED.replace("DENSITY", ""), "t.tamp")
    same, _ = compile_text(LIFTED.replace("DENSITY", "density 1000 kg/m^3"), "t.tamp")
    cup, weight = problem.world.bodies["cup"], body_mass(problem.world.bodies["cup"])
    points = np.random.default_rng(1).uniform((-0.10, -0.04, -0.03), (0.14, 0.06, 0.09), (400000, 3))
    within = [(np.abs(points - np.array(at) / 100) <= np.array(sides) / 200).all(axis=1) for at, sides in BOXES]
    within.append(np.linalg.norm(points - (0.12, 0.0, 0.0), axis=1) <= 0.02)
    assert weight == pytest.approx(1000.0 * 0.24 * 0.10 * 0.12 * np.any(within, axis=0).mean(), rel=0.01)
    plan = solve(problem, SolveOptions(time=60.0)).plans[0]
    assert plan.verdict is not None and plan.verdict.verified
    [told] = [w.mass for w in plan.statics.weights if w.name == "cup"]
    found = [told, mass_of(cup.shape), checked_mass(cup.shape, None), body_mass(same.world.bodies["cup"])]
    found.append(float(mass(DistanceShape(None, cup.shape.kind, cup.shape.size, parts=cup.shape.parts))))
    for number, one in enumerate((plan, msgspec.structs.replace(plan, statics=msgspec.UNSET))):
        write(one, "mjcf", tmp_path / f"{number}.xml")
        found.append(mujoco.MjModel.from_xml_path(str(tmp_path / f"{number}.xml")).body("cup").mass[0])
    engine = build(problem, [])
    found.append(engine.model.body_mass[engine.bodies["cup", -1]])
    assert found == pytest.approx([weight] * len(found), rel=1e-9)
