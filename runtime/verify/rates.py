"""Speeds and accelerations of joints: from the stored splines, exactly, and from the samples."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...compiler import ir
from ..plan import NO_LIMIT, ModuleRecord, Plan
from .findings import Findings
from .geometry import Array
from .kinematics import Motion
from .splines import Spline

WORDS = {"speed": "is faster than its limit", "acceleration": "speeds up or slows down harder than its limit",
         "jerk": "changes its acceleration faster than its limit"}  # fmt: skip
ENDS = {("speed", ir.JointKind.REVOLUTE): "rad_s",
        ("speed", ir.JointKind.PRISMATIC): "m_s",
        ("acceleration", ir.JointKind.REVOLUTE): "rad_s2",
        ("acceleration", ir.JointKind.PRISMATIC): "m_s2",
        ("jerk", ir.JointKind.REVOLUTE): "rad_s3",
        ("jerk", ir.JointKind.PRISMATIC): "m_s3"}  # fmt: skip


def check_rates(problem: ir.Problem, plan: Plan, motion: Motion, findings: Findings) -> None:
    """Every joint keeps the limits that its module type gives, in every phase, also where a breakdown stops one."""
    modules = {m.name: m for m in plan.modules if m.joints}
    for spline in plan.splines:
        if spline.module in modules:
            knots, values = np.asarray(spline.knots), np.asarray(spline.values)
            _check_spline(problem, modules[spline.module], knots, values, findings)
            if all(plan.phases[k].completed for k in range(spline.first, spline.until + 1)):
                _check_jerk(problem, modules[spline.module], knots, values, findings)


def _check_jerk(
    problem: ir.Problem, module: ModuleRecord, knots: Array, values: Array, findings: Findings
) -> None:
    """Where a joint states a limit: between knots the jerk is constant; what acceleration there is at an end counts as
    having come about in the piece beside it. A motion that is broken off need not keep it."""
    if all(math.isinf(j.jerk) for j in problem.world.modules[module.name].type.joints):
        return
    curve = Spline(knots, values)
    steps = np.diff(knots)
    ends = curve(knots[[0, -1]], 2) / steps[[0, -1], None]
    rates = np.concatenate([6.0 * curve.cubic, np.abs(ends)])
    _record(problem, module, "jerk", rates, np.concatenate([knots[:-1], knots[[0, -1]]]), findings)


def _check_spline(
    problem: ir.Problem, module: ModuleRecord, knots: Array, values: Array, findings: Findings
) -> None:
    """The acceleration of a cubic spline is linear between knots: it is greatest at one of them, and the speed there or
    where the acceleration is zero."""
    curve = Spline(knots, values)
    _record(problem, module, "acceleration", curve(knots, 2), knots, findings)
    _record(problem, module, "speed", curve(knots, 1), knots, findings)
    for index in range(len(module.joints)):
        cubic, square = curve.cubic[:, index], curve.square[:, index]
        bent = np.abs(cubic) > 1e-12
        turns = knots[:-1] + np.where(bent, -square / np.where(bent, 3.0 * cubic, 1.0), 0.0)
        turns = turns[(turns > knots[:-1]) & (turns < knots[1:])]
        if len(turns):
            rates = np.zeros((len(turns), len(module.joints)))
            rates[:, index] = curve(turns, 1)[:, index]
            _record(problem, module, "speed", rates, turns, findings)


def _record(
    problem: ir.Problem, module: ModuleRecord, what: str, rates: Array, times: Array, findings: Findings
) -> None:
    """Enter the greatest rate of each kind of joint, by its share of the limit; rates are `(times, joints)`."""
    joints = problem.world.modules[module.name].type.joints
    limits = np.array([min(NO_LIMIT, getattr(j, what)) for j in joints])
    for kind in (ir.JointKind.REVOLUTE, ir.JointKind.PRISMATIC):
        columns = [i for i, j in enumerate(joints) if j.kind == kind]
        if columns:
            _record_kind(module, joints, what, columns, np.abs(rates), limits, times, findings)


def _record_kind(
    module: ModuleRecord, joints: Sequence[ir.Joint], what: str, columns: Sequence[int], rates: Array, limits: Array,
    times: Array, findings: Findings,
) -> None:  # fmt: skip
    shares = rates[:, columns] / limits[columns]
    at, place = np.unravel_index(int(np.argmax(shares)), shares.shape)
    joint = joints[columns[int(place)]]
    message = f"joint {joint.name} of {module.name} {WORDS[what]}"
    findings.measure(
        f"joint_{what}_{ENDS[what, joint.kind]}", float(rates[at, columns[int(place)]]), message,
        time=float(times[at]), between=[module.name, joint.name], limit=float(limits[columns[int(place)]]),
    )  # fmt: skip
