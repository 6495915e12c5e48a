"""The simulated world of a run: bodies on their courses, modules that break down, and what moves along with what.

Time passes only while something is carried out; planning takes none. A body on a course goes its way until a robot
holds it; then it never does again. Whatever the motion literals keep to a moving body, such as a robot that stands on
it, is carried along rigidly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...compiler import ir
from ...compiler.courses import centre_at
from ...compiler.kept_pairs import kept_pairs
from ...langs.frozen import dataclass
from ..engine.actor import Simulated
from ..geometry.attachments import followers
from ..geometry.resampling import Linker, between
from ..geometry.splines import ClampedSpline
from ..geometry.transforms import coupled
from ..planner.receding.mid_run_state import Reached, start
from ..seeds import Seed
from ..skeleton import Array, Configuration, PhasePath
from .actuators import EXACT, Noise, missed

STILL = 1e-9
"""Radians or metres that are no motion."""


@dataclass(frozen=True, slots=True)
class Interval:
    """What is carried out until the next switch: an action, the motion literals meanwhile and those that it adds, and
    the motion, of which only the joint values count, and the poses of what nothing holds. One that is not `completed`
    ends before its switch. The modules that go `through` its end move on there."""

    action: ir.Action
    mode: frozenset[ir.Fact]
    added: frozenset[ir.Fact]
    path: PhasePath
    completed: bool = True
    through: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Executed:
    """An interval as it took place: `times` `(T,)` since the start of the run; `poses` `(T, 7)` of modules and of the
    bodies that moved, `joints` `(T, n)`; `before` is the state in which it began. Joints were `commanded` to be at
    `(T, n)` and came to `driven` `(T, n)`. The path of `interval` ends where they were when it was broken off; at a
    switch, what touches is felt, and what the drives have missed is put right."""

    interval: Interval
    before: Reached
    times: Array
    poses: dict[str, Array]
    joints: dict[str, Array]
    bodies: dict[str, Array]
    commanded: dict[str, Array]
    driven: dict[str, Array]


class SimulatedWorld:
    """The scene of `problem` as it truly is. `time` is in seconds since the start; `reached` the present state. Drives
    miss what they are told by `noise`."""

    def __init__(self, problem: ir.Problem, noise: Noise = EXACT, seed: int = 0) -> None:
        self.problem = problem
        self.noise = noise
        self._random = Seed(seed).child("drives").random()
        self.time = 0.0
        self.reached = start(problem)
        self._courses: dict[str, list[ir.Course]] = {}
        for course in problem.world.courses:
            self._courses.setdefault(course.body, []).append(course)
        self.on_course = set(self._courses)

    def body_poses(self, body: str, times: Array) -> Array:
        """Where a body on a course is, `(T, 7)`; its orientation is that of the start."""
        x, y, z, *turn = self.problem.world.bodies[body].pose
        centres = [centre_at((x, y, z), self._courses[body], float(t)) for t in times]
        return np.column_stack([np.array(centres), np.tile(turn, (len(times), 1))])

    def at(self, time: float) -> dict[str, Array]:
        """The poses `(7,)` of all bodies on courses at a time."""
        return {body: self.body_poses(body, np.array([time]))[0] for body in sorted(self.on_course)}

    @property
    def result(self) -> Simulated | None:
        """What a physics engine found of this world, if there is one."""
        return None

    def rest(self) -> None:
        """Hold the end of a run for a while."""

    def begin(self, mode: frozenset[ir.Fact]) -> None:
        """Bodies that a robot holds from now on leave their courses."""
        self.on_course -= followers(self.problem, mode)

    def carry_out(self, interval: Interval, samples: int) -> Executed:
        """Let an interval take place, and time pass. The state reached still has the facts of before: what the action
        does to them is not the world's business."""
        self.begin(interval.mode)
        inner = np.linspace(0.0, interval.path.duration, samples)
        times = self.time + inner
        errors = self._errors(interval.path, inner)
        path = missing(interval.path, errors, settled=interval.completed)
        commanded, joints = sampled(interval.path, inner), sampled(path, inner)
        driven = {name: values + errors[name] for name, values in commanded.items()}
        return self._took_place(replace(interval, path=path), times, joints, commanded, driven)

    def carry_on(self, interval: Interval, commanded: Mapping[str, Array], driven: Mapping[str, Array]) -> Executed:
        """Let an interval take place whose path has a row for every sample, as some motions go on beyond it."""
        self.begin(interval.mode)
        times = self.time + np.linspace(0.0, interval.path.duration, interval.path.samples)
        joints = {name: rows[:, 7:] for name, rows in interval.path.modules.items()}
        return self._took_place(interval, times, joints, commanded, driven)

    def _took_place(
        self, interval: Interval, times: Array, joints: Mapping[str, Array], commanded: Mapping[str, Array],
        driven: Mapping[str, Array],
    ) -> Executed:  # fmt: skip
        own = {body: self.body_poses(body, times) for body in sorted(self.on_course)}
        before = self.reached
        poses = carried(self.problem, interval.mode, joints, before.configuration, own, interval.path)
        bodies = {name: rows for name, rows in poses.items() if name in self.problem.world.bodies and len(rows) > 1}
        modules = {name: poses[name] for name in self.problem.world.modules}
        executed = Executed(
            interval, before, times, modules, dict(joints), bodies, dict(commanded), dict(driven)
        )  # fmt: skip
        self.time = float(times[-1])
        self.reached = replace(before, configuration=_last(executed, before.configuration))
        return executed

    def drives_miss(self, error: Array, times: Array) -> Array:
        """How far joints that move are from where they are told to be, `(T, n)`, `error` `(n,)` at
        first."""
        return np.tile(error, (len(times), 1)) if self.noise == EXACT else missed(
            self.noise, self._random, error, times
        )  # fmt: skip

    def _errors(self, path: PhasePath, times: Array) -> dict[str, Array]:
        """How far joints are from where `path` has them at `times`, `(T, n)`: at first as far as they are now."""
        found = {}
        for name, rows in path.modules.items():
            error = self.reached.configuration.modules[name][7:] - rows[0, 7:]
            driven = moves(rows) and self.noise != EXACT
            off = missed(self.noise, self._random, error, times) if driven else np.tile(error, (len(times), 1))
            found[name] = coupled(self.problem.world.modules[name].type.joints, rows[0, 7:] + off) - rows[0, 7:]
        return found


