"""When two plans are the same but for the order of actions that commute, and when one is another with a detour.

Two actions that follow each other commute where they bind nothing in common, each can be done before the other, and
both orders lead to the same state (Mazurkiewicz traces). What must come before what is then a partial order of a plan's
actions, and plans of one partial order are one plan.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence

from ....compiler.ir import Fact, Problem
from ....compiler.symbolic.successors import Successors
from ....langs.frozen import dataclass
from ...geometry.attachments import carrier
from ..search.best_first import Candidate, SkeletonSearch
from ..search.skeleton_replay import motion_changes
from ..search.stepper import left
from .dependencies import Things, bound_between

Numbers = tuple[int, ...]
Mode = frozenset[Fact]


@dataclass(frozen=True, slots=True)
class PlanForm:
    """A plan up to the order of actions that commute: its actions in `normal` order, those that come `before` each, by
    place in the plan as it was given, and what becomes of every thing: `rows` of the motion literals that name it, one
    for each change, and under no name the actions that change none."""

    numbers: Numbers
    normal: Numbers
    before: tuple[frozenset[int], ...]
    rows: Mapping[str, tuple[object, ...]]


class PlanForms:
    """The forms of the plans of one problem."""

    def __init__(self, problem: Problem, successors: Successors) -> None:
        self._problem, self._successors = problem, successors
        world = problem.world
        self._things = (*world.modules, *(name for name, body in world.bodies.items() if body.movable))
        self._next: dict[tuple[int, int], int | None] = {}
        self._forms: dict[Numbers, PlanForm] = {}

    def of(self, numbers: Numbers) -> PlanForm:
        """The form of actions that can be done one after the other from the start."""
        if numbers not in self._forms:
            modes, bound = self._replayed(numbers)
            before = self._before(numbers, bound)
            self._forms[numbers] = PlanForm(numbers, _least_order(numbers, before), before, self._rows(numbers, modes))
        return self._forms[numbers]

    def _replayed(self, numbers: Numbers) -> tuple[list[Mode], list[Things]]:
        """The modes from the start on, and the things that each action binds."""
        problem, state = self._problem, self._successors.initial
        modes, bound = [problem.init_motion], []
        for number in numbers:
            deleted, told = motion_changes(problem, self._successors, state, self._successors.action(number))
            added = frozenset(told)
            modes.append(left(problem.motions, modes[-1], deleted) | added)
            bound.append(bound_between(problem, modes[-2], added, modes[-1]))
            state = self._successors.after(state, number)
        return modes, bound

    def _before(self, numbers: Numbers, bound: Sequence[Things]) -> tuple[frozenset[int], ...]:
        """By action those that must come before it, near or far."""
        found: list[frozenset[int]] = []
        for j in range(len(numbers)):
            before: set[int] = set()
            for i in reversed(range(j)):
                if i not in before and (bound[i] & bound[j] or self._in_order(numbers, found, i, j)):
                    before |= {i} | found[i]
            found.append(frozenset(before))
        return tuple(found)

    def _in_order(self, numbers: Numbers, found: Sequence[frozenset[int]], i: int, j: int) -> bool:
        """Whether an action must come before a later one that commutes with all that must come between: tried where
        all else that may come first is done."""
        state: int | None = self._successors.initial
        for k in range(j):
            if k != i and i not in found[k]:
                state = self._after(state, numbers[k])
        one = self._after(self._after(state, numbers[i]), numbers[j])
        other = self._after(self._after(state, numbers[j]), numbers[i])
        return one is None or one != other

    def _after(self, state: int | None, number: int) -> int | None:
        """The state after an action, None where it cannot be done."""
        if state is None:
            return None
        key = state, number
        if key not in self._next:
            self._next[key] = self._successors.following(state, number)
        return self._next[key]

    def _rows(self, numbers: Numbers, modes: Sequence[Mode]) -> Mapping[str, tuple[object, ...]]:
        rows: dict[str, list[object]] = {name: [] for name in self._things}
        named = [self._by_name(mode) for mode in modes]
        for at in named:
            for name, row in rows.items():
                held = at.get(name, frozenset())
                if not row or row[-1] != held:
                    row.append(held)
        still: list[object] = [n for n, a, b in zip(numbers, modes, modes[1:], strict=False) if a == b]
        return {name: tuple(row) for name, row in rows.items()} | {"": tuple(still)}

    def _by_name(self, mode: Mode) -> Mapping[str, Mode]:
        found: dict[str, set[Fact]] = {}
        for fact in mode:
            for name in {carrier(self._problem, argument) for argument in fact[1:]}:
                found.setdefault(name, set()).add(fact)
        return {name: frozenset(facts) for name, facts in found.items()}


class DistinctPlans:
    """Keeps a search from proposing what is, but for the order of actions that commute, a plan that was found, or one
    of these with a detour."""

    def __init__(self, search: SkeletonSearch) -> None:
        self._search = search
        self._forms = PlanForms(search.problem, search.successors)

    def found(self, candidate: Candidate) -> None:
        """Forbid the candidate in all its orders."""
        form = self._forms.of(candidate.numbers)
        self._search.forbid_orders(form.numbers, form.before)

    def repeats(self, candidate: Candidate, others: Sequence[Candidate]) -> bool:
        """Whether a candidate is one of some others with a detour; from then on it is forbidden in all its orders."""
        if not self.detours(candidate, others):
            return False
        self.found(candidate)
        return True

    def detours(self, candidate: Candidate, others: Sequence[Candidate]) -> bool:
        if not others:
            return False
        form = self._forms.of(candidate.numbers)
        return any(is_detour(form, self._forms.of(other.numbers)) for other in others)


def is_detour(longer: PlanForm, other: PlanForm) -> bool:
    """Whether a plan takes everything through all that another plan takes it through, in the same order, and through
    more."""
    rows = [(longer.rows[name], other.rows[name]) for name in other.rows]
    return any(len(a) > len(b) for a, b in rows) and all(_contains(a, b) for a, b in rows)


def _contains(row: Sequence[object], part: Sequence[object]) -> bool:
    """Whether a row has the items of another, in their order."""
    rest = iter(row)
    return all(any(item == other for other in rest) for item in part)


def _least_order(numbers: Numbers, before: Sequence[frozenset[int]]) -> Numbers:
    """Of the orders that keep what comes before what the least one, by the actions' numbers."""
    waiting = [set(places) for places in before]
    ready = [(numbers[k], k) for k, places in enumerate(waiting) if not places]
    heapq.heapify(ready)
    found = []
    while ready:
        number, done = heapq.heappop(ready)
        found.append(number)
        for k, places in enumerate(waiting):
            if done in places:
                places.remove(done)
                if not places:
                    heapq.heappush(ready, (numbers[k], k))
    return tuple(found)
