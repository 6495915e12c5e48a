"""Motions that are underway at once: where everything is while some robots move on and others stop.

All begins, ends and switches are ticks since `origin`. A motion has a row for every tick, and begins and ends at rest,
so that with the rest before and behind it is one spline.
"""

from __future__ import annotations

import math
from dataclasses import field

import numpy as np

from ...compiler import ir
from ...langs.frozen import dataclass
from ..geometry.transforms import coupled
from ..planner.schedule.dependencies import Segment
from ..planner.schedule.even_splines import at_rest
from ..planner.schedule.settings import SCHEDULE
from ..skeleton import Array, Configuration, Phase, PhasePath
from .braking import at_times, braking_time, resting, within_limits
from .settings import SIMULATION
from .world import Interval, SimulatedWorld, carried

TICK = SCHEDULE.tick

@dataclass(slots=True, eq=False)
class MotionUnderway:
    """The motion of one phase, which begins at the tick `start`; its `switch` comes at another one, or not at all
    (None), once the motion was broken off. It waits for those `behind` it to come first. Joints are told to be at
    `told` `(T, n)`, the plan file has them at `kept`, and drives are at `driven`."""

    phase: Phase
    segment: Segment
    start: int
    switch: int | None
    named: frozenset[str]
    behind: list[MotionUnderway] = field(default_factory=list)
    told: dict[str, Array] = field(default_factory=dict)
    kept: dict[str, Array] = field(default_factory=dict)
    driven: dict[str, Array] = field(default_factory=dict)

    @property
    def end(self) -> int:
        """The tick at which it comes to rest."""
        return self.start + self.segment.ticks

    def alone(self, now: Configuration) -> PhasePath:
        """Its path, on which all that it does not move rests where it is `now`."""
        path = self.segment.path
        modules = {
            name: path.modules[name] if name in self.segment.moved else np.tile(state, (path.samples, 1))
            for name, state in now.modules.items()
        }
        bodies = {name: rows for name, rows in path.bodies.items() if name in self.segment.moved}
        return PhasePath(modules, bodies, path.duration)

    def drive(self, world: SimulatedWorld, now: Configuration) -> None:
        """Begin where the joints are `now`, and miss what drives miss."""
        share = np.linspace(0.0, 1.0, self.segment.ticks + 1)[:, None]
        fading = 1.0 - share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        for name in sorted(self.segment.moved & now.modules.keys()):
            told = self.segment.path.modules[name][:, 7:]
            error = now.modules[name][7:] - told[0]
            times = _seconds(0, len(told) - 1)
            joints = world.problem.world.modules[name].type.joints
            self.told[name] = told
            if not np.ptp(told, axis=0).any():
                self.kept[name] = self.driven[name] = told + error
                continue
            self.kept[name] = coupled(joints, _rested(told + fading * error)) if error.any() else told
            self.driven[name] = coupled(joints, told + world.drives_miss(error, times))

    def broken_off(self, world: SimulatedWorld, tick: int, exact: bool = False) -> MotionUnderway | None:
        """The same until a tick, and then to rest along its path, at once; None where it is too late for that. With
        `exact` drives miss nothing."""
        gone = tick - self.start
        slowed = slowed_on_ticks(world.problem.world, self.segment.path, gone)
        if slowed is None:
            return None
        ticks = slowed.samples - 1
        segment = Segment(self.segment.phase, self.segment.moved, self.segment.held, slowed, ticks)
        found = MotionUnderway(self.phase, segment, self.start, None, self.named, self.behind)
        if exact:
            return found
        share = np.linspace(0.0, 1.0, ticks - gone + 1)[:, None]
        rising = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        for name, told in self.told.items():
            joints = world.problem.world.modules[name].type.joints
            braked = slowed.modules[name][:, 7:]
            off = self.driven[name][gone] - told[gone]
            if not np.ptp(told, axis=0).any():
                found.told[name] = braked
                found.kept[name] = found.driven[name] = braked + off
                continue
            missed = braked[gone:] + world.drives_miss(off, _seconds(0, ticks - gone))
            shift = self.kept[name][gone] - told[gone]
            last = missed[-1] - braked[-1]
            kept = braked[gone:] + shift + rising * (last - shift)
            kept = np.concatenate([self.kept[name][:gone], kept])
            found.told[name] = braked
            found.kept[name] = coupled(joints, _rested(kept) if last.any() or shift.any() else kept)
            found.driven[name] = np.concatenate([self.driven[name][:gone], coupled(joints, missed)])
        return found


def slowed_on_ticks(world: ir.World, path: PhasePath, gone: int) -> PhasePath | None:
    """The motion that follows `path`, with knots at ticks, for so many of them and then comes to rest along it."""
    seconds, left = gone * TICK, path.duration - gone * TICK
    length = braking_time(world, path, seconds)
    for _ in range(SIMULATION.brake_tries):
        ticks = gone + math.ceil(length / TICK)
        length = ticks * TICK - seconds
        if length >= 2.0 * left:
            break
        times = np.minimum(resting(_seconds(0, ticks), seconds, length), path.duration)
        slowed = at_times(path, times, ticks * TICK)
        for rows in slowed.modules.values():
            rows[:, 7:] = _rested(rows[:, 7:])
        if within_limits(world, slowed):
            return slowed
        length *= SIMULATION.brake_growth
    return None


