"""Among plans as cheap as a candidate, one whose numeric conditions hold with more room.

A* is blind to how close a condition such as `stride(X, Y) <= reach(c)` is to its limit, and goes through plans at the
limit first, which motion mostly refuses. The strain of an action is the largest ratio of the two sides of such
conditions. The plan with the least sum of high powers of it is found layer by layer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ...compiler.ir import (
    And,
    Chain,
    ChainEnd,
    ChainModule,
    ChainType,
    Formula,
    Literal,
    Not,
    Object,
    Or,
    Var,
)
from ...compiler.symbolic.domains import FlatRule
from ...compiler.symbolic.expressions import literal_test
from ...compiler.symbolic.guards import Environment, Undefined
from ...compiler.symbolic.layout import BIT, FIELD
from ...compiler.symbolic.locations import LOWER, length_bounds
from ...compiler.symbolic.normal_form import free_names, parts
from ...compiler.symbolic.successors import Successors
from .conflicts import EMPTY, LEAF

if TYPE_CHECKING:
    from .best_first import Candidate, SkeletonSearch

WIDTH = 400
"""States per layer that are kept, least strained first."""
POWER = 6
MOST_STATES = 4000
"""Pairs of state and action for which the search learns a strain that depends on the state."""
LEAST, GROWTH, MOST = 0.5, 1.5, 64.0
"""The surcharge of an action at the strain at which it was refused: at first, how it grows, at most."""
FADING, MOST_INHERITED = 0.7, 2.0
"""What is left in the next search of a weight, and of how far a limit is below 1; and the most of a weight."""
EQUAL = 1e-9
ALL = -1
"""Every bit of a state."""


class Strain:
    """How close an action's numeric conditions are to their limits: 0 without such conditions, 1 at the limit."""

    def __init__(self, successors: Successors, most_states: int = MOST_STATES) -> None:
        self.successors = successors
        self.most_states = most_states
        self._rules: dict[str, list[FlatRule]] = {}
        for flat in successors.domains.rules:
            self._rules.setdefault(flat.rule.name, []).append(flat)
        self._compares = {id(flat): length_bounds(flat) for flat in successors.domains.rules}
        self._fixed = {name for name, flats in self._rules.items() if all(map(self._speaks_of_arguments, flats))}
        self._known: dict[tuple[int, int], float] = {}
        self._states = 0
        self._masks: dict[int, int] = {}

    def of(self, state: int, number: int) -> float:
        """The strain of action `number` in a state in which it can be done."""
        action = self.successors.action(number)
        flats = self._rules[action.rule]
        if not any(self._compares[id(flat)] for flat in flats):
            return 0.0
        key = (number, state & self._mask(number))
        if key not in self._known:
            env = {v.name: a for v, a in zip(flats[0].rule.variables, action.args, strict=True)}
            strains = [strain for flat in flats for strain in self._strains(flat, env, state)]
            self._states += not self.settled(number)
            self._known[key] = min(strains, default=0.0)
        return self._known[key]

    def cheap(self, state: int, number: int) -> float:
        """The strain of an action as far as it can be told quickly: at once where the arguments settle it, else for the
        first `most_states` pairs of state and action; 0 beyond."""
        if self.settled(number):
            return self.of(0, number)
        if (number, state & self._mask(number)) in self._known or self._states < self.most_states:
            return self.of(state, number)
        return 0.0

    def settled(self, number: int) -> bool:
        """Whether the strain of an action is the same in all states."""
        return self.successors.action(number).rule in self._fixed

    def along(self, numbers: Sequence[int]) -> tuple[float, ...]:
        """The strain of each action of a plan."""
        state, strains = self.successors.initial, []
        for number in numbers:
            strains.append(self.of(state, number))
            state = next(following for following, action in self.successors.expand(state) if action == number)
        return tuple(strains)

    def _mask(self, number: int) -> int:
        """The bits of a state that the strain of an action may depend on."""
        if number not in self._masks:
            action = self.successors.action(number)
            flats = self._rules[action.rule]
            mask = 0
            if action.rule not in self._fixed:
                env = {v.name: a for v, a in zip(flats[0].rule.variables, action.args, strict=True)}
                inner = (part for flat in flats for conjunct in flat.conjuncts for part in parts(conjunct))
                mask = self.successors.layout.flag_mask
                for literal in (part for part in inner if isinstance(part, Literal)):
                    mask |= self._bits(literal, env)
            self._masks[number] = mask
        return self._masks[number]

    def _bits(self, literal: Literal, env: Environment) -> int:
        """The bits, flags left out, that the truth of a literal may depend on; all where that is not known."""
        layout, resolve = self.successors.layout, self.successors.guards.resolve
        kind = layout.kinds.get(literal.predicate)
        terms = [resolve(term, env) for term in literal.args]
        if kind == FIELD:
            key = terms[self.successors.problem.predicates[literal.predicate].functional_in or 0]
            same = [f for f in layout.fields.values() if f.predicate == literal.predicate]
            if isinstance(key, Object):
                same = [f for f in same if f.key == key.name]
            elif isinstance(key, ChainEnd | ChainModule):
                same = [f for f in same if f.key in layout.small]
            return sum(f.mask << f.shift for f in same)
        if kind == BIT:
            names = [term.name for term in terms if isinstance(term, Object)]
            return layout.encode((literal.predicate, *names))[0] if len(names) == len(terms) else ALL
        return 0

    def _strains(self, flat: FlatRule, env: Environment, state: int) -> list[float]:
        """The strain by each witness of a condition that holds in a state."""
        if flat.rule.name in self._fixed:
            return [self._largest(flat, env)]
        word, solutions = self.successors.word(state), self.successors.guards.solutions
        chains = [v for v in flat.hidden if isinstance(v.type, ChainType)]
        found = []
        for bound, live in solutions(chains, flat.conjuncts, env, word):
            known = self._read(flat, bound, state)
            others = [v for v in flat.hidden if v.name not in known]
            found += [e for e, rest in solutions(others, live, known, word) if self._hold(rest, state)]
        return [self._largest(flat, witness) for witness in found]

    def _read(self, flat: FlatRule, env: Environment, state: int) -> Environment:
        """The variables with those hidden ones that the value of a functional predicate in the state settles."""
        layout, hidden = self.successors.layout, {v.name for v in flat.hidden}
        for literal in (f for f in flat.conjuncts if isinstance(f, Literal) and layout.kinds[f.predicate] == FIELD):
            key_at = self.successors.problem.predicates[literal.predicate].functional_in or 0
            value, key = literal.args[1 - key_at], self.successors.guards.resolve(literal.args[key_at], env)
            if isinstance(value, Var) and isinstance(key, Object) and value.name in hidden - env.keys():
                place = layout.fields.get((literal.predicate, key.name))
                known = None if place is None else place.read(state)
                if known is not None:
                    env = {**env, value.name: known}
        return env

    def _largest(self, flat: FlatRule, env: Environment) -> float:
        number = self.successors.guards.number
        largest = 0.0
        for compare in self._compares[id(flat)]:
            small, large = compare.left, compare.right
            if compare.operator in LOWER:
                small, large = large, small
            try:
                below, above = float(number(small, env)), float(number(large, env))
            except (Undefined, KeyError):
                continue
            if above > 0.0:
                largest = max(largest, below / above)
        return largest

    def _speaks_of_arguments(self, flat: FlatRule) -> bool:
        """Whether the arguments of an action alone settle the comparisons."""
        names = {v.name for v in flat.rule.variables}
        return all(free_names(compare) <= names for compare in self._compares[id(flat)])

    def _hold(self, formulas: tuple[Formula, ...], state: int) -> bool:
        return all(self._holds(f, state) for f in formulas)

    def _holds(self, formula: Formula, state: int) -> bool:
        match formula:
            case Literal():
                mask, value, same = literal_test(self.successors.layout, formula)
                return (state & mask == value) is same
            case Not():
                return not self._holds(formula.operand, state)
            case And():
                return self._hold(formula.operands, state)
            case Or():
                return any(self._holds(f, state) for f in formula.operands)
            case _:
                return False


