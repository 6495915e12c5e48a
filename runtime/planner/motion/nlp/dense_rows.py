"""The Gauss-Newton system of a small program: all rows in one dense matrix, whose square takes one call.

Up to some hundred unknowns, of which rows concern a good part, sums of small blocks into a band take longer.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....skeleton import Array
from .row_groups import ALL, RowGroup
from .unknowns import Indices


class DenseRows:
    """Rows of groups that always take part, followed by those that push, as a matrix over the unknowns."""

    def __init__(self, groups: Sequence[RowGroup], first_unknown: int, unknowns: int) -> None:
        self._groups, self._first, self._width = groups, first_unknown, unknowns + 1
        self._rows = 0
        targets = [np.zeros(0, dtype=np.int64)]
        for group in groups:
            targets.append(self.targets(group.span(), self._rows, group.shape[1]))
            self._rows += group.shape[0] * group.shape[1]
        self._always = np.concatenate(targets)
        self._last: tuple[Array | None, Array] = (None, np.zeros(0))

    def columns(self, places: Indices) -> Indices:
        """The columns of places in z; what is no unknown has one of its own behind the others."""
        return np.where(places < self._first, self._width - 1, places - self._first)

    def targets(self, places: Indices, first: int, rows: int) -> Indices:
        """Where the Jacobians of instances over `places` (N, n) go, of `rows` rows each from row `first` on."""
        at = first + np.arange(len(places) * rows).reshape(len(places), rows, 1)
        return (at * self._width + self.columns(places)[:, None, :]).ravel()

    def matrix(self, z: Array, pushing: Sequence[tuple[Array, Indices]]) -> Array:
        """All rows at z `(rows, unknowns)`, behind them Jacobians of what pushes with their places."""
        if self._last[0] is not z:
            nothing = np.zeros(0)
            self._last = z, np.concatenate([nothing, *(g.jacobians(z, ALL)[0].ravel() for g in self._groups)])
        values, targets, rows = [self._last[1]], [self._always], self._rows
        for jacobian, places in pushing:
            values.append(jacobian.ravel())
            targets.append(self.targets(places, rows, jacobian.shape[1]))
            rows += jacobian.shape[0] * jacobian.shape[1]
        if not rows:
            return np.zeros((0, self._width - 1))
        found = np.bincount(np.concatenate(targets), np.concatenate(values), minlength=rows * self._width)
        return np.asarray(found.reshape(rows, self._width)[:, :-1], dtype=np.float64)
