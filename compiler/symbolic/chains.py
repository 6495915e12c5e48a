"""A set of known facts with an index, and the chains of modules that they make."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

from ..ir import Chain, ChainType, Fact, Literal, Object, Problem, Var


class KnownFacts:
    """The facts between small objects that one flag word stands for (or any other fixed set of facts)."""

    def __init__(self, problem: Problem, facts: Iterable[Fact]) -> None:
        self.problem = problem
        self.facts = frozenset(facts)
        self._chains: dict[ChainType, tuple[Chain, ...]] = {}
        self._matches: dict[tuple[Literal, str], frozenset[str]] = {}

    def holds(self, fact: Fact) -> bool:
        return fact in self.facts

    @cached_property
    def _by_predicate(self) -> dict[str, list[Fact]]:
        found: dict[str, list[Fact]] = {}
        for fact in sorted(self.facts):
            found.setdefault(fact[0], []).append(fact)
        return found

    @cached_property
    def _by_argument(self) -> dict[tuple[str, int, str], list[Fact]]:
        found: dict[tuple[str, int, str], list[Fact]] = {}
        for fact in sorted(self.facts):
            for k, name in enumerate(fact[1:]):
                found.setdefault((fact[0], k, name), []).append(fact)
        return found

    def matching(self, literal: Literal, variable: str) -> frozenset[str]:
        """The objects that `variable` may denote in a literal whose other arguments are known or free."""
        key = (literal, variable)
        if key not in self._matches:
            facts = self._by_predicate.get(literal.predicate, [])
            for k, arg in enumerate(literal.args):
                if isinstance(arg, Object):
                    narrower = self._by_argument.get((literal.predicate, k, arg.name), [])
                    facts = narrower if len(narrower) < len(facts) else facts
            at = literal.args.index(Var(variable))
            self._matches[key] = frozenset(f[at + 1] for f in facts if _agrees(literal, f))
        return self._matches[key]

    def chains(self, kind: ChainType) -> tuple[Chain, ...]:
        """All maximal lines of modules of the type, each once from each end, in the order of declaration."""
        if kind not in self._chains:
            self._chains[kind] = tuple(_chains(self.problem, kind, self._by_predicate.get(kind.predicate, [])))
        return self._chains[kind]


def _agrees(literal: Literal, fact: Fact) -> bool:
    seen: dict[str, str] = {}
    for arg, name in zip(literal.args, fact[1:], strict=True):
        if isinstance(arg, Object) and arg.name != name:
            return False
        if isinstance(arg, Var) and seen.setdefault(arg.name, name) != name:
            return False
    return True


def _chains(problem: Problem, kind: ChainType, facts: list[Fact]) -> Iterable[Chain]:
    ends: dict[str, list[str]] = {}
    for name in problem.of_type(kind.element):
        if name in problem.world.modules:
            ends[name] = [f"{name}.{e.name}" for e in problem.world.modules[name].type.effectors]
    owner = {effector: module for module, effectors in ends.items() for effector in effectors}
    links: dict[str, list[str]] = {}
    for _, first, second in facts:
        if first in owner and second in owner:
            links.setdefault(first, []).append(second)
            links.setdefault(second, []).append(first)

    def walk(line: list[tuple[str, str, str]], enter: str) -> Iterable[Chain]:
        module = owner[enter]
        for leave in ends[module]:
            if leave == enter:
                continue
            longer = [*line, (module, enter, leave)]
            following = list(dict.fromkeys(links.get(leave, ())))
            if not following:
                yield Chain(tuple(longer))
            for other in following:
                if all(owner[other] != visited for visited, _, _ in longer):
                    yield from walk(longer, other)

    for effectors in ends.values():
        for enter in effectors:
            if enter not in links:
                yield from walk([], enter)
