"""Where the motion starts, that it does not jump, and that joints keep their limits."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ..plan import ModuleRecord, Plan
from .findings import Findings
from .geometry import Array, pose_differences
from .happenings import Happenings
from .kinematics import Motion
from .limits import LIMITS
from .splines import Spline


def check_motion(
    problem: ir.Problem, plan: Plan, motion: Motion, curves: Mapping[tuple[str, int], Spline],
    happenings: Happenings, findings: Findings,
) -> None:  # fmt: skip
    """Everything about the motion that does not depend on shapes or motion predicates. A spline is greatest and least
    at its knots and where it turns: its limits are checked exactly."""
    _check_start(plan, motion, findings)
    _check_jumps(motion, findings)
    modules = {m.name: m for m in plan.modules}
    for module in plan.modules:
        _check_limits(module, motion.joints[module.name][:1], motion.times[:1], findings)
    for (name, phase), curve in curves.items():
        if curves.get((name, phase - 1)) is curve:
            continue
        times, values = curve.extrema()
        _check_limits(modules[name], values, times, findings)
    for name in sorted(motion.moving):
        own = name in happenings.courses
        if name in problem.world.bodies and not problem.world.bodies[name].movable and not own:
            findings.fail("rest", f"{name} cannot be moved, but the plan moves it", between=[name])


def _check_start(plan: Plan, motion: Motion, findings: Findings) -> None:
    poses = {m.name: m.pose for m in plan.modules} | {b.name: b.pose for b in plan.bodies}
    if poses:
        first = np.array([motion.poses[name][0] for name in poses])
        shifts, turns = pose_differences(first, np.array(list(poses.values())))
        names = list(poses)
        for kind, off in (("start_m", shifts), ("start_rad", turns)):
            for k in sorted({int(np.argmax(off)), *np.flatnonzero(~(off <= LIMITS[kind])).tolist()}):
                message = f"{names[k]} does not start where the scene puts it"
                findings.measure(kind, float(off[k]), message, time=0.0, between=[names[k]])
    for module in plan.modules:
        if module.start:
            off = np.abs(motion.joints[module.name][0] - module.start)
            joint = module.joints[int(np.argmax(off))].name
            message = f"joint {joint} of {module.name} does not start at its home value"
            findings.measure("start_rad", float(off.max()), message, time=0.0, between=[module.name])


def _check_jumps(motion: Motion, findings: Findings) -> None:
    """The two samples at a switch must be the same."""
    ends = np.array([last for _, last in motion.ranges[:-1]], dtype=np.intp)
    if not len(ends):
        return
    for name in sorted(motion.moving):
        poses, joints = motion.poses[name], motion.joints.get(name)
        shift, turn = pose_differences(poses[ends], poses[ends + 1])
        if joints is not None and joints.shape[1]:
            turn = np.maximum(turn, np.max(np.abs(joints[ends + 1] - joints[ends]), axis=1))
        for kind, jumps in (("jump_m", shift), ("jump_rad", turn)):
            for at in sorted({int(np.argmax(jumps)), *(int(k) for k in np.flatnonzero(jumps > LIMITS[kind]))}):
                time, message = float(motion.times[ends[at]]), f"{name} jumps at the switch"
                findings.measure(kind, float(jumps[at]), message, time=time, between=[name])


# --- joints ------------------------------------------------------------------------------------------------------


def _check_limits(module: ModuleRecord, rows: Array, times: Array, findings: Findings) -> None:
    """Measure rows `(T, n)` of joint values at `times` `(T,)` or, joint by joint, `(T, n)`."""
    when = np.broadcast_to(times if times.ndim > 1 else times[:, None], rows.shape)
    for index, joint in enumerate(module.joints):
        values = rows[:, index]
        over = np.maximum(np.maximum(joint.lower - values, values - joint.upper), 0.0)
        at = int(np.argmax(over))
        kind = "joint_limit_m" if joint.kind == ir.JointKind.PRISMATIC else "joint_limit_rad"
        message = f"joint {joint.name} of {module.name} leaves its limits"
        findings.measure(
            kind, float(over[at]), message, time=float(when[at, index]), between=[module.name, joint.name]
        )
