"""Actions that robots cannot do from where they are at the start, whatever others do before.

Where motion refuses one action from the start for reasons that lie with what takes part in it and with what never
moves alone, the refusal holds as long as none of its movers has left its place: others may act before in any order, and
so may a robot that stays where it stands.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from ....compiler.ir import Action, Effect, EffectFor, EffectIf, EffectItem, Fact, Problem
from ....compiler.symbolic.successors import Successors
from ...geometry.attachments import involved, next_mode
from ...skeleton import BoundResult, Skeleton
from ..search.skeleton_replay import motion_changes
from ..search.stepper import left
from .lifting import objects_of


class Openings:
    """The forbidden openings of one search, each a bit of what is `waiting`: those whose movers are in their places
    yet."""

    def __init__(self, problem: Problem, successors: Successors) -> None:
        self.problem, self.successors = problem, successors
        self._found: dict[int, tuple[int, frozenset[str]]] = {}
        self._begun: dict[int, int] = {}
        self._acting: dict[int, frozenset[str]] = {}
        self._leaving: dict[int, frozenset[str]] = {}

    def __bool__(self) -> bool:
        return bool(self._found)

    @property
    def all(self) -> int:
        """What waits at the start."""
        return (1 << len(self._found)) - 1

    def forbid(self, number: int, movers: frozenset[str]) -> None:
        """Forbid an action while none of the `movers` has left its place."""
        self._found.setdefault(number, (1 << len(self._found), movers))
        self._begun.clear()

    def clear(self) -> None:
        self._found.clear()
        self._begun.clear()

    def after(self, waiting: int, number: int) -> int | None:
        """What waits after one more action; None where it is a forbidden opening."""
        if not waiting:
            return 0
        opening = self._found.get(number)
        if opening is not None and opening[0] & waiting:
            return None
        begun = self._begun.get(number)
        if begun is None:
            leaving = self.leaving(number)
            begun = self._begun[number] = sum(bit for bit, others in self._found.values() if others & leaving)
        return waiting & ~begun

    def acting(self, number: int) -> frozenset[str]:
        """The modules and movable bodies that an action names."""
        known = self._acting.get(number)
        if known is None:
            known = self._acting[number] = movers(self.problem, self.successors.action(number))
        return known

    def leaving(self, number: int) -> frozenset[str]:
        """What may be elsewhere after an action than at the start: bodies that it names, and modules that it names, but
        for those of which it leaves alone what held at the start."""
        known = self._leaving.get(number)
        if known is None:
            known = self._leaving[number] = self._left(number)
        return known

    def _left(self, number: int) -> frozenset[str]:
        acting, action = self.acting(number), self.successors.action(number)
        rule = self.problem.rules.get(action.rule)
        if rule is None or not all(isinstance(e, Effect) for e in rule.effects):
            return acting
        start = self.problem.init_motion
        deleted, _ = motion_changes(self.problem, self.successors, self.successors.initial, action)
        kept = left(self.problem.motions, start, deleted)
        stay = _owners(self.problem, kept) - _owners(self.problem, start - kept)
        return acting - (stay & self.problem.world.modules.keys())


def _owners(problem: Problem, literals: Iterable[Fact]) -> frozenset[str]:
    return frozenset(problem.world.owner(name) for literal in literals for name in literal[1:])


def movers(problem: Problem, action: Action) -> frozenset[str]:
    """The modules and movable bodies that an action names."""
    return _moving(problem, objects_of(action))


def _moving(problem: Problem, names: Iterable[str]) -> frozenset[str]:
    world = problem.world
    owners = {world.owner(name) for name in names}
    return frozenset(n for n in owners if n in world.modules or (n in world.bodies and world.bodies[n].movable))


def opening(skeleton: Skeleton, phase: int) -> Skeleton:
    """The action of a phase as the first of all, where nothing that takes part in it has acted before."""
    start, then = skeleton.phases[0].mode, skeleton.phases[phase]
    undone = then.mode - next_mode(skeleton, phase)
    first = replace(then, mode=start)
    return replace(skeleton, phases=(first,), final_mode=(start - undone) | then.added, coming=())


def taking_part(skeleton: Skeleton, phase: int) -> frozenset[str]:
    """The movers on which the rows of an action depend as the first of all: those that it names, those that are one
    robot with them, and what hangs together with them by the literals of the start."""
    problem = skeleton.problem
    first = opening(skeleton, phase)
    found = movers(problem, first.phases[0].action) | involved(first, 0)
    literals = [_moving(problem, literal[1:]) for literal in first.phases[0].mode | first.phases[0].added]
    grew = True
    while grew:
        grown = found.union(*(names for names in literals if names & found))
        found, grew = grown, grown != found
    return found


def holds_whatever_others_do(skeleton: Skeleton, refused: BoundResult) -> bool:
    """Whether the refusal of a skeleton of one action rests on those that take part and what never moves: nothing was
    in the way, and no effect depends on what others have done."""
    rule = skeleton.problem.rules.get(skeleton.phases[0].action.rule)
    return refused.unobstructed and rule is not None and not _conditional(rule.effects)


def _conditional(effects: Sequence[EffectItem]) -> bool:
    return any(isinstance(e, EffectIf) or (isinstance(e, EffectFor) and _conditional(e.effects)) for e in effects)
