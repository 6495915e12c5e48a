"""A skeleton: the phases of a plan with the motion literals that bind in each; and poses of everything in a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from dataclasses import field, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from ..compiler.ir import Action, Fact, Problem, World
from ..compiler.remembering import remembered
from ..langs.frozen import dataclass
from ..langs.source import Span

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Phase:
    """One action and the interval that leads to its switch (thesis section 3.1).

    `mode` holds the motion literals that hold during the interval, before the switch: their `keep` and `during` rows
    bind there. `added` holds those that the action adds at its switch: their `at switch` rows bind at the end of the
    interval. `during` rows of literals added here bind from the next phase on.
    """

    action: Action
    mode: frozenset[Fact]
    added: frozenset[Fact]


@dataclass(frozen=True, slots=True)
class Skeleton:
    """Phases 1 … K of a candidate plan; `final_mode` holds the motion literals after the last switch."""

    problem: Problem
    phases: tuple[Phase, ...]
    final_mode: frozenset[Fact]
    coming: tuple[tuple[str, str], ...] = ()
    """Bodies, each with a thing that will be put down on it after the last phase: room must be left for it."""

    def __len__(self) -> int:
        return len(self.phases)


def beginning(skeleton: Skeleton, length: int) -> Skeleton:
    """The first phases of a skeleton."""
    if length >= len(skeleton):
        return skeleton
    return replace(skeleton, phases=skeleton.phases[:length], final_mode=skeleton.phases[length].mode)


class BodyPoses(MutableMapping[str, Array]):
    """Poses `(7,)` of bodies: `own` ones, and those of what never moves, which all configurations of a scene `share`,
    as there are many of both."""

    __slots__ = ("own", "shared")

    def __init__(self, own: dict[str, Array], shared: Mapping[str, Array]) -> None:
        self.own, self.shared = own, shared

    def __getitem__(self, name: str) -> Array:
        found = self.own.get(name)
        return self.shared[name] if found is None else found

    def __setitem__(self, name: str, pose: Array) -> None:
        self.own[name] = pose

    def __delitem__(self, name: str) -> None:
        del self.own[name]

    def __contains__(self, name: object) -> bool:
        return name in self.own or name in self.shared

    def __iter__(self) -> Iterator[str]:
        yield from (name for name in self.shared if name not in self.own)
        yield from self.own

    def __len__(self) -> int:
        return sum(1 for _ in self)


@dataclass(slots=True)
class Configuration:
    """Where everything is at one instant.

    `modules` maps a module to `(7 + n,)`: pose of its module frame (x, y, z, qx, qy, qz, qw; world, metres), then its
    n joint values. `bodies` maps every body, at rest or not, to its pose `(7,)`; those of `BodyPoses` that are shared
    are not to be written to.
    """

    modules: dict[str, Array]
    bodies: MutableMapping[str, Array]

    def copy(self) -> Configuration:
        bodies = {k: v.copy() for k, v in own_poses(self.bodies).items()}
        return Configuration({k: v.copy() for k, v in self.modules.items()}, _with(self.bodies, bodies))

    def then(self, modules: dict[str, Array], bodies: Mapping[str, Array]) -> Configuration:
        """Where everything is once all modules, and some bodies, are elsewhere."""
        return Configuration(modules, _with(self.bodies, {**own_poses(self.bodies), **bodies}))


def own_poses(bodies: Mapping[str, Array]) -> Mapping[str, Array]:
    """The poses of a configuration that it does not share with others of its scene."""
    return bodies.own if isinstance(bodies, BodyPoses) else bodies


def _with(bodies: Mapping[str, Array], own: dict[str, Array]) -> MutableMapping[str, Array]:
    return BodyPoses(own, bodies.shared) if isinstance(bodies, BodyPoses) else own


def may_differ(one: Configuration, other: Configuration) -> Iterator[str]:
    """The bodies whose poses two configurations do not share."""
    first, second = one.bodies, other.bodies
    if isinstance(first, BodyPoses) and isinstance(second, BodyPoses) and first.shared is second.shared:
        yield from first.own
        yield from (name for name in second.own if name not in first.own)
    else:
        yield from first


@remembered(8)
def fixed_poses(world: World) -> Mapping[str, Array]:
    """The poses at time 0 of the bodies that never move, not to be written to."""
    found = {b.name: np.array(b.pose) for b in world.bodies.values() if not b.movable}
    for pose in found.values():
        pose.flags.writeable = False
    return found


@remembered(8)
def movable(world: World) -> tuple[str, ...]:
    """The bodies that may move."""
    return tuple(b.name for b in world.bodies.values() if b.movable)


def start_configuration(problem: Problem) -> Configuration:
    """The scene at time 0."""
    world = problem.world
    bodies = {name: np.array(world.bodies[name].pose) for name in movable(world)}
    modules = {m.name: np.array([*m.pose, *m.joints]) for m in world.modules.values()}
    return Configuration(modules, BodyPoses(bodies, fixed_poses(world)))


@dataclass(slots=True)
class PhasePath:
    """The motion of one phase, `S + 1` samples from the switch before (sample 0) to its own switch (sample S).

    `modules` maps a module to `(S + 1, 7 + n)`, `bodies` maps a body that moves in this phase to `(S + 1, 7)`, as in
    `Configuration`; bodies that rest are left out. Samples are equidistant in time; `duration` is in seconds.
    Joint values between samples are those of one cubic spline per phase, clamped (zero velocity) at both ends, and
    module poses follow from them.
    """

    modules: dict[str, Array]
    bodies: dict[str, Array]
    duration: float

    @property
    def samples(self) -> int:
        """S + 1; 2, the two ends, where nothing can move."""
        return len(next(iter((*self.modules.values(), *self.bodies.values())), (None, None)))


class Breach(StrEnum):
    """What a violation violates, and whom its names tell: the motion literal itself; two things; two parts of one
    module; a module and its joint; a module (or nothing); a module; a module and its joint, twice; the two objects of
    a kept pair, twice."""

    ROW = "row"
    COLLISION = "collision"
    SELF_COLLISION = "self-collision"
    JOINT_LIMIT = "joint limit"
    STEP = "step"
    DRIFT = "drift"
    UNIT_QUATERNION = "unit quaternion"
    TORQUE = "torque"
    BEARING = "bearing moment"
    DOCK = "dock load"
    FOOT = "foot load"
    SLIP = "slip"
    TIP = "tip"


class Bound(StrEnum):
    """What refuses a skeleton, coarsest first: loads that nothing bears; similar windows that were refused, without a
    solve; P_seq, P_seqPath and P_path."""

    STATICS = "statics"
    EXPECTED = "expected"
    SEQ = "seq"
    SEQ_PATH = "seq-path"
    PATH = "path"


LOADS = frozenset((Breach.TORQUE, Breach.BEARING, Breach.DOCK, Breach.FOOT, Breach.SLIP, Breach.TIP))
"""Breaches that are loads beyond what bears them."""


@dataclass(frozen=True, slots=True)
class Violation:
    """One row that a bound could not satisfy: the phase (from 0), what kind of row, the names that it concerns, the
    figure and unit. `span` is where a row of a motion literal is written. Of a clearance: how far apart the two were
    asked to be, `asked` metres, and which `parts` of the two these are. Of a load: what is borne, the safety, and the
    strength, in `unit`, and `when` in the phase."""

    phase: int
    kind: Breach
    names: tuple[str, ...]
    amount: float
    unit: str
    span: Span | None = field(default=None, compare=False)
    asked: float = field(default=0.0, compare=False)
    parts: tuple[str, ...] = field(default=(), compare=False)
    load: tuple[float, float, float] | None = field(default=None, compare=False)
    when: str = field(default="", compare=False)


@dataclass(slots=True)
class BoundResult:
    """What one bound says about a skeleton. `configurations` are the K + 1 switch configurations, start included
    (P_seq and above); `paths` the K phase motions (P_seqPath and P_path). `violations` is largest first. `cost_before`
    is the cost before feasible motions were polished, None when they were not; `unobstructed` tells that P_seq refuses
    even though nothing counts as in the way; `window` are the first and last of phases that it refuses by themselves,
    where it knows them, wherever they start unless the first is that of all."""

    bound: Bound
    feasible: bool
    cost: float
    seconds: float
    iterations: int
    configurations: list[Configuration]
    paths: list[PhasePath]
    violations: list[Violation]
    cost_before: float | None = None
    unobstructed: bool = False
    window: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class NearestMiss:
    """The posture in which a refused `action` comes nearest to what it needs; the action is empty where none was tried.

    `message` is that of the diagnostic that tells it, `row` what failed, in words. `marked` are the modules, effectors
    and bodies that this concerns, `apart` the two of them between which something is missing, if there are two; `bent`
    modules with the joints that would have to go past their limits.
    """

    action: str
    message: str
    row: str
    marked: tuple[str, ...]
    apart: tuple[str, ...]
    bent: tuple[tuple[str, str], ...]
    posture: Configuration = field(compare=False, repr=False)