Kind = tuple[str, int]
"""Actions that share a limit: those of robots of one size, whatever their rule; or those of a rule without robots."""


class Surcharge:
    """What the search should add to the cost of strained actions. It grows with every sequence that motion refused,
    and is measured by the strain of the most strained action of such a sequence, for all of its kind."""

    def __init__(self, strain: Strain) -> None:
        self.strain = strain
        self.weight = 0.0
        self._limits: dict[Kind, float] = {}
        self._kinds: dict[int, Kind] = {}
        self._kinds_of_rules: dict[str, set[Kind]] = {}
        self._settled: dict[int, float] = {}

    def inherit(self, other: Surcharge) -> None:
        """Begin with what another search of the same rules has learnt, which weighs less with each search."""
        self.weight = min(FADING * other.weight, MOST_INHERITED)
        self._limits = {key: 1.0 - FADING * (1.0 - limit) for key, limit in other._limits.items()}
        self._kinds_of_rules = {rule: set(kinds) for rule, kinds in other._kinds_of_rules.items()}

    def refused(self, numbers: Sequence[int], first: int, last: int) -> None:
        """Actions `first` … `last` of a plan were refused one after the other."""
        if first == last:
            return
        self.weight = max(LEAST, min(self.weight * GROWTH, MOST))
        self._settled.clear()
        for number in range(self.strain.successors.action_count):
            self._kind(number)
        strains = self.strain.along(numbers[: last + 1])
        worst = max(range(first, last + 1), key=lambda k: strains[k])
        kind = self._kind(numbers[worst])
        self._limits[kind] = min(strains[worst], self._limits.get(kind, 1.0))

    def of(self, state: int, number: int) -> float:
        """The surcharge of an action."""
        if self.strain.settled(number):
            known = self._settled.get(number)
            if known is None:
                known = self._settled[number] = self._of(state, number)
            return known
        return self._of(state, number)

    def _of(self, state: int, number: int) -> float:
        limit = self._limits.get(self._kind(number), 1.0)
        return self.weight * (self.strain.cheap(state, number) / limit) ** POWER if limit > 0.0 else 0.0

    def price(self, rule: str, strain: Any) -> Any:
        """The surcharge of actions of a rule by their strain, on robots of the size that was met with the highest
        limit; arrays broadcast."""
        limit = max((self._limits.get(kind, 1.0) for kind in self._kinds_of_rules.get(rule, ())), default=1.0)
        return self.weight * (strain / limit) ** POWER if limit > 0.0 else 0.0 * strain

    def _kind(self, number: int) -> Kind:
        if number not in self._kinds:
            action = self.strain.successors.action(number)
            size = sum(len(a.modules) for a in action.args if isinstance(a, Chain))
            kind = self._kinds[number] = ("" if size else action.rule, size)
            self._kinds_of_rules.setdefault(action.rule, set()).add(kind)
        return self._kinds[number]


