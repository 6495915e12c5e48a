"""The moves until something can happen at a place, once strained actions are dearer.

As the tables of `locations`, but every move and the action that waits for it cost what a price says on top, by the
least strain that they can have there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .achievers import Achiever
from .locations import EdgeFamily, LocationEdge

Price = Callable[[str, Any], Any]
"""What an action costs beyond its own cost, by its rule and by how much it is strained at least; arrays broadcast."""


class Prices:
    """Priced tables of one location family. The strains are found once, whatever the price."""

    def __init__(self, family: EdgeFamily) -> None:
        self.family = family
        self._strains: dict[tuple[int, int], Any] = {}

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
        into = self._matrix(modules, price).T.copy()
        anywhere = [edge for edge in self.family.edges(modules) if edge.matrix is None]
        best, open_ = least.copy(), np.ones(len(least), dtype=bool)
        while True:
            place = int(np.argmin(np.where(open_, best, math.inf)))
            if not open_[place] or best[place] == math.inf:
                return best
            open_[place] = False
            np.minimum(best, into[place] + best[place], out=best)
            for edge in anywhere:
                if edge.targets[place]:
                    np.minimum(best, edge.cost + best[place], out=best)

    def _matrix(self, modules: int, price: Price) -> Any:
        """The cheapest priced move from every place to every other one."""
        count = len(self.family.places)
        cheapest = np.full((count, count), math.inf)
        for edge in self.family.edges(modules):
            if edge.matrix is not None:
                cost = edge.cost + price(edge.rule, self._strain(edge, modules))
                np.minimum(cheapest, np.where(edge.matrix, cost, math.inf), out=cheapest)
        return cheapest

    def _strain(self, edge: LocationEdge, modules: int) -> Any:
        key = (id(edge), modules)
        if key not in self._strains:
            self._strains[key] = self.family.bounds(modules).strain(edge.flat, edge.env)
        return self._strains[key]