def moves(rows: Array) -> bool:
    """Whether joints move along `rows` `(S + 1, 7 + n)` of a motion; resampling leaves traces where they rest."""
    return bool(np.ptp(rows[:, 7:], axis=0).max(initial=0.0) > STILL)


def missing(path: PhasePath, errors: Mapping[str, Array], *, settled: bool) -> PhasePath:
    """A motion that ends where `errors` `(T, n)` lead it, or that `settled` where it should, and goes there from the
    first of them without haste."""
    modules = {}
    for name, rows in path.modules.items():
        share = np.linspace(0.0, 1.0, len(rows))[:, None]
        first, last = errors[name][0], errors[name][-1]
        if settled and moves(rows):
            last = np.zeros_like(last)
        values = rows[:, 7:] + first + (3.0 * share**2 - 2.0 * share**3) * (last - first)
        modules[name] = np.hstack([rows[:, :7], values])
    return PhasePath(modules, path.bodies, path.duration)


def sampled(path: PhasePath, times: Array) -> dict[str, Array]:
    """Joint values `(T, n)` of all modules at `times` since the start of a motion."""
    return {name: spline_values(rows[:, 7:], path.duration, times) for name, rows in path.modules.items()}


def _last(executed: Executed, configuration: Configuration) -> Configuration:
    modules = {m: np.concatenate([executed.poses[m][-1], executed.joints[m][-1]]) for m in executed.poses}
    return configuration.then(modules, {b: rows[-1] for b, rows in executed.bodies.items()})


def spline_values(knots: Array, duration: float, times: Array, derivative: int = 0) -> Array:
    """Joint values `(T, n)`, or their derivatives, of the clamped spline through equidistant `knots` `(S + 1, n)`."""
    if knots.shape[1] == 0:
        return np.zeros((len(times), 0))
    at = np.linspace(0.0, duration, len(knots))
    return ClampedSpline(at, knots)(times, derivative)


def carried(
    problem: ir.Problem, mode: frozenset[ir.Fact], joints: Mapping[str, Array], before: Configuration,
    own: Mapping[str, Array], path: PhasePath | None = None,
) -> dict[str, Array]:  # fmt: skip
    """Poses `(T, 7)` of all modules, and of all bodies (`(1, 7)` of those at rest), for joint values `(T, n)`.

    `own` holds the poses of the bodies that move by themselves. `before` is a configuration in which all that the mode
    keeps is where it is kept. What nothing holds goes as `path` says, else it stays where it was.
    """
    pairs = kept_pairs(problem, mode)
    following = {follower for _, follower in pairs}
    known = dict(own)
    for name, body in problem.world.bodies.items():
        if name not in known and not (body.movable and name in following):
            known[name] = before.bodies[name][None, :]
    count = max([1, *(len(rows) for rows in joints.values()), *(len(rows) for rows in own.values())])
    linker = Linker(problem, joints, before, known, count)
    linker.follow(mode)
    poses = linker.poses
    free = {} if path is None else {**{m: rows[:, :7] for m, rows in path.modules.items()}, **path.bodies}
    resting = {**{m: state[:7] for m, state in before.modules.items()}, **before.bodies}
    for name in resting.keys() - poses.keys():
        rows = free.get(name)
        if rows is None or len(rows) < 2:
            poses[name] = np.tile(resting[name], (count, 1))
        else:
            shares = np.linspace(0.0, 1.0, len(rows))
            poses[name] = between(shares, rows, np.linspace(0.0, 1.0, count))
    return poses
