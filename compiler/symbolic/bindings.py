"""The values of a rule's small variables under which its conditions on the flags hold, flag word after flag word.

Words differ in little: an action changes a few facts about a few modules. So each part of the search for values notes
which facts it asked about, and is taken over by other words in which the answers are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from ..ir import Chain, ChainType, Fact, Formula, Literal, Variable
from .algebra import Environment
from .chains import KnownFacts
from .domains import FlatRule
from .guards import Guards
from .settings import SYMBOLIC

Found = TypeVar("Found")
Key = tuple[object, ...]


@dataclass(slots=True)
class Answers:
    """What some words say alike."""

    true: set[Fact] = field(default_factory=set)
    false: set[Fact] = field(default_factory=set)
    matches: dict[tuple[Literal, str], frozenset[str]] = field(default_factory=dict)
    chains: dict[ChainType, tuple[Chain, ...]] = field(default_factory=dict)

    def add(self, other: Answers) -> None:
        self.true |= other.true
        self.false |= other.false
        self.matches |= other.matches
        self.chains |= other.chains

    def hold(self, word: KnownFacts) -> bool:
        """Whether a word gives the same answers."""
        return (
            self.true <= word.facts
            and self.false.isdisjoint(word.facts)
            and all(word.chains(kind) == chains for kind, chains in self.chains.items())
            and all(word.matching(*question) == found for question, found in self.matches.items())
        )


class Watched(KnownFacts):
    """A word that notes what it is asked."""

    def __init__(self, word: KnownFacts) -> None:
        self.word, self.answers = word, Answers()

    def holds(self, fact: Fact) -> bool:
        found = self.word.holds(fact)
        (self.answers.true if found else self.answers.false).add(fact)
        return found

    def matching(self, literal: Literal, variable: str) -> frozenset[str]:
        found = self.answers.matches[literal, variable] = self.word.matching(literal, variable)
        return found

    def chains(self, kind: ChainType) -> tuple[Chain, ...]:
        found = self.answers.chains[kind] = self.word.chains(kind)
        return found


class Bindings(Generic[Found]):
    """What `made` makes of all values of a rule, given what remains of its conjuncts, and the word, of which it may ask
    more; None is left out."""

    def __init__(
        self, guards: Guards, made: Callable[[FlatRule, Environment, tuple[Formula, ...], KnownFacts], Found | None]
    ) -> None:
        self.guards, self.made = guards, made
        self._known: dict[Key, list[tuple[Answers, list[Found]]]] = {}

    def of(
        self, flat: FlatRule, variables: Sequence[Variable], domains: Mapping[str, frozenset[str]], word: KnownFacts
    ) -> list[Found]:
        return self._of(flat, variables, flat.conjuncts, {}, domains, Answers(), word)[1]

    def _of(
        self, flat: FlatRule, variables: Sequence[Variable], conjuncts: Sequence[Formula], env: Environment,
        domains: Mapping[str, frozenset[str]], before: Answers, word: KnownFacts,
    ) -> tuple[Answers, list[Found]]:  # fmt: skip
        """Also what was asked: `before`, to come to these conjuncts, and since."""
        known = self._known.setdefault((id(flat), *env.items()), [])
        for answers, found in known:
            if answers.hold(word):
                return answers, found
        asked = Watched(word)
        asked.answers.add(before)
        live, found = self.guards.live(conjuncts, env, asked), list[Found]()
        if live is not None and not variables:
            one = self.made(flat, env, tuple(live), asked)
            found = [] if one is None else [one]
        elif live is not None:
            settled = Answers()
            settled.add(asked.answers)
            chosen, values, live = self.guards.candidates.branch(variables, live, env, asked, domains)
            others = [v for v in variables if v is not chosen]
            for value in values:
                inner = self._of(flat, others, live, {**env, chosen.name: value}, domains, settled, word)
                asked.answers.add(inner[0])
                found += inner[1]
        known.append((asked.answers, found))
        del known[:-SYMBOLIC.remembered_answers]
        return asked.answers, found
