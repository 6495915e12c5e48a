"""Which objects can ever stand at each position of each predicate: a sound, cheap bound on what is reachable.

Starts from the facts at the start and adds what effects can add, position by position, until nothing changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from ...langs.frozen import dataclass
from ..ir import (
    Any_,
    ChainEnd,
    ChainModule,
    ChainType,
    Effect,
    Formula,
    Literal,
    Object,
    ObjectType,
    Problem,
    Rule,
    Term,
    Type,
    Var,
    Variable,
    effects_of,
    effects_with_loops,
)
from .normal_form import NormalForm

Names = frozenset[str]


@dataclass(frozen=True, slots=True)
class FlatRule:
    """A rule, or one of its alternatives, whose condition is `exists hidden { and of conjuncts }`."""

    rule: Rule
    hidden: tuple[Variable, ...]
    conjuncts: tuple[Formula, ...]

    @property
    def variables(self) -> tuple[Variable, ...]:
        return self.rule.variables + self.hidden

    def additions(self) -> Iterator[tuple[Effect, dict[str, Type]]]:
        """Every logic literal that an effect may add, with the types of the variables that it sees."""
        for effect, loops in effects_with_loops(self.rule.effects):
            if not effect.negated and not effect.literal.motion:
                yield effect, {v.name: v.type for v in (*self.variables, *loops)}


def flat_rules(problem: Problem, normal: NormalForm) -> list[FlatRule]:
    rules = [replace(r, effects=normal.effects(r.effects)) for r in problem.rules.values()]
    return [FlatRule(r, *found) for r in rules for found in normal.alternatives(r.condition)]


class Domains:
    """Objects by predicate and position, and by rule and variable. Rules that can never fire are left out of
    `rules`."""

    def __init__(self, problem: Problem, normal: NormalForm, flat: Sequence[FlatRule] | None = None) -> None:
        """`flat` are the problem's rules, where they are known."""
        self.problem = problem
        self.flat = flat_rules(problem, normal) if flat is None else flat
        self.changed = frozenset(
            e.literal.predicate for r in problem.rules.values() for e in effects_of(r.effects) if not e.literal.motion
        )
        self.swept = frozenset(
            e.literal.predicate
            for r in problem.rules.values()
            for e in effects_of(r.effects)
            if has_wildcard(e.literal)
        )
        """Predicates of which some effect deletes facts with ANY."""
        self._types: dict[str, Names] = {}
        self._at: dict[tuple[str, int], set[str]] = {}
        self._final: dict[tuple[str, int], Names] = {}
        for predicate, *args in problem.init:
            for k, name in enumerate(args):
                self._at.setdefault((predicate, k), set()).add(name)
        while self._grow():
            pass
        self._final = {key: frozenset(names) for key, names in self._at.items()}
        self._settled = {id(r): self._variable_domains(r) for r in self.flat}
        self.rules = tuple(r for r in self.flat if self._settled[id(r)] is not None)

    def at(self, predicate: str, position: int) -> Names:
        if self._final:
            return self._final.get((predicate, position), frozenset())
        return frozenset(self._at.get((predicate, position), ()))

    def of_type(self, name: str) -> Names:
        if name not in self._types:
            self._types[name] = frozenset(self.problem.of_type(name))
        return self._types[name]

    def variable_domains(self, flat: FlatRule) -> dict[str, Names]:
        """For every variable over objects of a rule that may fire the objects that it may denote."""
        return self._settled[id(flat)] or {}

    def _variable_domains(self, flat: FlatRule) -> dict[str, Names] | None:
        """For every variable over objects the objects that its type and the positive literals leave; None when some
        variable has none left."""
        found = {v.name: self.of_type(v.type.name) for v in flat.variables if isinstance(v.type, ObjectType)}
        for literal in flat.conjuncts:
            if not isinstance(literal, Literal):
                continue
            for k, arg in enumerate(literal.args):
                if isinstance(arg, Var) and arg.name in found:
                    found[arg.name] &= self.at(literal.predicate, k)
                elif (literal.predicate, k) not in self._at:
                    return None
        return found if all(found.values()) else None

    def term(self, term: Term, variables: dict[str, Type], names: dict[str, Names]) -> Names:
        """The objects that an argument of an effect may denote."""
        match term:
            case Object():
                return frozenset((term.name,))
            case Var():
                if term.name in names:
                    return names[term.name]
                kind = variables[term.name]
                return self.of_type(kind.name) if isinstance(kind, ObjectType) else frozenset()
            case ChainEnd() | ChainModule():
                kind = variables[term.chain]
                element = kind.element if isinstance(kind, ChainType) else "module"
                modules = self.of_type(element)
                if isinstance(term, ChainModule) and not term.side:
                    return modules
                return frozenset(e for e in self.of_type("effector") if self.problem.world.owner(e) in modules)
            case _:
                return frozenset()

    def _grow(self) -> bool:
        grown = False
        for flat in self.flat:
            names = self._variable_domains(flat)
            if names is None:
                continue
            for effect, inner in flat.additions():
                literal = effect.literal
                symmetric = self.problem.predicates[literal.predicate].symmetric
                domains = [self.term(a, inner, names) for a in literal.args]
                for k, domain in enumerate(domains):
                    for position in (range(len(domains)) if symmetric else (k,)):
                        here = self._at.setdefault((literal.predicate, position), set())
                        grown = grown or not domain <= here
                        here |= domain
        return grown


def has_wildcard(literal: Literal) -> bool:
    return any(isinstance(a, Any_) for a in literal.args)
