"""Resampling of phase motions: joints by the clamped spline, poses by chaining kinematics from what stands still."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...compiler.ir import IDENTITY, Fact, Module, Problem
from ...compiler.kept_pairs import kept_pairs
from ..skeleton import Configuration, PhasePath
from .attachments import followers, standing
from .splines import ClampedSpline
from .transforms import Array, compose, inverse, joint_frames


def effector_poses(module: Module, effector: str, joints: Array) -> Array:
    """Poses `(T, 7)` of an effector in its module frame for joint values `(T, n)`."""
    end = module.type.effector(effector)
    frames = joint_frames(module.type.joints, np.tile(IDENTITY, (len(joints), 1)), joints)
    return compose(frames[end.joint + 1], np.asarray(end.placement))


@dataclass(slots=True)
class Resampled:
    """One phase: `times` `(T,)`, per module poses `(T, 7)` and joints `(T, n)`, per moving body poses `(T, 7)`."""

    times: Array
    poses: dict[str, Array]
    joints: dict[str, Array]
    bodies: dict[str, Array]

    def end(self, start: Configuration) -> Configuration:
        """Where everything is at the end."""
        modules = {m: np.concatenate([self.poses[m][-1], self.joints[m][-1]]) for m in self.poses}
        return start.then(modules, {b: p[-1] for b, p in self.bodies.items()})


class EffectorPoses:
    """Poses of effectors in their module frames while joints go through some `phases`, those of all phases found at
    once: it takes little longer than for one."""

    def __init__(self, problem: Problem, phases: Sequence[Mapping[str, Array]]) -> None:
        self._problem, self._phases = problem, phases
        self._found: dict[str, tuple[Array, Array]] = {}

    def during(self, name: str, phase: int) -> Array:
        """Those of effector `name` in a phase, `(T, 7)`."""
        if name not in self._found:
            end = self._problem.world.effector(name)
            assert end is not None
            rows = [joints[end[0].name] for joints in self._phases]
            ends = np.cumsum([0, *map(len, rows)])
            self._found[name] = effector_poses(end[0], end[1].name, np.concatenate(rows)), ends
        poses, ends = self._found[name]
        return poses[ends[phase] : ends[phase + 1]]

    def before(self, name: str, phase: int) -> Array | None:
        """That of effector `name` where a phase begins, `(1, 7)`; None at the very start."""
        return self.during(name, phase - 1)[-1:] if phase else None


def resample_all(
    problem: Problem, modes: Sequence[frozenset[Fact]], paths: Sequence[PhasePath], start: Configuration, factor: int
) -> list[Resampled]:
    """As `resample`, of phases one after the other, the first of which begins at `start`."""
    times = [_times(path, factor) for path in paths]
    joints = [_joints(path, at) for path, at in zip(paths, times, strict=True)]
    ends, now, begin = EffectorPoses(problem, joints), start, 0.0
    found: list[Resampled] = []
    for phase, (mode, path) in enumerate(zip(modes, paths, strict=True)):
        found.append(_followed(problem, mode, path, now, begin, times[phase], joints[phase], (ends, phase)))
        now, begin = found[-1].end(now), float(found[-1].times[-1])
    return found


def resample(
    problem: Problem, mode: frozenset[Fact], path: PhasePath, start: Configuration, begin: float, factor: int
) -> Resampled:
    """Sample one phase `factor` times as densely. Poses begin at `start` and follow the joints through whatever
    the mode holds fixed; only what nothing holds is interpolated."""
    times = _times(path, factor)
    return _followed(problem, mode, path, start, begin, times, _joints(path, times), None)


def _times(path: PhasePath, factor: int) -> Array:
    return np.linspace(0.0, path.duration, factor * (path.samples - 1) + 1)


def _joints(path: PhasePath, times: Array) -> dict[str, Array]:
    knots = np.linspace(0.0, path.duration, path.samples)
    return {m: ClampedSpline(knots, rows[:, 7:])(times) for m, rows in path.modules.items()}


def _followed(
    problem: Problem, mode: frozenset[Fact], path: PhasePath, start: Configuration, begin: float, times: Array,
    joints: dict[str, Array], known: tuple[EffectorPoses, int] | None,
) -> Resampled:  # fmt: skip
    knots = np.linspace(0.0, path.duration, path.samples)
    named = [b for pair in kept_pairs(problem, mode) for b in pair if b in start.bodies and b not in path.bodies]
    linker = Linker(problem, joints, start, {b: start.bodies[b][None, :] for b in named}, len(times), known)
    linker.follow(mode)
    poses = {m: linker.poses.get(m) for m in path.modules}
    bodies = {b: linker.poses.get(b) for b in path.bodies}
    return Resampled(
        begin + times,
        {m: p if p is not None else between(knots, path.modules[m][:, :7], times) for m, p in poses.items()},
        joints,
        {b: p if p is not None else between(knots, path.bodies[b], times) for b, p in bodies.items()},
    )


def followed(problem: Problem, mode: frozenset[Fact], start: Configuration, end: Configuration) -> Configuration:
    """A configuration at the `end` of a phase in which a mode holds, with what it keeps exactly where it was at its
    `start`: where solvers are right to some digits only, nothing adds up so from phase to phase."""
    joints = {name: slot[None, 7:] for name, slot in end.modules.items()}
    named = (b for pair in kept_pairs(problem, mode) for b in pair if b in problem.world.bodies)
    own = {b: end.bodies[b][None, :] for b in named if b not in followers(problem, mode)}
    linker = Linker(problem, joints, start, own, 1)
    linker.follow(mode)
    modules = {
        name: np.concatenate([linker.poses[name][0], slot[7:]]) if name in linker.poses else slot
        for name, slot in end.modules.items()
    }
    return end.then(modules, {b: linker.poses[b][0] for b in followers(problem, mode) if b in linker.poses})


def between(knots: Array, poses: Array, times: Array) -> Array:
    """Positions linear, quaternions linear and normalised, between samples of what nothing holds."""
    signs = np.cumprod(np.where(np.sum(poses[1:, 3:] * poses[:-1, 3:], axis=1) < 0, -1.0, 1.0))
    rows = poses.copy()
    rows[1:, 3:] *= signs[:, None]
    result = np.column_stack([np.interp(times, knots, column) for column in rows.T])
    result[:, 3:] /= np.linalg.norm(result[:, 3:], axis=1, keepdims=True)
    return result


class Linker:
    """Finds the `poses` of everything that is linked, through kept poses, to what stands still, or whose `own` poses,
    `(1, 7)` or `(count, 7)`, are known. `start` is the configuration in which linked things are as they are kept;
    `known` are poses of effectors for these very joints, and the phase that they go through."""

    def __init__(
        self, problem: Problem, joints: Mapping[str, Array], start: Configuration, own: Mapping[str, Array], count: int,
        known: tuple[EffectorPoses, int] | None = None,
    ) -> None:  # fmt: skip
        self._problem = problem
        self._joints = joints
        self._start = start
        self._count = count
        self._known = known
        self.poses: dict[str, Array] = dict(own)

    def follow(self, mode: frozenset[Fact]) -> None:
        """Take each pair that the mode keeps and of which one side is known, and find the other side's thing, until
        nothing is new."""
        for name in standing(self._problem, mode) - self.poses.keys():
            self.poses[name] = np.tile(self._start.modules[name][:7], (self._count, 1))
        pairs = kept_pairs(self._problem, mode)
        progress = True
        while progress:
            progress = False
            for pair in pairs:
                for known, other in (pair, pair[::-1]):
                    if self._thing(known) in self.poses and self._thing(other) not in self.poses:
                        self._attach(known, other)
                        progress = True

    def _thing(self, name: str) -> str:
        end = self._problem.world.effector(name)
        return name if end is None else end[0].name

    def _local(self, name: str) -> Array:
        """Where an object is in its thing while that moves."""
        end = self._problem.world.effector(name)
        if end is None:
            return np.array([IDENTITY])
        if self._known is not None:
            return self._known[0].during(name, self._known[1])
        return effector_poses(end[0], end[1].name, self._joints[end[0].name])

    def _local_at_start(self, name: str, joints: Array) -> Array:
        end = self._problem.world.effector(name)
        if end is None:
            return np.array([IDENTITY])
        known = None if self._known is None else self._known[0].before(name, self._known[1])
        return effector_poses(end[0], end[1].name, joints) if known is None else known

    def _at_start(self, name: str) -> Array:
        thing = self._thing(name)
        if thing in self._start.bodies:
            return self._start.bodies[thing][None, :]
        row = self._start.modules[thing]
        return compose(row[None, :7], self._local_at_start(name, row[None, 7:]))

    def _attach(self, known: str, other: str) -> None:
        relative = compose(inverse(self._at_start(known)), self._at_start(other))
        thing, base = self._thing(other), self._thing(known)
        carrier = self.poses[base]
        if base in self._joints:
            carrier = compose(carrier, self._local(known))
        held = compose(carrier, relative)
        if thing in self._joints:
            held = compose(held, inverse(self._local(other)))
        self.poses[thing] = np.broadcast_to(held, (self._count, 7)).copy()
