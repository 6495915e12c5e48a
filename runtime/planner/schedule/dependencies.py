"""What must come before what: which phases move what hangs together, and which things a switch binds.

In a verified plan phase k moves some things and ends with switch k. A switch binds the things that its literals name,
and all that hangs together with them, before or after: what they moved before must have come to an end, and what moves
them later begins behind it. Other things move through it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ....compiler.ir import Fact, Problem
from ....compiler.remembering import remembered
from ....langs.frozen import dataclass
from ...geometry.attachments import carrier, next_mode
from ...skeleton import PhasePath, Skeleton
from .profiles import STILL

Things = frozenset[str]
"""Modules and movable bodies, by name."""


@dataclass(frozen=True, slots=True)
class Segment:
    """The motion of one phase: the things that it moves, those and all that hangs together with them, and how long it
    lasts, in ticks."""

    phase: int
    moved: Things
    held: Things
    path: PhasePath
    ticks: int


@dataclass(frozen=True, slots=True)
class Precedence:
    """By phase: of its motion (`segments`, None where nothing moves) the switches and motions that come before it; of
    its switch the motions that must have ended, and the switches before it. All numbers are those of phases."""

    segments: tuple[Segment | None, ...]
    begins_after: tuple[frozenset[int], ...]
    follows: tuple[frozenset[int], ...]
    closes: tuple[frozenset[int], ...]
    ordered: tuple[frozenset[int], ...]

    def __len__(self) -> int:
        return len(self.segments)


class _Bonds:
    """The things of a problem, and those that its literals name and join: read off once, as often asked for."""

    def __init__(self, problem: Problem) -> None:
        world = problem.world
        self._problem = problem
        self.things = frozenset((*world.modules, *(name for name, body in world.bodies.items() if body.movable)))
        self._joining = {
            name: any(row.when in ("keep", "during") for row in motion.rows) for name, motion in problem.motions.items()
        }
        self._named: dict[Fact, Things] = {}

    def named(self, literal: Fact) -> Things:
        """The things that a literal names."""
        found = self._named.get(literal)
        if found is None:
            found = self._named[literal] = frozenset(carrier(self._problem, a) for a in literal[1:]) & self.things
        return found

    def joined(self, literal: Fact) -> Things:
        """Those that it keeps to each other, or binds as long as it holds."""
        return self.named(literal) if self._joining[literal[0]] else frozenset()

    def around(self, mode: Iterable[Fact], names: Things) -> Things:
        """Some things, and all that hang together with them."""
        groups = [things for literal in mode if len(things := self.joined(literal)) > 1]
        found, grew = names, True
        while grew:
            grew, apart = False, []
            for things in groups:
                if found.isdisjoint(things):
                    apart.append(things)
                else:
                    found, grew = found | things, True
            groups = apart
        return found


@remembered(8)
def _bonds(problem: Problem) -> _Bonds:
    return _Bonds(problem)


def bound_by(skeleton: Skeleton, phase: int) -> Things:
    """The things that the switch of a phase binds."""
    here = skeleton.phases[phase]
    return bound_between(skeleton.problem, here.mode, here.added, next_mode(skeleton, phase))


def bound_between(problem: Problem, mode: frozenset[Fact], added: frozenset[Fact], after: frozenset[Fact]) -> Things:
    """The things that a switch from one mode to another binds, which adds some literals."""
    bonds = _bonds(problem)
    named = frozenset[str]().union(*(bonds.named(literal) for literal in (mode ^ after) | added))
    return bonds.around(mode, named) | bonds.around(after, named)


def moved_by(path: PhasePath) -> Things:
    """The modules and bodies that a path moves."""
    rows = {**path.modules, **path.bodies}
    return frozenset(name for name, row in rows.items() if len(row) and float(np.ptp(row, axis=0).max()) > STILL)


def precedence(
    skeleton: Skeleton, paths: Sequence[PhasePath], tick: float, also: Iterable[tuple[int, int]] = ()
) -> Precedence:
    """What comes before what; of every pair of `also` the switch of the first before that of the second."""
    count, problem = len(skeleton), skeleton.problem
    bound = [bound_by(skeleton, k) for k in range(count)]
    segments: list[Segment | None] = []
    for k, path in enumerate(paths):
        moved = moved_by(path)
        held = _bonds(problem).around(skeleton.phases[k].mode, moved)
        segments.append(Segment(k, moved, held, path, round(path.duration / tick)) if moved else None)
    begins, follows, closes, ordered = [], [], [], []
    extra = {k: {a for a, b in also if b == k} for k in range(count)}
    for k in range(count):
        own = segments[k]
        held = own.held if own is not None else frozenset[str]()
        begins.append(frozenset(j for j in range(k) if bound[j] & held))
        follows.append(frozenset(j for j in range(k) if (s := segments[j]) is not None and s.held & held))
        closes.append(frozenset(
            j for j in range(k + 1) if (s := segments[j]) is not None and (j == k or s.held & bound[k])
        ))  # fmt: skip
        ordered.append(frozenset(j for j in range(k) if bound[j] & bound[k]) | frozenset(extra[k]))
    return Precedence(tuple(segments), tuple(begins), tuple(follows), tuple(closes), tuple(ordered))
