"""Plans put to the limit of one strength: a little beyond it they are refused or fail in simulation, a little within it
nothing breaks."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.engine import carry_out
from tamplang.runtime.feed_forward import with_statics
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.plan_assembly import module_record
from tamplang.runtime.verify import verify

TEXT = """import std.rules

module arm(drive: torque, foot: torque, grip: force) {{
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 350 g
        holds pad(force 1 kN, moment foot) holds grip(force grip)
    joint j1: revolute(z) in -3 rad .. 3 rad torque drive mass 0.5 kg
    joint j2: revolute(y) in -2 rad .. 2 rad home 0.2 rad torque drive mass 0.5 kg
    link 0.5 m: capsule(0.04 m) mass {first:.3f} kg
    joint j3: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque drive mass 0.5 kg
    link 0.4 m: capsule(0.04 m) mass {second:.3f} kg
    joint j4: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque drive
    link 0.1 m: capsule(0.04 m) mass 200 g
    effector B: gripper sphere(0.05 m) mass 350 g
        holds pad(force 1 kN, moment foot) holds grip(force grip)
    fact (linked A B)
}}

task t(drive: torque = 1 kN m, foot: torque = 1 kN m, grip: force = 10 kN) {{
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object shelf: box(40 cm, 40 cm, 5 cm) at ({x:.3f} m, {y:.3f} m, {z:.3f} m)
    object item: box(6 cm, 6 cm, 6 cm) on shelf mass {item:.3f} kg
    fact (grippable item)
    arm(drive = drive, foot = foot, grip = grip) c: A on ground at (0, 0)
    goal (held item)
    options {{ physics = dynamics, safety = 1, slices = 10, time = 30 s }}
}}
"""
STRENGTHS = {"drive": ("torque_ratio", 1e3), "foot": ("foot_ratio", 1e3), "grip": ("dock_ratio", 1e4)}
"""The figure of each strength, and what it is where it does not limit."""
BEYOND, WITHIN = 1.05, 0.9


@dataclass(frozen=True, slots=True)
class Limited:
    """What came of a plan whose worst load was to be `BEYOND` and `WITHIN` what is stated."""

    strength: str
    refused: bool
    failed: bool
    verified: bool
    broken: bool
    reached: bool


def task(random: np.random.Generator) -> str:
    """An arm of random weights, a thing of random weight, on a shelf somewhere in reach."""
    angle, far = random.uniform(-1.2, 1.2), random.uniform(0.45, 0.6)
    first, second, item = random.uniform(0.5, 2.0), random.uniform(0.3, 1.5), random.uniform(0.5, 3.0)
    x, y, z = far * np.cos(angle), far * np.sin(angle), random.uniform(0.2, 0.45)
    return TEXT.format(first=first, second=second, item=item, x=x, y=y, z=z)


def limited(text: str, strength: str, seed: int) -> Limited | None:
    """Solve a task with strength to spare, then carry its plan out with a strength that is nearly, and not quite,
    enough; None where there is no plan."""
    problem, _ = compile_text(text, "limits.tamp", None, {}, seed)
    plans = solve(problem, SolveOptions(time=30.0, seed=seed)).plans
    if not plans or plans[0].verdict is None:
        return None
    kind, most = STRENGTHS[strength]
    needed = plans[0].verdict.worst[kind] * most
    found = []
    for share in (BEYOND, WITHIN):
        plan = restated(plans[0], text, strength, needed / share, seed)
        verdict = verify(plan)
        weaker, _ = compile_text(text, "limits.tamp", None, texts(plan), seed)
        carried = carry_out(weaker, msgspec.structs.replace(plan, verdict=verdict))
        lost = bool(carried.broken) or carried.diverged is not None or carried.base > 0.01
        found.append((verdict.verified, lost, carried.reached or (not lost and not verdict.verified)))
    (accepted, failed, _), (verified, broken, reached) = found
    return Limited(strength, not accepted, failed, verified, broken, reached)


def texts(plan: Plan) -> dict[str, str]:
    units = {"drive": "N m", "foot": "N m", "grip": "N"}
    return {name: f"{value!r} {units[name]}" for name, value in plan.task.parameters.items()}


def restated(plan: Plan, text: str, strength: str, value: float, seed: int) -> Plan:
    """The same motion where a strength is another."""
    own = {**plan.task.parameters, strength: value}
    plan = msgspec.structs.replace(plan, task=msgspec.structs.replace(plan.task, parameters=own))
    problem, _ = compile_text(text, "limits.tamp", None, texts(plan), seed)
    plan = msgspec.structs.replace(plan, modules=[module_record(m) for m in problem.world.modules.values()])
    return with_statics(problem, plan)
