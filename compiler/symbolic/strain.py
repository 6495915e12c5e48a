"""How close actions are to the limits of what their rules allow.

The strain of an action is the largest ratio of the two sides of a condition such as `stride(X, Y) <= reach(c)`, by the
witness of the rule's condition that strains least: 0 without such conditions, 1 at the limit. Strains are found row by
row, as the successor functions find actions, and kept: among many interchangeable things they cost next to nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ...langs.frozen import dataclass
from ..ir import Action, Chain, Compare, Term
from .algebra import Environment, Undefined
from .blocks import Block
from .domains import FlatRule
from .expressions import Check
from .locations import LOWER, length_bounds
from .normal_form import free_names
from .steps import Step
from .successors import Successors

Row = dict[int, list[tuple[float, Step | None]]]
"""By action the strain by every witness, least first, and the step in whose states it is one; None for all states."""
_Side = tuple[Term, tuple[str, ...]]
"""A side of a comparison, and its variables."""


@dataclass(frozen=True, slots=True)
class _Source:
    """A block that may give an action, and whether it does so in a state; None when it always does."""

    block: Block
    holds: Check | None


class _Witnesses:
    """The strains that an action may have, least first, each with what must hold of a state for it to be one."""

    def __init__(self, found: list[tuple[float, Check | None, Step | None]]) -> None:
        self._found = found
        self._known: dict[tuple[int, tuple[bool, ...]], float] = {}
        self._conditions = list(dict.fromkeys(holds for _, holds, _ in found if holds is not None))
        self._bits: int | None = 0
        """The bits of a state that settle which of them is the least, with the conditions; None where a step has
        conditions of its own."""
        for _, _, step in found:
            if step is not None and step.check is not None:
                self._bits = None
                return
            for mask, _, _ in step.tests if step is not None else ():
                self._bits |= mask

    def least(self, state: int) -> float:
        """The least strain in a state, 0 without a witness."""
        if self._bits is None:
            return self._first(state)
        seen = (state & self._bits, tuple([holds(state) for holds in self._conditions]))
        known = self._known.get(seen)
        if known is None:
            known = self._known[seen] = self._first(state)
        return known

    def _first(self, state: int) -> float:
        for strain, holds, step in self._found:
            if (holds is None or holds(state)) and (step is None or step.possible(state)):
                return strain
        return 0.0


class Strain:
    """The strains of the actions of one problem."""

    def __init__(self, successors: Successors) -> None:
        self.successors = successors
        self._rules: dict[str, list[FlatRule]] = {}
        for flat in successors.domains.rules:
            self._rules.setdefault(flat.rule.name, []).append(flat)
        self._sides = {id(flat): [_sides(c) for c in length_bounds(flat)] for flat in successors.domains.rules}
        self._fixed = {name for name, flats in self._rules.items() if all(map(self._speaks_of_arguments, flats))}
        self._settled: dict[int, float] = {}
        self._sources: dict[tuple[int, int], tuple[int, tuple[_Source, ...]]] = {}
        self._rows: dict[tuple[int, Any], Row] = {}
        self._witnesses: dict[tuple[int, int, int], _Witnesses] = {}
        self._values: dict[tuple[Any, ...], float] = {}

    def of(self, state: int, number: int) -> float:
        """The strain of action `number` in a state in which it can be done."""
        if not self.settled(number):
            return self._by_witness(state, number)
        known = self._settled.get(number)
        if known is None:
            known = self._settled[number] = self._by_arguments(number)
        return known

    def settled(self, number: int) -> bool:
        """Whether the strain of an action is the same in all states."""
        return self.successors.action(number).rule in self._fixed

    def along(self, numbers: Sequence[int]) -> tuple[float, ...]:
        """The strain of each action of a plan."""
        state, strains = self.successors.initial, []
        for number in numbers:
            strains.append(self.of(state, number))
            state = self.successors.after(state, number)
        return tuple(strains)

    def _by_arguments(self, number: int) -> float:
        action = self.successors.action(number)
        env = self._arguments(action)
        return min((self._ratio(flat, env) for flat in self._rules[action.rule]), default=0.0)

    def _arguments(self, action: Action) -> Environment:
        """The arguments of an action by the variables of its rule."""
        variables = self._rules[action.rule][0].rule.variables
        return {v.name: a for v, a in zip(variables, action.args, strict=True)}

    def _by_witness(self, state: int, number: int) -> float:
        flags = state & self.successors.layout.flag_mask
        known = self._sources.get((flags, number))
        read, sources = known if known is not None else self._sources_of(state, flags, number)
        key = (flags, number, state & read)
        witnesses = self._witnesses.get(key)
        if witnesses is None:
            found = [
                (strain, source.holds, step)
                for source in sources
                for strain, step in self._row(source.block, state).get(number, ())
            ]
            witnesses = self._witnesses[key] = _Witnesses(sorted(found, key=lambda witness: witness[0]))
        return witnesses.least(state)

    def _sources_of(self, state: int, flags: int, number: int) -> tuple[int, tuple[_Source, ...]]:
        """The blocks that may give an action in states with these flags, and the bits of a state that name their
        rows."""
        action = self.successors.action(number)
        args = self._arguments(action)
        agreeing = [
            block for block in self.successors.blocks(state)
            if block.flat.rule.name == action.rule
            and all(args[name] == value for name, value in block.env.items() if name in args)
        ]  # fmt: skip
        alone = len(agreeing) == 1
        read = 0
        for block in agreeing:
            for _, place in block.keys:
                read |= place.mask << place.shift
        sources = tuple(_Source(b, None if alone else _check(b.tests)) for b in agreeing)
        self._sources[flags, number] = read, sources
        return read, sources

    def _row(self, block: Block, state: int) -> Row:
        numbers = tuple(state >> place.shift & place.mask for _, place in block.keys)
        key = (id(block), numbers)
        if key not in self._rows:
            self._rows[key] = self._made(block, numbers)
        return self._rows[key]

    def _made(self, block: Block, numbers: tuple[int, ...]) -> Row:
        row: Row = {}
        for env, step, action in self.successors.witnesses(block, numbers):
            row.setdefault(action, []).append((self._ratio(block.flat, env), step))
        for found in row.values():
            found.sort(key=lambda pair: pair[0])
        return row

    def _ratio(self, flat: FlatRule, env: Environment) -> float:
        """The largest ratio of the sides of the comparisons of a rule."""
        return max((self._of_sides(*sides, env) for sides in self._sides[id(flat)]), default=0.0)

    def _of_sides(self, small: _Side, large: _Side, env: Environment) -> float:
        try:
            below, above = self._value(small, env), self._value(large, env)
        except (Undefined, KeyError):
            return 0.0
        return max(0.0, below / above) if above > 0.0 else 0.0

    def _value(self, side: _Side, env: Environment) -> float:
        term, names = side
        key = (id(term), *[env[name] for name in names])
        known = self._values.get(key)
        if known is None:
            known = self._values[key] = float(self.successors.guards.number(term, env))
        return known

    def _speaks_of_arguments(self, flat: FlatRule) -> bool:
        """Whether the arguments of an action alone settle the comparisons."""
        names = {v.name for v in flat.rule.variables}
        return all(names.issuperset(side[1]) for sides in self._sides[id(flat)] for side in sides)


def _sides(compare: Compare) -> tuple[_Side, _Side]:
    """The smaller and the larger side of a comparison."""
    sides = [(term, tuple(sorted(free_names(term)))) for term in (compare.left, compare.right)]
    return (sides[1], sides[0]) if compare.operator in LOWER else (sides[0], sides[1])


def _check(tests: str) -> Callable[[int], bool]:
    check: Callable[[int], bool] = eval(f"lambda s: bool({tests})", {})
    return check


def size_of(args: Sequence[object]) -> int:
    """How many modules the chains among the arguments of an action have."""
    return sum(len(arg.modules) for arg in args if isinstance(arg, Chain))
