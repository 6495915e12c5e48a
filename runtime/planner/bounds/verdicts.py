"""What the bounds say about a skeleton: accepted, or refused with conflicts that the search learns from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field

from ....compiler.ir import World
from ....langs.frozen import dataclass
from ...skeleton import Bound, BoundResult, Configuration, PhasePath, Violation
from ..motion.end_conditions import eased
from .settings import BOUNDS


@dataclass(frozen=True, slots=True)
class Conflict:
    """Phases `first` … `last` of a skeleton cannot be done one after the other; with `from_start` only when they begin
    in the start configuration (then `first` is 0). `switches` are the state before and the postures that P_seq came to,
    where it refuses; `obstacles` the bodies without which the last of them could be done."""

    bound: Bound
    first: int
    last: int
    from_start: bool
    violations: tuple[Violation, ...]
    switches: tuple[Configuration, ...] = field(default=(), compare=False, repr=False)
    obstacles: frozenset[str] = frozenset()


@dataclass(slots=True)
class Judgement:
    """Either accepted, with the motion of every phase unless only P_seq was asked for, or refused with conflicts.
    `ahead` holds the switch configurations behind the phases that got their motion."""

    accepted: bool
    paths: list[PhasePath] | None = None
    path_cost: float | None = None
    path_cost_before: float | None = None
    conflicts: list[Conflict] = field(default_factory=list)
    ahead: list[Configuration] = field(default_factory=list)


def with_motion(world: World, result: BoundResult, ahead: list[Configuration]) -> Judgement:
    """Accepted, with the motions of a finished path, which begin and end gently; `ahead` holds the switches behind
    it."""
    paths = eased(world, result.paths)
    return Judgement(True, paths, path_cost=result.cost, path_cost_before=result.cost_before, ahead=ahead)


def missed(refused: BoundResult, first: int, last: int, from_start: bool) -> Conflict:
    """The conflict of phases whose switches P_seq refuses: `refused` has the state before `first`, too."""
    return Conflict(Bound.SEQ, first, last, from_start, tuple(refused.violations), tuple(refused.configurations))


def blame(bound: Bound, refused: BoundResult, blamed: Sequence[set[int]], phases: int) -> Conflict:
    """The one phase that failed between every pair of switch poses, wherever it starts; else all up to the phase that
    failed worst."""
    worst = refused.violations[0].phase if refused.violations else phases - 1
    always = set.intersection(*blamed) if len(blamed) >= BOUNDS.always_refused else set()
    if worst in always and worst > 0:
        told = tuple(v for v in refused.violations if v.phase == worst)
        return Conflict(bound, worst, worst, False, told)
    return Conflict(bound, 0, worst, True, tuple(refused.violations))
