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


@remembered(256)
def hanging_together(problem: Problem, mode: frozenset[Fact]) -> list[Things]:
    """The things that literals of a mode keep to each other, or bind as long as they hold, in groups; a thing that
    none does is alone."""
    world = problem.world
    movable = [name for name, body in world.bodies.items() if body.movable]
    groups = {name: frozenset((name,)) for name in (*world.modules, *movable)}
    for literal in sorted(mode):
        if not any(row.when in ("keep", "during") for row in problem.motions[literal[0]].rows):
            continue
        named = {carrier(problem, a) for a in literal[1:]} & groups.keys()
        joined = frozenset().union(*(groups[name] for name in named))
        for name in joined:
            groups[name] = joined
    return list(dict.fromkeys(groups.values()))


def _closed(groups: Iterable[Things], named: Iterable[str]) -> Things:
    names = set(named)
    return frozenset(names).union(*(g for g in groups if g & names))


def bound_by(skeleton: Skeleton, phase: int) -> Things:
    """The things that the switch of a phase binds."""
    here = skeleton.phases[phase]
    return bound_between(skeleton.problem, here.mode, here.added, next_mode(skeleton, phase))


def bound_between(problem: Problem, mode: frozenset[Fact], added: frozenset[Fact], after: frozenset[Fact]) -> Things:
    """The things that a switch from one mode to another binds, which adds some literals."""
    literals = (mode ^ after) | added
    named = {carrier(problem, a) for literal in literals for a in literal[1:]}
    known = problem.world.modules.keys() | {n for n, b in problem.world.bodies.items() if b.movable}
    before = _closed(hanging_together(problem, mode), named & known)
    return before | _closed(hanging_together(problem, after), named & known)


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
        held = _closed(hanging_together(problem, skeleton.phases[k].mode), moved)
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
