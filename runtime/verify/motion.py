"""The motion itself: start, continuity, splines, joint limits, and that what nothing carries stays put."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ...compiler import ir
from ..plan import ModuleRecord, Plan
from .findings import Findings
from .geometry import Array, pose_differences
from .happenings import Happenings
from .kinematics import Motion
from .limits import LIMITS
from .replay import Story
from .splines import Spline

SPLINE_SAMPLES = 10
"""Limits are read from a spline at so many points per knot interval."""


def check_motion(
    problem: ir.Problem, plan: Plan, story: Story, motion: Motion, happenings: Happenings, findings: Findings
) -> None:
    """Everything about the motion that does not depend on shapes or motion predicates."""
    _check_start(plan, motion, findings)
    _check_jumps(motion, findings)
    for module in plan.modules:
        _check_limits(module, motion.joints[module.name], motion.times, findings)
    _check_splines(plan, motion, findings)
    for name in sorted(motion.moving):
        own = name in happenings.courses
        if name in problem.world.bodies and not problem.world.bodies[name].movable and not own:
            findings.fail("rest", f"{name} cannot be moved, but the plan moves it", between=[name])
    for index, mode in enumerate(story.modes[: len(motion.ranges)]):
        _check_rest(problem, mode, index, motion, happenings, findings)


def _check_start(plan: Plan, motion: Motion, findings: Findings) -> None:
    poses = {m.name: m.pose for m in plan.modules} | {b.name: b.pose for b in plan.bodies}
    for name, pose in poses.items():
        shift, turn = pose_differences(motion.poses[name][:1], np.array([pose]))
        message = f"{name} does not start where the scene puts it"
        findings.measure("start_m", float(shift[0]), message, time=0.0, between=[name])
        findings.measure("start_rad", float(turn[0]), message, time=0.0, between=[name])
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
    for index, joint in enumerate(module.joints):
        values = rows[:, index]
        over = np.maximum(np.maximum(joint.lower - values, values - joint.upper), 0.0)
        at = int(np.argmax(over))
        kind = "joint_limit_m" if joint.kind == "prismatic" else "joint_limit_rad"
        message = f"joint {joint.name} of {module.name} leaves its limits"
        findings.measure(
            kind, float(over[at]), message, time=float(times[at]), between=[module.name, joint.name]
        )


def _check_splines(plan: Plan, motion: Motion, findings: Findings) -> None:
    """Stored joint values lie on the stored splines, which keep the limits, too."""
    modules = {m.name: m for m in plan.modules}
    curved = {(s.module, s.first) for s in plan.splines}
    for module in plan.modules:
        for phase, (first, last) in enumerate(motion.ranges):
            rows = motion.joints[module.name][first : last + 1]
            if module.joints and (module.name, phase) not in curved:
                off = np.abs(rows - rows[0]).max(axis=1)
                findings.measure(
                    "spline_rad", float(off.max()), f"{module.name} moves joints without a spline",
                    time=float(motion.times[first + int(np.argmax(off))]), between=[module.name],
                )  # fmt: skip
    for spline in plan.splines:
        module = modules[spline.module]
        if not module.joints:
            continue
        first, last = motion.ranges[spline.first]
        knots = np.asarray(spline.knots)
        curve = Spline(knots, spline.values, clamped=True)
        off = np.abs(curve(motion.times[first : last + 1]) - motion.joints[module.name][first : last + 1])
        at, joint = np.unravel_index(int(np.argmax(off)), off.shape)
        message = f"joint {module.joints[int(joint)].name} of {module.name} leaves its spline"
        findings.measure(
            "spline_rad", float(off[at, joint]), message,
            time=float(motion.times[first + at]), between=[module.name],
        )  # fmt: skip
        times = np.linspace(knots[0], knots[-1], SPLINE_SAMPLES * (len(knots) - 1) + 1)
        _check_limits(module, curve(times), times, findings)


# --- rest --------------------------------------------------------------------------------------------------------


def _check_rest(
    problem: ir.Problem, mode: Iterable[ir.Fact], index: int, motion: Motion, happenings: Happenings,
    findings: Findings,
) -> None:  # fmt: skip
    """Among things whose relative poses are kept, but which nothing holds to a fixed body, one must rest."""
    free = happenings.free[index]
    for group in _groups(problem, mode):
        if free.intersection(group):
            continue
        if any(n in problem.world.bodies and not problem.world.bodies[n].movable for n in group):
            continue
        if not any(n in motion.moving for n in group):
            continue
        first, last = motion.ranges[index]
        names = [n for thing in group for n in _frames_of(problem, thing)]
        shift, turn, name = min(_movement(motion, n, first, last) for n in names)
        message = f"{', '.join(group)} moves though nothing holds it"
        time = float(motion.times[first])
        findings.measure("rest_m", shift, message, time=time, between=group)
        if shift <= LIMITS["rest_m"]:
            findings.measure("rest_rad", turn, message, time=time, between=[name])


def _movement(motion: Motion, name: str, first: int, last: int) -> tuple[float, float, str]:
    if name in motion.changes and motion.rests(name, first, last):
        return 0.0, 0.0, name
    frames = motion.frames[name][slice(first, last + 1)]
    relative = frames.relative_to(frames[:1])
    shift = float(np.max(np.linalg.norm(relative.position, axis=1)))
    turn = float(np.max(np.linalg.norm(relative.rotation - np.eye(3), axis=(1, 2)))) / np.sqrt(2)
    return shift, turn, name


def _frames_of(problem: ir.Problem, thing: str) -> list[str]:
    module = problem.world.modules.get(thing)
    return [thing] if module is None else [thing, *(f"{thing}.{e.name}" for e in module.type.effectors)]


def _groups(problem: ir.Problem, mode: Iterable[ir.Fact]) -> list[list[str]]:
    """Modules and bodies, grouped by the poses that the literals of a mode keep."""
    leader = {name: name for name in (*problem.world.modules, *problem.world.bodies)}

    def find(name: str) -> str:
        while leader[name] != name:
            name = leader[name]
        return name

    for literal in sorted(mode):
        predicate = problem.motions[literal[0]]
        bound = dict(zip((v.name for v in predicate.variables), literal[1:], strict=True))
        for row in predicate.rows:
            if row.when == "keep" and isinstance(row.left, ir.Function) and row.left.name == "pose":
                ends = [_thing(problem, bound, a) for a in row.left.args]
                leader[find(ends[0])] = find(ends[1])
    groups: dict[str, list[str]] = {}
    for name in leader:
        groups.setdefault(find(name), []).append(name)
    return list(groups.values())


def _thing(problem: ir.Problem, bound: Mapping[str, str], node: ir.Term) -> str:
    name = bound[node.name] if isinstance(node, ir.Var) else node.name if isinstance(node, ir.Object) else ""
    end = problem.world.effector(name)
    return name if end is None else end[0].name
