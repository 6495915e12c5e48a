"""How many modules a chain can have after so many more links: the price of reach.

A line of modules after k new links is made of at most k + 1 pieces, each inside a group of modules that are linked now;
so it has no more modules than the k + 1 largest groups together. Links that are undone only make groups smaller.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from ..ir import ChainType, EffectFor, EffectItem, effects_of
from .domains import FlatRule
from .guards import Guards
from .layout import FLAG

Stages = tuple[tuple[int, float], ...]
"""For ever more links: how many modules a chain may have then, and what the links cost at least."""


class Links:
    """The facts of which chains are made, the rules that add them, and what chains they allow."""

    def __init__(self, guards: Guards, costs: Mapping[str, float]) -> None:
        self.guards = guards
        layout = guards.layout
        world = guards.problem.world
        self.count = max(len(world.modules), 1)
        rules = layout.domains.rules
        kinds = {v.type for r in layout.domains.flat for v in r.variables if isinstance(v.type, ChainType)}
        self.predicates = {k.predicate for k in kinds}
        self.pairs = [
            (bit, world.owner(fact[1]), world.owner(fact[2]))
            for fact, bit in layout.flags.items()
            if fact[0] in self.predicates and len(fact) == 3
        ]
        self.mask = sum(bit for bit, _, _ in self.pairs)
        added = {r.rule.name: _added(r, self.predicates, self.count) for r in rules}
        self.rules = {name for name, count in added.items() if count}
        self.most = max((added[name] for name in self.rules), default=1)
        self.cost = min((costs[name] for name in self.rules), default=math.inf)
        flags = all(layout.kinds[p] == FLAG for p in self.predicates if p in {n for r in rules for n in _names(r)})
        self.counted = bool(self.rules) and flags and self.count > 1
        """Whether links can be counted at all."""
        self._known: dict[int, Stages] = {}

    def stages(self, word: int) -> Stages:
        """What chains the links in `word` (the state's bits in `mask`) allow with 0, 1, … links more."""
        found = self._known.get(word)
        if found is None:
            found = self._known[word] = tuple(self._stages(word))
        return found

    def _stages(self, word: int) -> Iterator[tuple[int, float]]:
        sizes = self._groups(word)
        total = 0
        for k, size in enumerate(sizes):
            total += size
            yield total, math.ceil(k / self.most) * self.cost if k else 0.0

    def _groups(self, word: int) -> list[int]:
        """Sizes of the groups of linked modules, the largest first."""
        groups = {name: {name} for name in self.guards.problem.world.modules}
        for bit, first, second in self.pairs:
            if word & bit and first in groups and second in groups and groups[first] is not groups[second]:
                joined = groups[first] | groups[second]
                groups.update(dict.fromkeys(joined, joined))
        distinct = {id(group): len(group) for group in groups.values()}
        return sorted(distinct.values(), reverse=True)


def _names(flat: FlatRule) -> set[str]:
    return {e.literal.predicate for e in effects_of(flat.rule.effects) if not e.literal.motion}


def _added(flat: FlatRule, predicates: set[str], many: int) -> int:
    """How many links one action of a rule adds at most."""

    def count(items: tuple[EffectItem, ...]) -> int:
        total = 0
        for item in items:
            effects = list(effects_of((item,)))
            adding = [e for e in effects if e.literal.predicate in predicates and not e.negated]
            adding = [e for e in adding if not e.literal.motion]
            total += many if isinstance(item, EffectFor) and adding else len(adding)
        return total

    return count(flat.rule.effects)