@dataclass(frozen=True, slots=True)
class _Node:
    """A way to a state: its strain and cost so far, what no-goods remember, and the way before."""

    strain: float
    cost: float
    state: int
    history: int
    place: int
    number: int
    before: _Node | None


def roomier(search: SkeletonSearch, strain: Strain, candidate: Candidate, width: int = WIDTH) -> Candidate:
    """A candidate of the same cost and with the same kinds of actions, with the least strain that a search of bounded
    `width` finds; the candidate itself where there is none. No-goods are respected. Raises OutOfTime."""
    successors, no_goods = search.successors, search.no_goods
    flags = successors.layout.flag_mask
    state = successors.initial
    layer = [_Node(0.0, 0.0, state, EMPTY, no_goods.root, -1, None)]
    for number in candidate.numbers:
        search.budget.check()
        wanted = successors.action(number).rule
        state = next(following for following, action in successors.expand(state) if action == number)
        best: dict[tuple[int, int, int], _Node] = {}
        for node in layer:
            for following, action in successors.expand(node.state):
                if following & flags != state & flags or successors.action(action).rule != wanted:
                    continue
                cost = node.cost + successors.cost(action)
                if cost + search.value(following) > candidate.cost + EQUAL:
                    continue
                if no_goods.active and not no_goods.allows(node.state, action):
                    continue
                history = no_goods.follow(node.history, node.state, action) if no_goods.watches else EMPTY
                place = no_goods.descend(node.place, action)
                if history is None or place == LEAF:
                    continue
                total = node.strain + strain.of(node.state, action) ** POWER
                key = (following, history, place)
                known = best.get(key)
                if known is None or total < known.strain:
                    best[key] = _Node(total, cost, following, history, place, action, node)
        layer = sorted(best.values(), key=lambda n: n.strain)[:width]
    ends = [node for node in layer if successors.is_goal(node.state)]
    if not ends:
        return candidate
    numbers = _numbers(ends[0])
    actions = tuple(successors.action(n) for n in numbers)
    return replace(candidate, numbers=numbers, actions=actions)


def _numbers(node: _Node) -> tuple[int, ...]:
    numbers = []
    current: _Node | None = node
    while current is not None and current.before is not None:
        numbers.append(current.number)
        current = current.before
    return tuple(reversed(numbers))
