"""How far what drives carry out is off what they were commanded; and drives that follow a plan file.

Grips and feet hold. What joints mean for poses follows, by the verifier's kinematics, from what robots stand on.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...langs.frozen import dataclass
from ..geometry.attachments import followers
from ..geometry.transforms import coupled
from ..plan import Plan
from ..seeds import Seed
from ..skeleton import Array, Configuration
from ..verify.geometry import Frames, HeldFrames
from ..verify.kinematics import Kinematics, Motion, motion_of, place
from .actuators import Noise, missed
from .executed_clearance import worst_clearance
from .world import carried


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
    planned = motion_of(plan, {m.name: Kinematics(m) for m in plan.modules})
    driven = _driven(planned, noise, Seed(seed).child("drives").random())
    driven = {m.name: coupled(m.joints, driven[m.name]) for m in plan.modules}
    return deviations(plan, problem, planned.joints, driven)


def deviations(
    plan: Plan, problem: ir.Problem, commanded: Mapping[str, Array], driven: Mapping[str, Array]
) -> Deviations:
    """How `driven` joints, `(T, n)` at the time stamps of a plan, deviate from the `commanded` ones. Raises
    MissingLibrary."""
    kinematics = {m.name: Kinematics(m) for m in plan.modules}
    told = motion_of(plan, kinematics)
    planned, executed = (_posed(plan, problem, told, joints, kinematics) for joints in (commanded, driven))
    found = []
    for module in plan.modules:
        off = np.abs(driven[module.name] - commanded[module.name])
        for k, joint in enumerate(module.joints):
            found.append(JointDeviation(module.name, joint.name, float(off[:, k].max()), _rms(off[:, k])))
    switch, name = _switch_error(plan, planned.frames, executed.frames, planned)
    clearance, between = worst_clearance(plan, planned, executed)
    return Deviations(tuple(found), switch, name, clearance, between)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _driven(planned: Motion, noise: Noise, random: np.random.Generator) -> dict[str, Array]:
    """Executed joint values `(T, n)` at the time stamps of a plan."""
    result = {}
    for name, rows in planned.joints.items():
        values, error = rows.copy(), np.zeros(rows.shape[1])
        for first, last in planned.ranges if rows.shape[1] else ():
            part = slice(first, last + 1)
            errors = missed(noise, random, error, planned.times[part])
            values[part] += errors
            error = errors[-1]
        result[name] = values
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
    plan: Plan, planned: Mapping[str, Frames | HeldFrames], executed: Mapping[str, Frames | HeldFrames], motion: Motion
) -> tuple[float, str]:
    """The worst position error of what comes to touch at a switch."""
    worst, name = 0.0, ""
    for phase, (_, last) in zip(plan.phases, motion.ranges, strict=False):
        for literal in phase.added:
            for argument in literal.args:
                if argument in planned and "." in argument:
                    at = slice(last, last + 1)
                    away = planned[argument][at].position - executed[argument][at].position
                    off = float(np.linalg.norm(away))
                    if off > worst:
                        worst, name = off, argument
    return worst, name
