"""Pairs of spheres and solids by blocks, told apart only where the boxes around the parts of a block are near."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from .....langs.frozen import dataclass
from ....skeleton import Array
from ..nlp.unknowns import Indices
from .settings import COLLISION

SLACK = 1e-6
"""Metres by which boxes may be wrong."""

Runs = Indices
"""Successive numbers, each with its owner `(R, 3)`: first number, how many, number of the owner."""
Edges = tuple[Array, Array]
"""Least and greatest coordinates `(N, 3)` of things, in metres, in the world."""


@dataclass(frozen=True, slots=True)
class Pairs:
    """Pairs of things by their numbers `first` and `second` `(K,)`, the distances that are `wanted` and that they must
    keep at `least` `(K,)` in metres, and (phase, owner, owner) `(K, 3)` of each; `places` `(K,)` tells them apart and
    orders them."""

    places: Indices
    first: Indices
    second: Indices
    wanted: Array
    tags: Indices
    least: Array

    def __getitem__(self, chosen: Indices) -> Pairs:
        return Pairs(
            self.places[chosen], self.first[chosen], self.second[chosen], self.wanted[chosen], self.tags[chosen],
            self.least[chosen],
        )  # fmt: skip

    def joined(self, other: Pairs) -> tuple[Pairs, NDArray[np.bool_]]:
        """These pairs and others, each once and in order, and which of them `(K,)` are of these."""
        places, at = np.unique(np.concatenate([self.places, other.places]), return_index=True)
        both = Pairs(
            places,
            np.concatenate([self.first, other.first])[at], np.concatenate([self.second, other.second])[at],
            np.concatenate([self.wanted, other.wanted])[at], np.concatenate([self.tags, other.tags])[at],
            np.concatenate([self.least, other.least])[at],
        )  # fmt: skip
        return both, at < len(self.places)


class OwnerMargins:
    """The margins of two things by their owners, in metres, wished and least: `usual` and 0, or what `special` says."""

    def __init__(self, usual: float, special: Mapping[tuple[int, int], tuple[float, float]]) -> None:
        self.usual = usual
        self.most = max([usual, *(wished for wished, _ in special.values())])
        pairs = np.array(sorted(special), dtype=np.int64).reshape(-1, 2)
        self._width = int(pairs.max(initial=0)) + 1
        self._codes = pairs[:, 0] * self._width + pairs[:, 1]
        self._margins = np.array([special[key] for key in sorted(special)]).reshape(-1, 2)

    def __getitem__(self, owners: tuple[Indices, Indices]) -> Array:
        """`(K, 2)` of pairs of owners `(K,)`; -inf where they may touch."""
        one, other = owners
        result = np.zeros((len(one), 2))
        result[:, 0] = self.usual
        known = np.flatnonzero((one < self._width) & (other < self._width))
        if len(known) and len(self._codes):
            codes = one[known] * self._width + other[known]
            at = np.minimum(np.searchsorted(self._codes, codes), len(self._codes) - 1)
            same = self._codes[at] == codes
            result[known[same]] = self._margins[at[same]]
        return result


@dataclass(frozen=True, slots=True)
class Grid:
    """Every run of `first` against every one of `second`, in a phase; the places of their pairs begin at `place`."""

    place: int
    phase: int
    first: Runs
    second: Runs
    margins: OwnerMargins


NO_PAIRS = Pairs(
    np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0),
    np.zeros((0, 3), dtype=np.int64), np.zeros(0),
)  # fmt: skip


class Blocks:
    """Blocks of pairs: everything in one run against everything in another."""

    def __init__(self) -> None:
        self._size = 0
        self._large: list[Grid] = []
        self._rows = [np.zeros((0, 9), dtype=np.int64)]
        self._margins = [np.zeros((0, 2))]
        self._finished: tuple[Indices, Array] | None = None
        self._runs: list[tuple[Indices, Indices]] = []

    def __len__(self) -> int:
        return sum(map(len, self._margins)) + sum(len(grid.first) * len(grid.second) for grid in self._large)

    def grid(self, phase: int, first: Runs, second: Runs, margins: OwnerMargins) -> None:
        """Every run of `first` against every one of `second`, kept apart as `margins` says of their owners. Of many
        only those are looked at that are near all of `first`."""
        grid = Grid(self._size, phase, first, second, margins)
        if len(second) > COLLISION.listed_runs:
            self._large.append(grid)
        else:
            self._keep(*_rows_of(grid, np.arange(len(second))))
        self._size += int(first[:, 1].sum()) * int(second[:, 1].sum())

    def pairs(self, phase: int, first: Runs, second: Runs, margins: Array) -> None:
        """Each run of `first`, a single thing, against the same one of `second`; `margins` `(K, 2)` as for grids."""
        self._keep(*_rows(phase, first, second, self._size + np.arange(len(first)), 1, margins))
        self._size += len(first)

    def _keep(self, rows: Indices, margins: Array) -> None:
        self._rows.append(rows)
        self._margins.append(margins)
        self._finished = None

    def _tables(self) -> tuple[Indices, Array]:
        if self._finished is None:
            self._finished = (np.concatenate(self._rows), np.concatenate(self._margins))
            self._runs = [_distinct(self._finished[0][:, at : at + 2]) for at in (2, 4)]
        return self._finished

    def near(self, first: Edges, second: Edges, near: float) -> Pairs:
        """All pairs of the blocks whose parts' boxes are closer than `near` beyond the distance to keep, by the edges
        of all things that `first` and `second` number."""
        rows, margins = self._tables()
        sides = self._runs
        if self._large:
            found = [_rows_of(grid, _close(grid, first, second, near)) for grid in self._large]
            rows = np.concatenate([rows, *(some for some, _ in found)])
            margins = np.concatenate([margins, *(some for _, some in found)])
            sides = [_distinct(rows[:, at : at + 2]) for at in (2, 4)]
        if not len(rows):
            return NO_PAIRS
        (low, high), (other_low, other_high) = (
            tuple(side[which] for side in _around(edges, runs))
            for edges, (runs, which) in zip((first, second), sides, strict=True)
        )
        apart = np.maximum(np.maximum(low - other_high, other_low - high), 0.0)
        chosen = np.flatnonzero(np.einsum("ij,ij->i", apart, apart) <= (near + margins[:, 0] + SLACK) ** 2)
        return _expanded(rows[chosen], margins[chosen])


def _rows_of(grid: Grid, chosen: Indices) -> tuple[Indices, Array]:
    """The blocks of a grid with the `chosen` ones of its second runs, and their margins."""
    first, second = grid.first, grid.second
    each, every = np.repeat(np.arange(len(first)), len(chosen)), np.tile(chosen, len(first))
    width = int(second[:, 1].sum())
    place = grid.place + _before(first)[each] * width + _before(second)[every]
    margins = grid.margins[first[each, 2], second[every, 2]]
    return _rows(grid.phase, first[each], second[every], place, width, margins)


def _rows(
    phase: int, first: Runs, second: Runs, place: Indices, width: int, margins: Array
) -> tuple[Indices, Array]:
    """Blocks of runs that may not touch, and their margins."""
    kept = np.isfinite(margins[:, 0])
    rows = np.empty((len(place), 9), dtype=np.int64)
    rows[:, 0], rows[:, 1] = place, width
    rows[:, 2:4], rows[:, 4:6] = first[:, :2], second[:, :2]
    rows[:, 6], rows[:, 7], rows[:, 8] = phase, first[:, 2], second[:, 2]
    return rows[kept], margins[kept]


def _close(grid: Grid, first: Edges, second: Edges, near: float) -> Indices:
    """Those of the second runs of a grid that are near the box around all of the first ones."""
    low, high = _around(first, grid.first)
    other_low, other_high = _around(second, grid.second)
    far = near + grid.margins.most + SLACK
    inside = (other_low <= high.max(axis=0) + far) & (other_high >= low.min(axis=0) - far)
    return np.flatnonzero(inside.all(axis=1))


def _before(runs: Runs) -> Indices:
    """How many things come before each run."""
    return np.cumsum(runs[:, 1]) - runs[:, 1]


def _distinct(runs: Indices) -> tuple[Indices, Indices]:
    """The distinct ones among runs `(K, 2)`, and which of them each is."""
    width = int(runs[:, 1].max(initial=0)) + 1
    found, which = np.unique(runs[:, 0] * width + runs[:, 1], return_inverse=True)
    return np.stack(np.divmod(found, width), axis=1), which


def _around(edges: Edges, runs: Indices) -> Edges:
    """The edges of runs `(R, 2)` of things."""
    ends = np.stack([runs[:, 0], runs[:, 0] + runs[:, 1]], axis=1).ravel()
    low, high = (np.concatenate([side, side[-1:]]) for side in edges)
    return np.minimum.reduceat(low, ends)[::2], np.maximum.reduceat(high, ends)[::2]


def _expanded(rows: Indices, margins: Array) -> Pairs:
    """The pairs of blocks, in order."""
    counts = rows[:, 3] * rows[:, 5]
    block = np.repeat(np.arange(len(rows)), counts)
    within = np.arange(len(block)) - np.repeat(np.cumsum(counts) - counts, counts)
    i, j = np.divmod(within, rows[block, 5])
    places = rows[block, 0] + i * rows[block, 1] + j
    order = np.argsort(places, kind="stable")
    block, i, j = block[order], i[order], j[order]
    wanted, least = margins[block].T
    return Pairs(places[order], rows[block, 2] + i, rows[block, 4] + j, wanted, rows[block, 6:9], least)