def _seconds(first: int, last: int) -> Array:
    """Those of some ticks."""
    return np.linspace(first * TICK, last * TICK, last - first + 1)


def _rested(rows: Array) -> Array:
    """Rows whose spline has no acceleration at its ends."""
    return at_rest(rows) if len(rows) > 4 and rows.shape[1] else rows


class Underway:
    """The motions of a world that have begun, in the order of their begins; `done` is the tick up to which they took
    place, the others lie ahead."""

    def __init__(self, world: SimulatedWorld) -> None:
        self._world = world
        self.motions: list[MotionUnderway] = []
        self.origin, self.done, self.now = world.time, 0, 0

    @property
    def active(self) -> list[MotionUnderway]:
        """Those whose switch is to come, in the order of their switches."""
        found = [(m.switch, k, m) for k, m in enumerate(self.motions) if m.switch is not None]
        return [m for _, _, m in sorted(found, key=lambda f: f[:2])]

    @property
    def open(self) -> bool:
        """Whether something has not taken place yet."""
        return self.now > self.done or any(m.end > self.done for m in self.motions)

    def restart(self) -> None:
        """Count ticks anew, from now on; nothing may be underway."""
        self.motions.clear()
        self.origin, self.done, self.now = self._world.time, 0, 0

    def time(self, tick: int) -> float:
        """Seconds since the start of the run."""
        return self.origin + tick * TICK

    def configuration(self, tick: int) -> Configuration:
        """Where everything is at a tick that lies ahead, or has just come."""
        world, span = self._world, (self.done, max(tick, self.done + 1))
        path, _, _ = self._rows(*span)
        at = tick - self.done
        now, mode = world.reached.configuration, world.reached.mode
        joints = {name: rows[:, 7:] for name, rows in path.modules.items()}
        times = self.origin + _seconds(*span)
        own = {body: world.body_poses(body, times) for body in sorted(world.on_course)}
        poses = carried(world.problem, mode, joints, now, own, path)
        poses = {name: rows[min(at, len(rows) - 1)] for name, rows in poses.items()}
        modules = {name: np.concatenate([poses[name], joints[name][at]]) for name in now.modules}
        return Configuration(modules, {name: poses.get(name, pose) for name, pose in now.bodies.items()})

    def before(self) -> Configuration:
        """Where everything would be now had the active motions not begun."""
        found = self.configuration(self.now).copy()
        for motion in self.active:
            path = motion.segment.path
            for name in motion.segment.moved:
                if name in path.modules:
                    found.modules[name] = path.modules[name][0]
                else:
                    found.bodies[name] = path.bodies[name][0]
        return found

    def interval(
        self, phase: Phase, tick: int, *, completed: bool
    ) -> tuple[Interval, dict[str, Array], dict[str, Array]]:
        """What takes place up to a tick, and where joints are told to be and are driven meanwhile."""
        path, told, driven = self._rows(self.done, tick)
        through = frozenset(
            name for m in self.motions if m.start < tick < m.end for name in m.segment.moved & path.modules.keys()
        )
        added = phase.added if completed else frozenset[ir.Fact]()
        interval = Interval(phase.action, self._world.reached.mode, added, path, completed, through)
        return interval, told, driven

    def took_place(self, tick: int) -> None:
        """All up to a tick has taken place."""
        self.done = tick
        self.motions = [m for m in self.motions if m.end > tick or m.switch is not None]

    def _rows(self, first: int, last: int) -> tuple[PhasePath, dict[str, Array], dict[str, Array]]:
        """The rows of all modules at these ticks, as they are kept, told and driven."""
        now, count = self._world.reached.configuration, last - first + 1
        modules = {name: np.tile(state, (count, 1)) for name, state in now.modules.items()}
        told = {name: rows[:, 7:].copy() for name, rows in modules.items()}
        driven = {name: rows[:, 7:].copy() for name, rows in modules.items()}
        bodies: dict[str, Array] = {}
        for motion in self.motions:
            at = np.clip(np.arange(first, last + 1) - motion.start, 0, motion.segment.ticks)
            later = (np.arange(first, last + 1) >= motion.start)[:, None]
            path = motion.segment.path
            for name in motion.told:
                poses = np.where(later, path.modules[name][at, :7], modules[name][:, :7])
                kept = np.where(later, motion.kept[name][at], modules[name][:, 7:])
                modules[name] = np.hstack([poses, kept])
                told[name] = np.where(later, motion.told[name][at], told[name])
                driven[name] = np.where(later, motion.driven[name][at], driven[name])
            for name in motion.segment.moved & path.bodies.keys():
                rows = bodies.get(name, np.tile(now.bodies[name], (count, 1)))
                bodies[name] = np.where(later, path.bodies[name][at], rows)
        return PhasePath(modules, bodies, (last - first) * TICK), told, driven
