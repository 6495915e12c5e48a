"""What happens by itself in the scene of a plan: bodies that go their own way, modules that break down.

The evaluation of courses is the checker's own; the planner's is elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from ...compiler import ir
from ...compiler.distinct import distinct
from ...langs.frozen import dataclass
from ..plan import Plan
from .findings import Findings
from .geometry import Array, Frames, frames
from .kept_poses import Mode, kept, thing_of
from .kinematics import Motion
from .splines import Spline

TOLERANCE = 1e-9
"""Seconds, or metres, that make no difference."""

MOST_CORNERS = 10_000
"""Of the courses of one body in one phase: a body that shakes faster than this is not checked."""



class TooManyCorners(Exception):
    """A course changes its direction too often to be looked at; the message says when."""


class Course:
    """Where the centre of one body is, by itself, at any time: straight legs at constant speed."""

    def __init__(self, start: Array, courses: Iterable[ir.Course]) -> None:
        self._begins: list[float] = []
        self._legs: list[tuple[Array, Array, ir.Course]] = []
        self._start = start
        for course in sorted(courses, key=lambda c: c.start):
            here = self.at(np.array([course.start]))[0] if self._legs else start
            way = np.vstack([here, *course.points])
            lengths = np.linalg.norm(np.diff(way, axis=0), axis=1)
            self._begins.append(course.start)
            self._legs.append((way, np.concatenate([[0.0], np.cumsum(lengths)]), course))

    def at(self, times: Array) -> Array:
        """The centre `(T, 3)` in metres at `times` `(T,)` in seconds; at the time of a jump, after it."""
        result = np.tile(self._start, (len(times), 1)).astype(float)
        current = np.searchsorted(np.array(self._begins), times + TOLERANCE, side="right") - 1
        for index, (way, ends, course) in enumerate(self._legs):
            chosen = current == index
            gone = course.speed * np.maximum(times[chosen] - course.start, 0.0)
            if course.speed == 0.0:
                gone = np.full(len(gone), ends[-1])
            elif course.returns and ends[-1] > 0.0:
                gone = ends[-1] - np.abs(ends[-1] - gone % (2.0 * ends[-1]))
            result[chosen] = np.column_stack([np.interp(gone, ends, column) for column in way.T])
        return result

    def jumps(self, start: float, end: float) -> Array:
        """The times at which the body is moved at once, from `start` to `end`."""
        found = np.array([c.start for _, _, c in self._legs if c.speed == 0.0])
        return found[(found >= start) & (found <= end)]

    def corners(self, start: float, end: float) -> Array:
        """The times, from `start` to `end`, at which the velocity of the body changes: between them it is constant."""
        found = [np.array(self._begins)]
        for index, (_, ends, course) in enumerate(self._legs):
            until = min(end, *self._begins[index + 1 : index + 2], np.inf)
            if course.speed == 0.0 or until <= course.start or ends[-1] == 0.0:
                continue
            passed = distinct(np.concatenate([ends, 2.0 * ends[-1] - ends])) if course.returns else ends
            lap = 2.0 * ends[-1] / course.speed
            first = np.floor((max(start, course.start) - course.start) / lap) if course.returns else 0.0
            last = np.floor((until - course.start) / lap) if course.returns else 0.0
            if (last - first + 1) * len(passed) > MOST_CORNERS:
                raise TooManyCorners(f"a course turns more than {MOST_CORNERS} times from {start:g} s to {end:g} s")
            laps = np.arange(first, last + 1)[:, None] * lap
            found.append((course.start + laps + passed / course.speed).ravel())
        times = np.concatenate(found)
        return times[(times >= start) & (times <= end)]


@dataclass(frozen=True, slots=True)
class Happenings:
    """The courses of bodies, and per phase which bodies follow theirs: a robot that holds a body ends its course for
    good."""

    courses: Mapping[str, Course]
    free: tuple[frozenset[str], ...]
    gone: Mapping[str, float]

    def placed(self, body: ir.Body, times: Array) -> Frames:
        """The frames `(T,)` of a body on its course."""
        turn = frames(body.pose).rotation
        return Frames(self.courses[body.name].at(times), np.broadcast_to(turn[0], (len(times), 3, 3)))

    def away(self, module: str, time: float) -> bool:
        """Whether a module has left the scene by then."""
        return module in self.gone and self.gone[module] <= time + TOLERANCE


def happenings_of(problem: ir.Problem, plan: Plan, modes: Iterable[Mode]) -> Happenings:
    """What happens in the plan; nothing by itself in one that was made for the scene at rest."""
    if not (plan.courses or plan.breakdowns):
        return Happenings({}, tuple(frozenset() for _ in modes), {})
    bodies = problem.world.bodies
    courses = {
        name: Course(np.array(bodies[name].pose[:3]), [c for c in problem.world.courses if c.body == name])
        for name in sorted({c.body for c in problem.world.courses})
    }
    on_course = frozenset(courses)
    free = []
    for mode in modes:
        pairs = list(kept(problem, mode))
        on_course -= _held(problem, pairs)
        free.append(on_course)
    gone = {b.module: b.time for b in problem.world.breakdowns if b.kind == ir.BreakdownKind.GONE}
    return Happenings(courses, tuple(free), gone)


def _held(problem: ir.Problem, pairs: list[tuple[str, str]]) -> frozenset[str]:
    """Bodies that follow an effector, or something that does."""
    world = problem.world
    found: set[str] = set()
    while True:
        more = {
            own for base, own in pairs
            if own in world.bodies and world.bodies[own].movable
            and (base in found or thing_of(problem, base) in world.modules)
        } - found  # fmt: skip
        if not more:
            return frozenset(found)
        found |= more


# --- the problem in mid-run ----------------------------------------------------------------------------------------


def check_happenings(plan: Plan, problem: ir.Problem, findings: Findings) -> bool:
    """Whether courses and breakdowns of a plan are those of the scene, or left out altogether."""
    if not (plan.courses or plan.breakdowns):
        return True
    before = len(findings.failures)
    wanted = [(c.body, c.start, [list(p) for p in c.points], c.speed, c.returns) for c in problem.world.courses]
    if [(c.body, c.start, c.points, c.speed, c.returns) for c in plan.courses] != wanted:
        findings.fail("scene", "the courses of bodies are not those of the scene")
    broken = [(b.module, b.time, b.kind) for b in problem.world.breakdowns]
    if [(b.module, b.time, b.kind) for b in plan.breakdowns] != broken:
        findings.fail("scene", "the breakdowns of modules are not those of the scene")
    return len(findings.failures) == before


def left_at(problem: ir.Problem, plan: Plan, time: float) -> frozenset[str]:
    """The objects that have left the scene by a time: modules and their effectors."""
    if not plan.breakdowns:
        return frozenset()
    before = (b for b in problem.world.breakdowns if b.time <= time + TOLERANCE)
    gone = {b.module for b in before if b.kind == ir.BreakdownKind.GONE}
    return frozenset(o for o in problem.objects if thing_of(problem, o) in gone)


def without(problem: ir.Problem, left: frozenset[str]) -> ir.Problem:
    """The problem with fewer objects."""
    if not left:
        return problem
    modules = {n: m for n, m in problem.world.modules.items() if n not in left}
    objects = {n: t for n, t in problem.objects.items() if n not in left}
    return replace(problem, objects=objects, world=replace(problem.world, modules=modules))


def scene_at(problem: ir.Problem, motion: Motion, sample: int) -> ir.Problem:
    """The problem with everything where it is at a sample of a motion."""
    modules = {
        n: replace(m, pose=_pose(motion.poses[n][sample]), joints=tuple(motion.joints[n][sample].tolist()))
        for n, m in problem.world.modules.items()
    }
    bodies = {
        n: b if motion.rests(n, 0, sample) else replace(b, pose=_pose(motion.poses[n][sample]))
        for n, b in problem.world.bodies.items()
    }
    return replace(problem, world=replace(problem.world, modules=modules, bodies=bodies))


def _pose(row: Array) -> ir.Pose:
    x, y, z, a, b, c, w = (float(v) for v in row)
    return x, y, z, a, b, c, w


def check_courses(problem: ir.Problem, happenings: Happenings, motion: Motion, findings: Findings) -> None:
    """Bodies that nothing holds are where their courses take them, and turn not."""
    for index, free in enumerate(happenings.free[: len(motion.ranges)]):
        first, last = motion.ranges[index]
        times = motion.times[first : last + 1]
        for name in sorted(free):
            true = happenings.placed(problem.world.bodies[name], times)
            stored = motion.frames[name][slice(first, last + 1)]
            off = np.linalg.norm(stored.position - true.position, axis=1)
            turn = np.max(np.abs(stored.rotation - true.rotation), axis=(1, 2))
            for kind, amounts in (("course_m", off), ("course_rad", turn)):
                at = int(np.argmax(amounts))
                findings.measure(
                    kind, float(amounts[at]), f"{name} is not where its course takes it",
                    time=float(times[at]), between=[name],
                )  # fmt: skip


def check_breakdowns(
    problem: ir.Problem, plan: Plan, motion: Motion, curves: Mapping[tuple[str, int], Spline], findings: Findings
) -> None:
    """Joints that are stuck stay as they are, on the samples and on the splines."""
    for breakdown in problem.world.breakdowns if plan.breakdowns else ():
        rows = motion.joints[breakdown.module][motion.times >= breakdown.time - TOLERANCE]
        if breakdown.kind != ir.BreakdownKind.LOCKED or not len(rows) or not rows.shape[1]:
            continue
        off = float(np.max(np.abs(rows - rows[0])))
        for curve in {id(c): c for (name, _), c in curves.items() if name == breakdown.module}.values():
            times, values = curve.extrema()
            later = times >= breakdown.time - TOLERANCE
            off = max(off, float(np.max(np.abs(values - rows[0]), where=later, initial=0.0)))
        findings.measure(
            "stuck_rad", off, f"{breakdown.module} moves a joint that is stuck",
            time=breakdown.time, between=[breakdown.module], place=findings.place_of(breakdown.span),
        )  # fmt: skip
