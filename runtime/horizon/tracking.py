"""How drives follow a plan: a simulation of the joints with seeded noise, and how far the executed motion is off.

Every joint is a drive that is told position, speed and acceleration of the plan at each step and corrects what its
sensor shows (feed-forward and a critically damped PD law). Its acceleration misses the command by normal noise; its
sensor reads with normal noise. Inertia and load are taken to be fed forward exactly; grips and feet hold. What the
executed joints mean for poses follows by forward kinematics (Pinocchio) from what each robot stands on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...compiler import ir
from ..motion.movement import followers
from ..plan import Plan
from ..skeleton import Array, Configuration
from ..splines import ClampedSpline
from ..verify.geometry import Frames
from ..verify.kinematics import Kinematics, Motion, motion_of, place
from .clearance import worst_clearance
from .world import carried

STEP = 2e-3
"""Seconds of one step of the drives."""
STIFFNESS = 40.0
"""Natural frequency of the drives, 1/s."""


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations: `position` of sensed bodies (m), `joint` of sensed joints (rad or m), `drive` of the
    accelerations that drives give (rad/s² or m/s²)."""

    position: float = 0.0
    joint: float = 5e-4
    drive: float = 0.5


@dataclass(frozen=True, slots=True)
class JointDeviation:
    """How far the executed joint is from the planned one at most, and on average (root mean square)."""

    module: str
    joint: str
    worst: float
    rms: float


@dataclass(frozen=True, slots=True)
class Deviations:
    """How the executed motion deviates from the plan. `switch` is the greatest distance, in metres, of an end that
    comes to touch something at a switch from where the plan has it; `clearance` the least distance in metres of what
    the plan keeps apart, None where nothing comes near."""

    joints: tuple[JointDeviation, ...]
    switch: float
    switch_of: str
    clearance: float | None
    clearance_between: tuple[str, ...]


def follow(plan: Plan, problem: ir.Problem, noise: Noise, seed: int) -> Deviations:
    """Let simulated drives carry out the joint motion of a plan. Raises MissingLibrary."""
    kinematics = {m.name: Kinematics(m) for m in plan.modules}
    planned = motion_of(plan, kinematics)
    random = np.random.default_rng([seed, 2])
    joints = {name: driven(planned, plan, name, noise, random) for name in planned.joints}
    executed = _posed(plan, problem, planned, joints, kinematics)
    found = []
    for module in plan.modules:
        off = np.abs(joints[module.name] - planned.joints[module.name])
        for k, joint in enumerate(module.joints):
            found.append(JointDeviation(module.name, joint.name, float(off[:, k].max()), _rms(off[:, k])))
    switch, name = _switch_error(plan, planned.frames, executed.frames, planned)
    clearance, between = worst_clearance(plan, planned, executed)
    return Deviations(tuple(found), switch, name, clearance, between)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def driven(planned: Motion, plan: Plan, module: str, noise: Noise, random: np.random.Generator) -> Array:
    """Executed joint values `(T, n)` of a module at the time stamps of the plan."""
    result = planned.joints[module].copy()
    if not result.shape[1]:
        return result
    splines = {s.phase: s for s in plan.splines if s.module == module}
    error, rate = np.zeros(result.shape[1]), np.zeros(result.shape[1])
    gain, damping = STIFFNESS**2, 2.0 * STIFFNESS
    for phase, (first, last) in enumerate(planned.ranges[: len(plan.phases)]):
        knots = np.asarray(splines[phase].knots)
        curve = ClampedSpline(knots, splines[phase].values)
        steps = max(1, int(np.ceil((knots[-1] - knots[0]) / STEP)))
        length = (knots[-1] - knots[0]) / steps
        misses = random.normal(0.0, noise.drive, (steps, len(error)))
        reads = random.normal(0.0, noise.joint, (steps, len(error)))
        errors = np.empty((steps + 1, len(error)))
        errors[0] = error
        for k in range(steps):
            rate = rate + length * (misses[k] - gain * (error + reads[k]) - damping * rate)
            error = error + length * rate
            errors[k + 1] = error
        grid = np.linspace(knots[0], knots[-1], steps + 1)
        times = planned.times[first : last + 1]
        off = np.column_stack([np.interp(times, grid, column) for column in errors.T])
        result[first : last + 1] = curve(times) + off
    return result


def _posed(
    plan: Plan, problem: ir.Problem, planned: Motion, joints: Mapping[str, Array], kinematics: Mapping[str, Kinematics]
) -> Motion:
    """The executed motion: poses from the executed joints, phase by phase, from what holds still in the plan."""
    poses = {name: rows.copy() for name, rows in planned.poses.items()}
    for phase, (first, last) in zip(plan.phases, planned.ranges, strict=False):
        part = slice(first, last + 1)
        mode = frozenset((r.predicate, *r.args) for r in phase.mode)
        before = Configuration(
            {m: np.concatenate([planned.poses[m][first], planned.joints[m][first]]) for m in planned.joints},
            {b: planned.poses[b][first] for b in problem.world.bodies},
        )
        held = followers(problem, mode)
        own = {b: planned.poses[b][part] for b in sorted(planned.moving & problem.world.bodies.keys() - held)}
        found = carried(problem, mode, {m: rows[part] for m, rows in joints.items()}, before, own)
        for name, rows in found.items():
            poses[name][part] = rows
    return place(planned.times, planned.ranges, poses, dict(joints), planned.moving, kinematics)


def _switch_error(
    plan: Plan, planned: Mapping[str, Frames], executed: Mapping[str, Frames], motion: Motion
) -> tuple[float, str]:
    """The worst position error of what comes to touch at a switch."""
    worst, name = 0.0, ""
    for phase, (_, last) in zip(plan.phases, motion.ranges, strict=False):
        for literal in phase.added:
            for argument in literal.args:
                if argument in planned and "." in argument:
                    off = float(np.linalg.norm(planned[argument].position[last] - executed[argument].position[last]))
                    if off > worst:
                        worst, name = off, argument
    return worst, name
