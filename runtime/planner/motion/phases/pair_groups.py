"""Pairs by the groups that their two sides belong to: boxes around whole groups leave out most pairs of long chains."""

from __future__ import annotations

import numpy as np

from ....skeleton import Array
from .batch_kinematics import Indices


class PairGroups:
    """The pairs `(P, 2)` of things, `group` `(things,)` of which each thing belongs to."""

    def __init__(self, pairs: Indices, group: Indices) -> None:
        self.order = np.argsort(group, kind="stable")
        """The things, group by group."""
        self.first = np.flatnonzero(np.diff(group[self.order], prepend=-1))
        """Where each group begins there."""
        among = np.cumsum(np.diff(group[self.order], prepend=-1) > 0) - 1
        number = np.empty(len(group), np.intp)
        number[self.order] = among
        self.joined, join = np.unique(number[pairs], axis=0, return_inverse=True)
        self._pairs = np.argsort(join.ravel(), kind="stable")
        self._count = np.bincount(join.ravel(), minlength=len(self.joined))
        self._before = np.cumsum(self._count) - self._count

    def meeting(self, centres: Array, grown: Array) -> tuple[Indices, Indices, Indices]:
        """The pairs, phases and times `(m,)`, in this order, at which boxes around all spheres of two groups meet, for
        their centres `(things, 3, phases, times)` and radii, which broadcast to `(things, phases, times)`."""
        ordered, radius = centres[self.order], grown[self.order][:, None]
        low = np.minimum.reduceat(ordered - radius, self.first)
        high = np.maximum.reduceat(ordered + radius, self.first)
        one, other = self.joined.T
        meet = np.ones((len(one), *centres.shape[2:]), bool)
        for axis in range(3):
            meet &= low[one, axis] <= high[other, axis]
            meet &= low[other, axis] <= high[one, axis]
        join, phase, time = np.nonzero(meet)
        count = self._count[join]
        ahead = np.cumsum(count) - count
        row = np.repeat(np.arange(len(join)), count)
        pair = self._pairs[self._before[join[row]] + np.arange(len(row)) - ahead[row]]
        order = np.lexsort((time[row], phase[row], pair))
        return pair[order], phase[row[order]], time[row[order]]
