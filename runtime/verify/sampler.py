"""The motion of a plan at any time: joints from the stored splines, and everything else from what it holds on to.

Nothing here looks at the stored samples, but at the first of each phase, where its motion begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from ...compiler import ir
from ...compiler.distinct import distinct
from ...langs.frozen import dataclass
from ..plan import Plan
from .geometry import Array, Frames, Indices, frames
from .happenings import Happenings
from .kinematics import Kinematics, Motion
from .links import Hold, Links
from .splines import Spline

IDENTITY = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
LOOKS = 8
"""Instants per knot interval of the splines, before any closer look: how many cost least on the examples, no more."""
LONGEST = 0.25
"""Seconds between instants where no joint moves, but a body on its course."""
INSTANT = 1e-8
"""Seconds: a body that jumps is looked at this long before, and right after; there is no motion between."""
SAME = 1e-9
"""Seconds by which two instants differ that are the same, but for rounding."""
PART = 1500
"""So many instants of a phase at most are looked at together, for the sake of memory."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Instants `times` `(T,)` of a phase, and whether the stretch from each to the next, `joined` `(T - 1,)`, is part
    of it. No spline has a knot, and no course a corner, inside a stretch."""

    times: Array
    joined: np.typing.NDArray[np.bool_]

    @property
    def lengths(self) -> Array:
        """The lengths of the stretches `(T - 1,)`, seconds."""
        return np.diff(self.times)

    def halved(self, stretches: Indices) -> Grid:
        """Both halves of some of the stretches."""
        low, high = self.times[stretches], self.times[stretches + 1]
        times = np.column_stack([low, 0.5 * (low + high), high]).ravel()
        return Grid(times, np.tile([True, True, False], len(stretches))[:-1])

    def parts(self) -> Iterable[Grid]:
        """The same, at most `PART` stretches at a time."""
        for first in range(0, max(1, len(self.joined)), PART):
            yield Grid(self.times[first : first + PART + 1], self.joined[first : first + PART])


class Placement:
    """Where things are at some times, `(T,)`, or at all of them where they rest: then their frames are `(1,)`."""

    def __init__(self, sampler: Sampler, phase: int, times: Array) -> None:
        self.times = times
        self._sampler, self._phase = sampler, phase
        self._placed: dict[str, Mapping[int, Frames]] = {}

    def thing(self, name: str) -> Mapping[int, Frames]:
        """The world frames of a module by joint; -1 is that of the module, or of a body."""
        for thing in self._sampler.line(name, self._phase):
            if thing not in self._placed:
                self._placed[thing] = self._sampler.place(self, self._phase, thing)
        return self._placed[name]

    def frame(self, name: str) -> Frames:
        """The world frame of an object: a module, a body or an effector."""
        thing, joint, placement = self._sampler.mount(name)
        found = self.thing(thing)[joint]
        return found if placement is None else found.compose(placement)


class Shown:
    """A placement in which every frame is given at all times `(T,)`."""

    def __init__(self, placement: Placement, modules: Mapping[str, Kinematics]) -> None:
        self._placement, self._modules = placement, modules

    def frame(self, name: str) -> Frames:
        """The frames `(T,)` of an object."""
        return self._placement.frame(name).spread(len(self._placement.times))

    def parts(self, name: str) -> Mapping[int, Frames] | None:
        """The frames `(T,)` of a module by joint; None of what is no module."""
        if name not in self._modules:
            return None
        count = len(self._placement.times)
        return {joint: frame.spread(count) for joint, frame in self._placement.thing(name).items()}


class Sampler:
    """The motion of all phases of a plan. `links` says what follows what in each of them, `curves` are the splines of
    modules by phase; of the samples in `motion` only the first of each phase counts."""

    def __init__(
        self, world: ir.World, motion: Motion, kinematics: Mapping[str, Kinematics], happenings: Happenings,
        links: Sequence[Links], curves: Mapping[tuple[str, int], Spline],
    ) -> None:  # fmt: skip
        self._world = world
        self._motion = motion
        self.kinematics = kinematics
        self.happenings = happenings
        self.links = links
        self.curves = curves
        self._still: dict[tuple[str, int], bool] = {}
        self._followed: dict[tuple[str, int], tuple[str, ...]] = {}
        self._mounts = _mounts(world)
        self._rested: dict[str, tuple[bytes, Mapping[int, Frames]]] = {}

    def mount(self, name: str) -> tuple[str, int, Frames | None]:
        """The thing that an object is part of, the joint that carries it, and where it is in the frame of that."""
        return self._mounts[name]

    def curve(self, module: str, phase: int) -> Spline | None:
        """The spline of the joints of a module in a phase; None where they rest."""
        curve = self.curves.get((module, phase))
        return None if curve is None or curve.constant else curve

    def line(self, thing: str, phase: int) -> tuple[str, ...]:
        """A thing after all that it follows, from what rests or is on its course: not by recursion, for robots are
        long."""
        key = thing, phase
        if key not in self._followed:
            found = [thing]
            while (hold := self.links[phase].hold(found[-1])) is not None and hold.base:
                found.append(self.mount(hold.base)[0])
            self._followed[key] = tuple(found[::-1])
        return self._followed[key]

    def rests(self, thing: str, phase: int) -> bool:
        """Whether a thing keeps its place for the whole phase, by its joints and what it follows."""
        key = thing, phase
        if key not in self._still:
            line = self.line(thing, phase)
            on_course = self.links[phase].hold(line[0]) is None
            self._still[key] = not on_course and all(self.curve(name, phase) is None for name in line)
        return self._still[key]

    def grid(self, phase: int) -> Grid:
        """Instants at which a phase is looked at, whatever its samples: evenly in time, at all knots of the splines
        that move, and where courses have corners."""
        first, last = self._motion.ranges[phase]
        start, end = (float(t) for t in self._motion.times[[first, last]])
        curves = [c for name in self.kinematics if (c := self.curve(name, phase)) is not None]
        steps = [float(np.diff(c.knots).min()) / LOOKS for c in curves]
        free = self.happenings.free[phase]
        steps += [LONGEST] if free else []
        count = int(np.ceil((end - start) / min(steps) - INSTANT)) if steps else 1
        marks, jumps = [np.linspace(start, end, count + 1), *(c.knots for c in curves)], [np.zeros(0)]
        for name in sorted(free):
            course = self.happenings.courses[name]
            marks.append(course.corners(start, end))
            jumps.append(course.jumps(start, end))
        jumped = np.concatenate(jumps)
        times = distinct(np.concatenate([*marks, jumped, jumped - INSTANT]))
        times = times[(times >= start) & (times <= end)]
        times = times[np.concatenate([[True], np.diff(times) > SAME])]
        middle = 0.5 * (times[1:] + times[:-1])
        inside = (middle[:, None] > jumped - INSTANT) & (middle[:, None] < jumped)
        return Grid(times, ~inside.any(axis=1))

    def at(self, phase: int, times: Array) -> Placement:
        """Everything at `times` `(T,)` of a phase."""
        return Placement(self, phase, times)

    def place(self, placement: Placement, phase: int, name: str) -> Mapping[int, Frames]:
        """The frames of a thing at the times of a placement, from those of what it holds on to."""
        hold = self.links[phase].hold(name)
        if hold is None:
            return {-1: self.happenings.placed(self._world.bodies[name], placement.times)}
        end = hold.relative if not hold.base else placement.frame(hold.base).compose(hold.relative)
        if name not in self.kinematics:
            return {-1: end}
        if not self.rests(name, phase):
            return self._moved(hold, end, self._joints(name, phase, placement.times))
        joints = self._joints(name, phase, placement.times[:1])
        key = hold.own.encode() + end.position.tobytes() + end.rotation.tobytes() + joints.tobytes()
        if name not in self._rested or self._rested[name][0] != key:
            self._rested[name] = key, self._moved(hold, end, joints)
        return self._rested[name][1]

    def _moved(self, hold: Hold, end: Frames, joints: Array) -> Mapping[int, Frames]:
        """The frames of a module whose frame `hold.own` is at `end`."""
        local = self.kinematics[hold.thing].joint_frames(np.array([IDENTITY]), joints)
        _, joint, placement = self.mount(hold.own)
        own = local[joint] if placement is None else local[joint].compose(placement)
        base = end.compose(frames(IDENTITY).relative_to(own))
        return {index: base.compose(frame) for index, frame in local.items()}

    def _joints(self, name: str, phase: int, times: Array) -> Array:
        curve = self.curves.get((name, phase))
        if curve is not None:
            return curve(times)
        first, _ = self._motion.ranges[phase]
        return np.broadcast_to(self._motion.joints[name][first], (len(times), self._motion.joints[name].shape[1]))


def curves_of(plan: Plan, tick: Callable[[], None] = lambda: None) -> dict[tuple[str, int], Spline]:
    """The spline of a module in each phase in which it has one; one and the same where it goes through several. `tick`
    is called for each spline."""
    widths = {m.name: len(m.joints) for m in plan.modules}
    found: dict[tuple[str, int], Spline] = {}
    for record in plan.splines:
        tick()
        if widths[record.module]:
            curve = Spline(record.knots, record.values)
            found |= {(record.module, phase): curve for phase in range(record.first, record.until + 1)}
    return found


def _mounts(world: ir.World) -> dict[str, tuple[str, int, Frames | None]]:
    things = (*world.modules, *world.bodies)
    found: dict[str, tuple[str, int, Frames | None]] = {name: (name, -1, None) for name in things}
    for module in world.modules.values():
        for effector in module.type.effectors:
            found[f"{module.name}.{effector.name}"] = module.name, effector.joint, frames(effector.placement)
    return found
