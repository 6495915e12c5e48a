"""The motion of a plan at any time: joints from the stored splines, poses smoothly between the stored samples.

Of each module the frame that moves least in a phase, such as that of the end it stands on, is interpolated, and the
module follows from its joints; so what rests at the samples rests between them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ...compiler import ir
from ..plan import Plan
from .geometry import Array, Frames, frames, nearest_rotations
from .happenings import Happenings
from .kinematics import Kinematics, Motion
from .splines import Spline

IDENTITY = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


@dataclass(frozen=True, slots=True)
class Placement:
    """World frames, at some times, of everything that carries shapes: per module by joint, per body."""

    times: Array
    modules: dict[str, dict[int, Frames]]
    bodies: dict[str, Frames]


class Sampler:
    """Samples the phases of a plan. `fixed` holds the one frame `(1,)` of every body that never moves."""

    def __init__(
        self, problem: ir.Problem, plan: Plan, motion: Motion, kinematics: Mapping[str, Kinematics],
        happenings: Happenings,
    ) -> None:  # fmt: skip
        self._motion = motion
        self._world = problem.world
        self._happenings = happenings
        self._kinematics = kinematics
        self._joints: dict[tuple[str, int], Spline] = {
            (s.module, s.first): Spline(s.knots, s.values, clamped=True)
            for s in plan.splines
            if kinematics[s.module].module.joints
        }
        self._knots = [
            max((len(s.knots) for s in plan.splines if s.first == p), default=2) for p in range(len(plan.phases))
        ]
        self.fixed = {
            name: motion.frames[name][:1]
            for name in motion.poses
            if name not in motion.moving and name not in happenings.courses
        }
        self._carried: dict[tuple[str, int], tuple[str, Spline]] = {}

    def grid(self, phase: int, looks: int) -> Array:
        """The stored times of a phase, with each interval cut so that at least `looks` fall on every knot interval of
        the splines."""
        first, last = self._motion.ranges[phase]
        stored = self._motion.times[first : last + 1]
        count = len(stored) - 1
        factor = max(1, -(-looks * (self._knots[phase] - 1) // count))
        return np.interp(np.arange(factor * count + 1) / factor, np.arange(count + 1), stored)

    def at(self, phase: int, times: Array, thing: str | None = None) -> Placement:
        """Everything, or one thing alone, at `times` `(T,)` of a phase. What rests in it has one frame."""
        names = [n for n in self._motion.poses if n not in self.fixed] if thing is None else [thing]
        modules = {name: self._module(name, phase, times) for name in names if name in self._kinematics}
        bodies = {name: self._body(name, phase, times) for name in names if name not in self._kinematics}
        return Placement(times, modules, self.fixed | bodies)

    def _body(self, name: str, phase: int, times: Array) -> Frames:
        if name in self._happenings.free[phase]:
            return self._happenings.placed(self._world.bodies[name], times)
        first, last = self._motion.ranges[phase]
        if self._happenings.carrier[phase].get(name) is None and self._motion.rests(name, first, last):
            return self._motion.frames[name][slice(first, first + 1)]
        return self._follow(name, name, phase)(times)

    def _module(self, name: str, phase: int, times: Array) -> dict[int, Frames]:
        kinematics = self._kinematics[name]
        curve = self._joints.get((name, phase))
        rest = self._motion.joints[name][self._motion.ranges[phase][0]]
        joints = np.tile(rest, (len(times), 1)) if curve is None else curve(times)
        local = kinematics.joint_frames(np.tile(IDENTITY, (len(times), 1)), joints)
        steady = self._steadiest(name, phase)
        held = self._follow(name, steady, phase)(times)
        if steady == name:
            base = held
        else:
            end = kinematics.effector(steady.rpartition(".")[2], local)
            base = held.compose(frames(IDENTITY).relative_to(end))
        return {index: base.compose(frame) for index, frame in local.items()}

    def _steadiest(self, name: str, phase: int) -> str:
        effectors = self._kinematics[name].module.effectors
        names = [*(f"{name}.{e.name}" for e in effectors), name]

        def travel(frame: str) -> float:
            points = self._stored(name, frame, phase).position
            return float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))

        return min(names, key=travel)

    def _follow(self, thing: str, frame: str, phase: int) -> Callable[[Array], Frames]:
        """The stored motion of a frame within a phase as a smooth curve, as seen from the moving body that carries it,
        if any."""
        key = (thing, phase)
        if key not in self._carried:
            first, last = self._motion.ranges[phase]
            stored = self._stored(thing, frame, phase)
            rows = np.hstack([stored.position, stored.rotation.reshape(-1, 9)])
            knots = self._motion.times[first : last + 1]
            self._carried[key] = (frame, Spline(knots, rows, clamped=False))
        curve = self._carried[key][1]
        carrier = self._happenings.carrier[phase].get(thing)

        def sample(times: Array) -> Frames:
            rows = curve(times)
            own = Frames(rows[:, :3], nearest_rotations(rows[:, 3:].reshape(-1, 3, 3)))
            if carrier is None:
                return own
            return self._happenings.placed(self._world.bodies[carrier], times).compose(own)

        return sample

    def _stored(self, thing: str, frame: str, phase: int) -> Frames:
        """The samples of a frame in a phase, as seen from the moving body that carries the thing, if any."""
        first, last = self._motion.ranges[phase]
        stored = self._motion.frames[frame][slice(first, last + 1)]
        carrier = self._happenings.carrier[phase].get(thing)
        if carrier is None:
            return stored
        return stored.relative_to(self._motion.frames[carrier][slice(first, last + 1)])
