"""What follows what in each phase: from what rests, through poses that are kept, to everything that is carried.

A plan stores joints and, as a drawing, samples of poses. Where modules and bodies truly are follows from the joints and
from the holds found here; `docs/plan-format.md` gives the rule, so that every checker finds the same motion.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field

import numpy as np

from ...compiler import ir
from ...compiler.remembering import remembered
from ...langs.frozen import dataclass
from .geometry import Array, Frames, frames_each
from .happenings import Happenings
from .kept_poses import bolted, kept, thing_of
from .kinematics import Motion


@dataclass(frozen=True, slots=True)
class Hold:
    """How a thing moves in a phase: its frame `own` keeps the pose `relative` `(1,)` to the frame `base` of another
    thing, or in the world where `base` is empty. Both are names of objects."""

    thing: str
    own: str
    base: str
    relative: Frames


@dataclass(frozen=True, slots=True)
class Rest:
    """A group that nothing holds to a fixed body: its frame `name` is the one that rests, and moves by `shift` metres
    and `turn` radians on the stored samples. `others` rest on the samples, too."""

    group: tuple[str, ...]
    name: str
    shift: float
    turn: float
    others: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Links:
    """The holds of one phase, each after that of its base; bodies on their courses have none. All phases share the
    holds of bodies that are `fixed` to the scene, as these may be many."""

    holds: Mapping[str, Hold]
    rests: tuple[Rest, ...]
    pairs: tuple[tuple[str, str], ...]
    """Pairs (carrying, carried) of objects whose relative pose the mode keeps, in order."""
    fixed: Mapping[str, Hold] = field(default_factory=dict)

    def hold(self, thing: str) -> Hold | None:
        """How a thing moves; None of what is on its course."""
        return self.holds.get(thing) or self.fixed.get(thing)

    def explain(self, base: str, own: str) -> bool:
        """Whether a kept pair holds because the motion is made so."""
        return any((hold.base, hold.own) in ((base, own), (own, base)) for hold in self.holds.values())


def links_of(
    problem: ir.Problem, modes: Iterable[Iterable[ir.Fact]], motion: Motion, happenings: Happenings, still: float
) -> list[Links]:
    """The links of every phase, whose relative poses are those of its first sample. A frame counts as resting on the
    samples that moves by less than `still` metres and radians."""
    known: dict[frozenset[ir.Fact], tuple[tuple[str, str], ...]] = {}
    poses = {b.name: b.pose for b in problem.world.bodies.values() if not b.movable}
    fixed = {name: Hold(name, name, "", one) for name, one in frames_each(poses).items()}
    found = []
    for index, mode in enumerate(list(modes)[: len(motion.ranges)]):
        facts = frozenset(mode)
        if facts not in known:
            known[facts] = tuple(kept(problem, facts))
        rest, free = bolted(problem, facts), happenings.free[index]
        kept_there = fixed if not free else {name: hold for name, hold in fixed.items() if name not in free}
        found.append(_Linker(problem, kept_there, rest, known[facts], motion, index, free, still).links())
    return found


class _Linker:
    def __init__(
        self, problem: ir.Problem, fixed: Mapping[str, Hold], rest: Iterable[str],
        pairs: tuple[tuple[str, str], ...], motion: Motion, phase: int, free: frozenset[str], still: float,
    ) -> None:  # fmt: skip
        """`fixed` are the holds of the bodies that never move, `rest` the modules that nothing carries."""
        self._problem, self._motion, self._still = problem, motion, still
        self._first, self._last = motion.ranges[phase]
        self._pairs = pairs
        self._fixed, self._holds = fixed, dict[str, Hold]()
        self._known = {*free}
        self._rests: list[Rest] = []
        for name in rest:
            self._rests.append(Rest((name,), name, *self._movement(name), ()))
            self._hold(name, name, "")

    def links(self) -> Links:
        """Everything in the world, by the first of these that says where it is: a fixed body, a course, what is bolted,
        a kept pose, a frame that rests."""
        self._follow()
        for thing in _loose(self._problem):
            if not self._is_known(thing):
                self._rest(thing)
                self._follow()
        return Links(self._holds, tuple(self._rests), self._pairs, self._fixed)

    def _is_known(self, thing: str) -> bool:
        return thing in self._known or thing in self._fixed

    def _follow(self) -> None:
        """Take each pair of which one side is known, in order, again and again until nothing is new."""
        open_pairs = [(a, b, thing_of(self._problem, a), thing_of(self._problem, b)) for a, b in self._pairs]
        grew = True
        while grew:
            grew = False
            left: list[tuple[str, str, str, str]] = []
            for base, own, carrier, carried in open_pairs:
                if self._is_known(carrier) and self._is_known(carried):
                    continue
                if self._is_known(carrier):
                    self._hold(carried, own, base)
                elif self._is_known(carried):
                    self._hold(carrier, base, own)
                else:
                    left.append((base, own, carrier, carried))
                    continue
                grew = True
            open_pairs = left

    def _hold(self, thing: str, own: str, base: str) -> None:
        relative = self._at_start(own)
        if base:
            relative = relative.relative_to(self._at_start(base))
        self._holds[thing] = Hold(thing, own, base, relative)
        self._known.add(thing)

    def _at_start(self, name: str) -> Frames:
        return self._motion.frames[name][self._first : self._first + 1]

    def _rest(self, thing: str) -> None:
        """One frame of the group of a thing rests: that which moves least on the samples."""
        group = self._group(thing)
        named = {name: one for one in group for name in self._frames_of(one)}
        moved = sorted((*self._movement(name), name) for name in named)
        shift, turn, name = moved[0]
        others = tuple(n for s, t, n in moved[1:] if max(s, t) <= self._still)
        self._rests.append(Rest(tuple(group), name, shift, turn, others))
        self._hold(named[name], name, "")

    def _group(self, thing: str) -> list[str]:
        """The things linked to one that is not known, in the order of the scene."""
        found, ends = {thing}, [tuple(thing_of(self._problem, n) for n in pair) for pair in self._pairs]
        grew = True
        while grew:
            more = {name for pair in ends if found & set(pair) for name in pair} - found
            found |= more
            grew = bool(more)
        return [n for n in _loose(self._problem) if n in found]

    def _frames_of(self, thing: str) -> list[str]:
        module = self._problem.world.modules.get(thing)
        return [thing] if module is None else [thing, *(f"{thing}.{e.name}" for e in module.type.effectors)]

    def _movement(self, name: str) -> tuple[float, float]:
        """Metres and radians by which a frame leaves, on the samples, where it is at the start of the phase."""
        if self._motion.rests(name, self._first, self._last):
            return 0.0, 0.0
        return movement(self._motion.frames[name][self._first : self._last + 1])


@remembered(4)
def _loose(problem: ir.Problem) -> tuple[str, ...]:
    """The modules, and the bodies that may move, in the order of the scene."""
    return *problem.world.modules, *(b.name for b in problem.world.bodies.values() if b.movable)


def movement(moved: Frames) -> tuple[float, float]:
    """The greatest distance, metres, and about the greatest angle, radians, of frames from the first of them."""
    relative = moved.relative_to(moved[:1])
    shift = float(np.max(np.linalg.norm(relative.position, axis=1)))
    off: Array = np.linalg.norm(relative.rotation - np.eye(3), axis=(1, 2))
    return shift, float(np.max(off)) / np.sqrt(2)
