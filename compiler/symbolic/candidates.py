"""The values that a variable of a rule may have, by what its conjuncts leave of them at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..ir import (
    Chain,
    ChainEnd,
    ChainType,
    Compare,
    Formula,
    Literal,
    Object,
    ObjectType,
    RangeType,
    Term,
    Value,
    Var,
    Variable,
)
from .algebra import Environment, Undefined, holds, is_plain
from .chains import KnownFacts
from .layout import FLAG, STATIC
from .normal_form import free_names
from .settings import SYMBOLIC

if TYPE_CHECKING:
    from .guards import Guards


class Candidates:
    """Of the variables of `guards`."""

    def __init__(self, guards: Guards) -> None:
        self._guards = guards
        self._ordered: dict[frozenset[str], tuple[Value, ...]] = {}

    def branch(
        self,
        variables: Sequence[Variable],
        live: list[Formula],
        env: Environment,
        word: KnownFacts | None,
        domains: Mapping[str, frozenset[str]],
    ) -> tuple[Variable, Sequence[Value], list[Formula]]:
        """The variable with the fewest candidates, its values, and what is left to ask of the conjuncts."""
        chosen, values = self._most_constrained(variables, live, env, word, domains)
        return chosen, *self._filter(chosen, values, live, env)

    def _most_constrained(
        self,
        variables: Sequence[Variable],
        live: Sequence[Formula],
        env: Environment,
        word: KnownFacts | None,
        domains: Mapping[str, frozenset[str]],
    ) -> tuple[Variable, Sequence[Value]]:
        best: tuple[Variable, Sequence[Value]] | None = None
        for variable in variables:
            if isinstance(variable.type, RangeType) and not free_names(variable.type) <= env.keys():
                continue
            values = self._values(variable, live, env, word, domains.get(variable.name))
            if best is None or len(values) < len(best[1]):
                best = variable, values
        if best is None:
            raise Undefined
        return best

    def _values(
        self,
        variable: Variable,
        live: Sequence[Formula],
        env: Environment,
        word: KnownFacts | None,
        domain: frozenset[str] | None,
    ) -> Sequence[Value]:
        if isinstance(variable.type, ChainType):
            return self._chains(variable, live, env, word)
        if not isinstance(variable.type, ObjectType):
            return self._guards.values(variable, env, word)
        allowed = domain
        for formula in live:
            found = self._allowed(variable.name, formula, word)
            if found is not None:
                allowed = found if allowed is None else allowed & found
        everything = self._guards.values(variable, env, word)
        if allowed is None:
            return everything
        members = self._guards.layout.domains.of_type(variable.type.name)
        key = allowed & members
        if key not in self._ordered:
            self._ordered[key] = (*sorted(key, key=self._guards.geometry.index.__getitem__),)
        return self._ordered[key]

    def _chains(
        self, variable: Variable, live: Sequence[Formula], env: Environment, word: KnownFacts | None
    ) -> Sequence[Value]:
        """The chains whose ends those comparisons leave that tell one."""
        chains = self._guards.values(variable, env, word)
        for formula in live:
            for end, name in _told(formula):
                if isinstance(end, ChainEnd) and end.chain == variable.name:
                    chains = [c for c in chains if isinstance(c, Chain) and name == (c.first, c.last)[end.last]]
        return chains

    def _allowed(self, name: str, formula: Formula, word: KnownFacts | None) -> frozenset[str] | None:
        """The objects that one conjunct leaves for a variable; None when it says nothing at once."""
        for term, told in _told(formula):
            if term == Var(name):
                return frozenset((told,))
        if not isinstance(formula, Literal) or Var(name) not in formula.args:
            return None
        kind = self._guards.layout.kinds[formula.predicate]
        known = self._guards.static if kind == STATIC else word if kind == FLAG else None
        if known is None:
            return self._guards.layout.domains.at(formula.predicate, formula.args.index(Var(name)))
        return known.matching(formula, name)

    def _filter(
        self, variable: Variable, values: Sequence[Value], live: list[Formula], env: Environment
    ) -> tuple[Sequence[Value], list[Formula]]:
        """Settle comparisons of lengths for all candidates at once."""
        if len(values) <= SYMBOLIC.single_values or not isinstance(variable.type, ObjectType):
            return values, live
        usable = [f for f in live if isinstance(f, Compare) and free_names(f) == {variable.name} and is_plain(f)]
        if not usable:
            return values, live
        indices = self._guards.geometry.indices_of(values)
        keep = np.ones(len(indices), dtype=bool)
        for formula in usable:
            inner = {**env, variable.name: indices}
            left, right = (self._guards.number(side, inner) for side in (formula.left, formula.right))
            keep &= holds(formula.operator, left, right)
        return [values[int(i)] for i in np.flatnonzero(keep)], [f for f in live if f not in usable]


def _told(formula: Formula) -> Iterator[tuple[Term, str]]:
    """The terms of which a conjunct says which object they are."""
    if isinstance(formula, Compare) and formula.operator == "=":
        for here, there in ((formula.left, formula.right), (formula.right, formula.left)):
            if isinstance(there, Object):
                yield here, there.name
