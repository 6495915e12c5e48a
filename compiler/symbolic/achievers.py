"""Who can make a fact true, and what must hold before: the ground of the landmarks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product

from ...langs.frozen import dataclass
from ..ir import Effect, Fact, Literal, Type, Var
from .domains import FlatRule
from .layout import STATIC
from .settings import SYMBOLIC
from .successors import Successors


@dataclass(frozen=True, slots=True)
class Achiever:
    """A rule, or one of its alternatives, with the variables that adding a fact binds."""

    flat: FlatRule
    env: Mapping[str, str]


class Achievers:
    """The ways in which facts of one problem can come to hold."""

    def __init__(self, successors: Successors) -> None:
        self.layout = successors.layout
        self.predicates = successors.problem.predicates
        self._known: dict[Fact, list[Achiever]] = {}
        self._conditions_of: dict[int, list[Literal]] = {}
        self._listed: dict[tuple[object, ...], list[Fact]] = {}
        self._adding: dict[str, list[tuple[FlatRule, Literal, dict[str, Type]]]] = {}
        for flat in self.layout.domains.rules:
            for effect, types in flat.additions():
                self._adding.setdefault(effect.literal.predicate, []).append((flat, effect.literal, types))

    def of(self, fact: Fact) -> list[Achiever]:
        """Every way in which an effect may add a fact."""
        if fact not in self._known:
            self._known[fact] = list(self._find(fact))
        return self._known[fact]

    def first(self, facts: Sequence[Fact]) -> list[Achiever]:
        """The ways in which some of the facts may come to hold while none does."""
        whole = self._orders(facts)
        return [a for fact in facts for a in self.of(fact) if not self._needs(a, whole)]

    def waiting(self, achiever: Achiever, facts: Sequence[Fact]) -> list[Fact]:
        """Facts one of which an achiever needs, and which only come to hold with or after some of `facts`; empty where
        there is no such need."""
        whole = self._orders(facts)
        for literal in self._conditions(achiever):
            needed = self.instances(literal, achiever)
            most = SYMBOLIC.most_instances
            makers = [a for fact in needed[:most] for a in self.of(fact)]
            if len(needed) <= most and all(self._needs(a, whole) or self._adds(a, whole) for a in makers):
                return needed
        return []

    def instances(self, literal: Literal, achiever: Achiever) -> list[Fact]:
        """All facts that a literal of an achiever may stand for; more than `most_instances` are not listed whole."""
        bound = (achiever.env.get(a.name) if isinstance(a, Var) else None for a in literal.args)
        key = (id(achiever.flat), id(literal), *bound)
        if key not in self._listed:
            self._listed[key] = self._instances(literal, achiever)
        return self._listed[key]

    def _instances(self, literal: Literal, achiever: Achiever) -> list[Fact]:
        domains = self.layout.domains.variable_domains(achiever.flat)
        types = {v.name: v.type for v in achiever.flat.variables}
        options: list[frozenset[str]] = []
        for k, arg in enumerate(literal.args):
            if isinstance(arg, Var) and arg.name in achiever.env:
                options.append(frozenset((achiever.env[arg.name],)))
            else:
                names = self.layout.domains.term(arg, types, domains)
                options.append(names & self.layout.domains.at(literal.predicate, k))
        if math.prod(map(len, options)) > SYMBOLIC.most_instances:
            return [(literal.predicate, str(i)) for i in range(SYMBOLIC.most_instances + 1)]
        facts = ((literal.predicate, *names) for names in product(*map(sorted, options)))
        return [f for f in facts if self.layout.encode(f)[0]]

    def fluent(self, literal: Literal) -> bool:
        return self.layout.kinds[literal.predicate] != STATIC

    def _conditions(self, achiever: Achiever) -> list[Literal]:
        key = id(achiever.flat)
        if key not in self._conditions_of:
            found = [f for f in achiever.flat.conjuncts if isinstance(f, Literal) and self.fluent(f)]
            self._conditions_of[key] = found
        return self._conditions_of[key]

    def _needs(self, achiever: Achiever, facts: frozenset[Fact]) -> bool:
        """Whether some condition can only be met by one of the facts."""
        predicates = {fact[0] for fact in facts}
        found = [f for f in self._conditions(achiever) if f.predicate in predicates]
        return any(facts.issuperset(self.instances(f, achiever)) for f in found)

    def _adds(self, achiever: Achiever, facts: frozenset[Fact]) -> bool:
        """Whether it adds one of the facts whatever its variables are."""
        predicates = {fact[0] for fact in facts}
        plain = (e.literal for e in achiever.flat.rule.effects if isinstance(e, Effect) and not e.negated)
        found = [e for e in plain if e.predicate in predicates and not e.motion]
        return any(facts.issuperset(self.instances(e, achiever)) for e in found)

    def _orders(self, facts: Sequence[Fact]) -> frozenset[Fact]:
        turned = ((f[0], *f[:0:-1]) for f in facts if self.predicates[f[0]].symmetric)
        return frozenset((*facts, *turned))

    def _find(self, fact: Fact) -> Iterator[Achiever]:
        for flat, literal, types in self._adding.get(fact[0], ()):
            for order in sorted(self._orders((fact,)), key=lambda f: f != fact):
                env = self._unified(literal, order, flat, types)
                if env is not None:
                    yield Achiever(flat, env)

    def _unified(
        self, literal: Literal, fact: Fact, flat: FlatRule, types: dict[str, Type]
    ) -> dict[str, str] | None:
        domains = self.layout.domains.variable_domains(flat)
        own = {v.name for v in flat.rule.variables}
        env: dict[str, str] = {}
        for arg, name in zip(literal.args, fact[1:], strict=True):
            if name not in self.layout.domains.term(arg, types, domains):
                return None
            if isinstance(arg, Var) and arg.name in own and env.setdefault(arg.name, name) != name:
                return None
        return env
