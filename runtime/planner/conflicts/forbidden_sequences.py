"""What motion has refused, in the search's terms: sequences of actions that must not be done one after the other.

A conflict holds where it was met: its context is where the robots that its first action concerns stand, and what they
hold. It is stored lifted: modules of one type stand for each other, and so do the ends of a module that is the same
from both; names are replaced in the order of their first appearance, which makes the lifted form of a beginning the
beginning of the lifted form. All no-goods are soft: a local solver's refusal is no proof.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ....compiler.ir import Action, Fact, Problem
from ....compiler.symbolic.successors import Successors
from ....langs.frozen import dataclass
from .lifting import Lifting, Signature, objects_of
from .openings import Openings

Context = tuple[Fact, ...]
"""Values of functional predicates for the objects that an action concerns."""
History = tuple[tuple[int, Context], ...]
"""The last actions, each with its context, as far as they begin some conflict."""
EMPTY = 0
"""The number of the empty history."""
OFF = -1
"""Place outside of all that is forbidden from the start."""
LEAF = -2
MISSING: set[Signature] = set()
Place = tuple[int, ...]
"""A node of the tree of prefixes, the openings that wait, then by forbidden order the actions that are done, by bit."""


@dataclass(frozen=True, slots=True)
class ForbiddenOrder:
    """Actions of which each comes behind those `before` it, by place."""

    numbers: tuple[int, ...]
    before: tuple[frozenset[int], ...]

    def after(self, done: int, number: int) -> int:
        """What is done after one more action: OFF where it is none of those that may come next, LEAF behind the
        last."""
        if done == OFF:
            return OFF
        following = next((k for k, n in enumerate(self.numbers) if n == number and not done >> k & 1), None)
        if following is None or any(not done >> k & 1 for k in self.before[following]):
            return OFF
        done |= 1 << following
        return LEAF if done + 1 == 1 << len(self.numbers) else done


class NoGoods:
    """Forbidden actions, sequences and prefixes of one search."""

    def __init__(self, problem: Problem, successors: Successors) -> None:
        self.problem = problem
        self.successors = successors
        self.names = Lifting(problem)
        self._conflicts: dict[Signature, set[Signature]] = {}
        self._beginnings: set[Signature] = set()
        self._bare: dict[tuple[int, ...], Signature] = {}
        self._lifted: dict[tuple[tuple[int, ...], Context], Signature] = {}
        self._contexts: dict[tuple[int, int], Context] = {}
        self._linked: dict[int, dict[str, set[str]]] = {}
        self._tree: list[dict[int, int]] = [{}]
        self._prefixes: list[tuple[tuple[int, ...], float]] = []
        self._orders: list[ForbiddenOrder] = []
        self.openings = Openings(problem, successors)
        self._places: list[Place] = []
        self._place_numbers: dict[Place, int] = {}
        self._histories: list[History] = [()]
        self._history_numbers: dict[History, int] = {(): EMPTY}
        self._predicates = tuple(dict.fromkeys(p for p, _ in successors.layout.fields))
        self._single: dict[int, set[Signature] | None] = {}
        self._beside: dict[Signature, list[tuple[Signature, int, int]]] = {}
        self._heads: dict[int, bool] = {}

    @property
    def active(self) -> bool:
        """Whether some sequence is forbidden."""
        return bool(self._conflicts or self._beside)

    @property
    def watches(self) -> bool:
        """Whether some conflict is longer than one action."""
        return bool(self._beginnings)

    @property
    def root(self) -> int:
        """The place where a plan starts."""
        return self._place((0 if self._tree[0] else OFF, self.openings.all, *(0 for _ in self._orders)))

    @property
    def aside(self) -> int:
        """The place of those that have not acted yet, when others have."""
        return self._place((OFF, self.openings.all, *(OFF for _ in self._orders)))

    def forbid_sequence(self, numbers: Sequence[int], state: int) -> None:
        """Forbid these actions one after the other, from where the first one's robots are in `state`, and whatever is
        the same but for names."""
        full = self._full(numbers, self.context(state, numbers[0]))
        self._conflicts.setdefault(self.bare(numbers), set()).add(full)
        self._beginnings.update(self.bare(numbers[:k]) for k in range(1, len(numbers)))
        self._single.clear()
        self._heads.clear()

    def forbid_beside(self, number: int, state: int, names: frozenset[str]) -> None:
        """Forbid an action from where its robots are in `state` as long as that says the same of what is named."""
        full = self._full((number,), self.context(state, number))
        entry = (full, *self.successors.layout.about(state, names))
        self._beside.setdefault(self.bare((number,)), []).append(entry)

    @property
    def forbids_all(self) -> bool:
        """Whether the plan without actions is forbidden, with which every plan begins."""
        return any(not numbers for numbers, _ in self._prefixes)

    def forbid_prefix(self, numbers: Sequence[int], survives: float = math.inf) -> None:
        """Forbid exactly these actions from the start, over so many readmissions."""
        self._prefixes.append((tuple(numbers), survives))
        self._grow(numbers)

    def forbid_orders(self, numbers: Sequence[int], before: Sequence[frozenset[int]]) -> None:
        """Forbid these actions from the start in all orders in which each comes behind those `before` it, by place,
        over all readmissions."""
        if not numbers:
            self.forbid_prefix(())
        self._orders.append(ForbiddenOrder(tuple(numbers), tuple(before)))

    def _grow(self, numbers: Sequence[int]) -> None:
        node = 0
        for number in numbers[:-1]:
            following = self._tree[node].get(number)
            if following == LEAF:
                return
            if following is None:
                self._tree.append({})
                following = self._tree[node][number] = len(self._tree) - 1
            node = following
        if numbers:
            self._tree[node][numbers[-1]] = LEAF

    def readmit(self) -> bool:
        """Forget the sequences, and the prefixes that survive no readmission any more. False when there were none."""
        lasting = [(numbers, survives - 1) for numbers, survives in self._prefixes if survives > 0]
        known = bool(self.active or self.openings) or len(lasting) < len(self._prefixes)
        self.openings.clear()
        self._prefixes, self._tree = lasting, [{}]
        for numbers, _ in lasting:
            self._grow(numbers)
        self._conflicts.clear()
        self._beside.clear()
        self._beginnings.clear()
        self._single.clear()
        self._heads.clear()
        return known

    def allows(self, state: int, number: int) -> bool:
        """Whether an action is not forbidden by itself in a state."""
        known = self._single.get(number, MISSING)
        if known is MISSING:
            known = self._single[number] = self._conflicts.get(self.bare((number,)))
        beside = self._beside.get(self.bare((number,))) if self._beside else None
        if known is None and beside is None:
            return True
        full = self._full((number,), self.context(state, number))
        if known is not None and full in known:
            return False
        return not any(full == other and state & mask == value for other, mask, value in beside or ())

    def follow(self, number_before: int, state: int, number: int) -> int | None:
        """The number of the history after one more action; None when that completes a conflict."""
        if number_before == EMPTY:
            begins = self._heads.get(number)
            if begins is None:
                begins = self._heads[number] = self.bare((number,)) in self._beginnings
            if not begins:
                return EMPTY
        kept = self._follow(self._histories[number_before], state, number)
        if kept is None:
            return None
        if kept not in self._history_numbers:
            self._history_numbers[kept] = len(self._histories)
            self._histories.append(kept)
        return self._history_numbers[kept]

    def _follow(self, history: History, state: int, number: int) -> History | None:
        numbers = (*(n for n, _ in history), number)
        kept: History | None = None
        for k in range(len(numbers)):
            bare = self.bare(numbers[k:])
            begins, forbidden = bare in self._beginnings, self._conflicts.get(bare)
            if not begins and forbidden is None:
                continue
            context = history[k][1] if k < len(history) else self.context(state, number)
            if forbidden is not None and self._full(numbers[k:], context) in forbidden:
                return None
            if begins and kept is None:
                kept = (*history[k:], (number, self.context(state, number)))
        return () if kept is None else kept

    def advance(self, history: int, place: int, state: int, number: int) -> tuple[int, int] | None:
        """The number of the history and the place after one more action; None when that completes what is forbidden."""
        following = self.follow(history, state, number) if self.watches else EMPTY
        then = self._descend(place, number)
        return None if following is None or then is None else (following, then)

    def _descend(self, place: int, number: int) -> int | None:
        """The place after an action; None where it is forbidden."""
        if place == OFF:
            return OFF
        node, waiting, *done = self._places[place]
        node = self._tree[node].get(number, OFF) if node != OFF else OFF
        left = self.openings.after(waiting, number)
        orders = [order.after(mask, number) for order, mask in zip(self._orders, done, strict=True)]
        return None if left is None or LEAF in (node, *orders) else self._place((node, left, *orders))

    def acting(self, number: int) -> frozenset[str]:
        """The modules and movable bodies that an action names."""
        return self.openings.acting(number)

    def _place(self, place: Place) -> int:
        """The number of a place."""
        if place[1] == 0 and place[0] == OFF and all(mask == OFF for mask in place[2:]):
            return OFF
        known = self._place_numbers.get(place)
        if known is None:
            known = self._place_numbers[place] = len(self._places)
            self._places.append(place)
        return known

    def bare(self, numbers: Sequence[int]) -> Signature:
        """The lifted actions without context."""
        key = tuple(numbers)
        if key not in self._bare:
            self._bare[key] = self.names.actions([self.successors.action(n) for n in key])[0]
        return self._bare[key]

    def _full(self, numbers: Sequence[int], context: Context) -> Signature:
        key = (tuple(numbers), context)
        if key in self._lifted:
            return self._lifted[key]
        signature, names = self.names.actions([self.successors.action(n) for n in numbers])
        lifted = [(f[0], *(self.names.token(o, names) for o in f[1:])) for f in context]
        self._lifted[key] = (signature, tuple(lifted))
        return self._lifted[key]

    def context(self, state: int, number: int) -> Context:
        """What the functional predicates say in `state` of the objects in an action, and of the modules linked to
        them; nearest first, so that the order does not depend on names."""
        key = (state, number)
        if key not in self._contexts:
            found: dict[Fact, None] = {}
            fields = self.successors.layout.fields
            for name in self._concerned(state, self.successors.action(number)):
                for predicate in self._predicates:
                    place = fields.get((predicate, name))
                    value = None if place is None else place.read(state)
                    if value is not None:
                        found[predicate, name, value] = None
            self._contexts[key] = tuple(found)
        return self._contexts[key]

    def _concerned(self, state: int, action: Action) -> list[str]:
        """The objects of an action and all ends of the modules that are linked to its own, walking along the links."""
        links = self._links(state)
        found = dict.fromkeys(objects_of(action))
        waiting = list(found)
        while waiting:
            name = waiting.pop(0)
            world = self.problem.world
            module = world.owner(name)
            known = world.modules.get(module)
            ends = [f"{module}.{e.name}" for e in known.type.effectors] if known is not None else []
            for other in [*sorted(links.get(name, ())), *ends]:
                if other not in found:
                    found[other] = None
                    waiting.append(other)
        return list(found)

    def _links(self, state: int) -> dict[str, set[str]]:
        flags = state & self.successors.layout.flag_mask
        if flags not in self._linked:
            links: dict[str, set[str]] = {}
            for fact in self.successors.word(state).facts:
                if len(fact) == 3:
                    links.setdefault(fact[1], set()).add(fact[2])
                    links.setdefault(fact[2], set()).add(fact[1])
            self._linked[flags] = links
        return self._linked[flags]
