"""The moves until something can happen at a place, once strained actions are dearer.

As the tables of `locations`, but every move and the action that waits for it cost what a price says on top, by the
least strain that they can have there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...langs.frozen import dataclass
from .achievers import Achiever
from .locations import EdgeFamily, LocationEdge

Price = Callable[[str, Any], Any]
"""What an action costs beyond its own cost, by its rule and by how much it is strained at least; arrays broadcast."""


@dataclass(frozen=True, slots=True)
class _Moves:
    """The moves between places that some edges of a family allow: of each edge with the strain of each of its moves,
    and of all of them, one edge after the other, an order by where they lead, from where they lead there, and where in
    it those to each place begin `(places + 1,)`."""

    strained: list[tuple[LocationEdge, Any]]
    order: NDArray[np.int64]
    sources: NDArray[np.int64]
    first: NDArray[np.int64]


class Prices:
    """Priced tables of one location family. The strains are found once, whatever the price."""

    def __init__(self, family: EdgeFamily) -> None:
        self.family = family
        self._moves: dict[int, _Moves] = {}

    def table(self, achievers: Sequence[Achiever], modules: int, price: Price) -> tuple[float, ...] | None:
        """What the moves until some achiever fires, and that itself, cost at least beyond the achiever's own cost while
        no chain has more than so many modules: from nowhere, then from every place. None when one of them may fire
        wherever its robot is."""
        least = np.full(len(self.family.places), math.inf)
        for achiever in achievers:
            places = self.family.starts(achiever.flat, achiever.env, modules)
            if places is None:
                return None
            strain = self.family.strain(achiever.flat, achiever.env, modules)
            least = np.minimum(least, np.where(places, price(achiever.flat.rule.name, strain), math.inf))
        distances = self._shortest(least, modules, price)
        return self.family.with_nowhere([float(d) for d in distances], modules)

    def _shortest(self, least: Any, modules: int, price: Price) -> Any:
        """Dijkstra's distances to the places that have a finite `least`, with that on top."""
        moves, costs = self._between(modules), self._costs(modules, price)
        anywhere = [edge for edge in self.family.edges(modules) if edge.matrix is None]
        best, open_ = least.copy(), np.ones(len(least), dtype=bool)
        while True:
            place = int(np.argmin(np.where(open_, best, math.inf)))
            if not open_[place] or best[place] == math.inf:
                return best
            open_[place] = False
            here = slice(moves.first[place], moves.first[place + 1])
            np.minimum.at(best, moves.sources[here], costs[here] + best[place])
            for edge in anywhere:
                if edge.targets[place]:
                    np.minimum(best, edge.cost + best[place], out=best)

    def _costs(self, modules: int, price: Price) -> Any:
        """What each move costs, in the order by where they lead."""
        moves = self._between(modules)
        priced = [edge.cost + price(edge.rule, strain) for edge, strain in moves.strained]
        return np.concatenate(priced)[moves.order] if priced else np.zeros(0)

    def _between(self, modules: int) -> _Moves:
        if modules not in self._moves:
            count, bounds = len(self.family.places), self.family.bounds(modules)
            strained, sources, targets = [], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
            for edge in self.family.edges(modules):
                if edge.matrix is not None:
                    source, target = np.nonzero(edge.matrix)
                    env = {n: np.broadcast_to(v, (count, count))[source, target] for n, v in edge.env.items()}
                    strain = np.broadcast_to(bounds.strain(edge.flat, env), source.shape)
                    strained.append((edge, strain))
                    sources.append(source)
                    targets.append(target)
            leads = np.concatenate(targets)
            order = np.argsort(leads, kind="stable")
            first = np.searchsorted(leads[order], np.arange(count + 1))
            self._moves[modules] = _Moves(strained, order, np.concatenate(sources)[order], first)
        return self._moves[modules]
