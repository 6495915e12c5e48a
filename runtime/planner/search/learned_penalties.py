"""What strained actions cost beyond their own cost, learnt from what motion refused."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ....compiler.symbolic.strain import Strain, size_of
from .settings import SEARCH

Kind = tuple[str, int]
"""Actions that share a limit: those of robots of one size, whatever their rule; or those of a rule without robots."""


class LearnedPenalties:
    """What the search should add to the cost of strained actions. It grows with every sequence that motion refused,
    and is measured by the strain of the most strained action of such a sequence, for all of its kind."""

    def __init__(self, strain: Strain) -> None:
        self.strain = strain
        self.weight = 0.0
        self._limits: dict[Kind, float] = {}
        self._shown: dict[Kind, float] = {}
        self._accepted = False
        self._kinds: dict[int, Kind] = {}
        self._kinds_of_rules: dict[str, set[Kind]] = {}
        self._settled: dict[int, float] = {}

    def inherit(self, other: LearnedPenalties) -> None:
        """Begin with what another search of the same rules has learnt. Once motion has accepted something, that weighs
        less, and no strain that was accepted is a limit."""
        self._shown = dict(other._shown)
        self._kinds_of_rules = {rule: set(kinds) for rule, kinds in other._kinds_of_rules.items()}
        self.weight, self._limits = min(other.weight, SEARCH.penalty_inherited), dict(other._limits)
        if other._accepted:
            self.weight = min(SEARCH.penalty_fading * other.weight, SEARCH.penalty_inherited)
            self._limits = {
                kind: max(1.0 - SEARCH.limit_forgetting * (1.0 - limit), min(1.0, self._shown.get(kind, 0.0)))
                for kind, limit in other._limits.items()
            }

    def accepted(self, numbers: Sequence[int]) -> None:
        """The first actions of a plan, in a row from the start, got their motion."""
        self._accepted = True
        for number, strain in zip(numbers, self.strain.along(numbers), strict=True):
            kind = self._kind(number)
            self._shown[kind] = max(strain, self._shown.get(kind, 0.0))

    def refused(self, numbers: Sequence[int], first: int, last: int) -> None:
        """Actions `first` … `last` of a plan were refused one after the other. One alone is forbidden, not dearer; and
        where none is strained, that is not why."""
        strains = self.strain.along(numbers[: last + 1])
        worst = max(range(first, last + 1), key=lambda k: strains[k])
        if first == last or strains[worst] < SEARCH.strained_from:
            return
        self.weight = max(SEARCH.penalty_first, min(self.weight * SEARCH.penalty_growth, SEARCH.penalty_most))
        self._settled.clear()
        for number in range(self.strain.successors.action_count):
            self._kind(number)
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
        return self.weight * (self.strain.of(state, number) / limit) ** SEARCH.penalty_power if limit > 0.0 else 0.0

    def price(self, rule: str, strain: Any) -> Any:
        """The surcharge of actions of a rule by their strain, on robots of the size that was met with the highest
        limit; arrays broadcast."""
        limit = max((self._limits.get(kind, 1.0) for kind in self._kinds_of_rules.get(rule, ())), default=1.0)
        return self.weight * (strain / limit) ** SEARCH.penalty_power if limit > 0.0 else 0.0 * strain

    def _kind(self, number: int) -> Kind:
        if number not in self._kinds:
            action = self.strain.successors.action(number)
            size = size_of(action.args)
            kind = self._kinds[number] = ("" if size else action.rule, size)
            self._kinds_of_rules.setdefault(action.rule, set()).add(kind)
        return self._kinds[number]
