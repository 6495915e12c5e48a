"""Sums of a program's rows: contributions of many instances to a gradient and to a lower band, added up in one go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....skeleton import Array
from .row_groups import ALL, RowGroup
from .unknowns import Indices


class Scatter:
    """Where the products of rows over `places` (N, n) go: `band` (N, n, n) in the flat lower band, `gradient` (N, n).
    What is no unknown, or lies above the diagonal, goes behind the last place."""

    def __init__(self, places: Indices, first_unknown: int, shape: tuple[int, int]) -> None:
        unknowns, width = shape
        unknown = places - first_unknown
        rows, columns = unknown[:, :, None], unknown[:, None, :]
        band = columns * (width - 1) + rows
        band[(columns < 0) | (rows < columns)] = unknowns * width
        self.band = band
        self.gradient = np.where(unknown < 0, unknowns, unknown)


class Sums:
    """Contributions to a gradient (unknowns,) and to a lower band (unknowns, width)."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.shape = shape
        self._values: list[Array] = []
        self._targets: list[Indices] = []
        self._slopes: list[Array] = []
        self._slope_targets: list[Indices] = []

    def add(self, targets: Indices, values: Array) -> None:
        """Add values to flat places of the band."""
        self._targets.append(targets)
        self._values.append(values)

    def pull(self, targets: Indices, values: Array) -> None:
        """Add values to places of the gradient."""
        self._slope_targets.append(targets)
        self._slopes.append(values)

    @staticmethod
    def _sum(targets: list[Indices], values: list[Array], size: int) -> Array:
        if not targets:
            return np.zeros(size)
        sums = np.bincount(np.concatenate(targets), np.concatenate(values), minlength=size + 1)
        return np.asarray(sums[:size], dtype=np.float64)

    def gradient(self) -> Array:
        return self._sum(self._slope_targets, self._slopes, self.shape[0])

    def band(self) -> Array:
        return self._sum(self._targets, self._values, self.shape[0] * self.shape[1]).reshape(self.shape)


class Together:
    """Groups all of whose instances take part: where their products go is found once, and only what goes somewhere is
    added."""

    def __init__(self, groups: Sequence[RowGroup], first_unknown: int, shape: tuple[int, int]) -> None:
        self.groups = groups
        unknowns, width = shape
        scatters = [Scatter(group.span(), first_unknown, shape) for group in groups]
        self._source, self._target = self._kept([s.band for s in scatters], unknowns * width)
        self._slope_source, self._slope_target = self._kept([s.gradient for s in scatters], unknowns)
        self._size = sum(s.band.size for s in scatters)
        self._slope_size = sum(s.gradient.size for s in scatters)

    @staticmethod
    def _kept(targets: list[Indices], nowhere: int) -> tuple[Indices, Indices]:
        flat = np.concatenate([np.zeros(0, dtype=np.int64), *(t.ravel() for t in targets)])
        source = np.flatnonzero(flat != nowhere)
        return source, flat[source]

    def add(self, z: Array, pull: Array, weight: float, sums: Sums) -> None:
        """Jᵀ · pull and weight · JᵀJ of all rows."""
        squares, slopes = np.empty(self._size), np.empty(self._slope_size)
        at = start = slope_start = 0
        for group in self.groups:
            jacobian, _ = group.jacobians(z, ALL)
            count, rows, width = jacobian.shape
            end, slope_end = start + count * width * width, slope_start + count * width
            square = squares[start:end].reshape(count, width, width)
            np.matmul(jacobian.transpose(0, 2, 1), weight * jacobian, out=square)
            slope = slopes[slope_start:slope_end].reshape(count, 1, width)
            np.matmul(pull[at : at + count * rows].reshape(count, 1, rows), jacobian, out=slope)
            at, start, slope_start = at + count * rows, end, slope_end
        sums.add(self._target, squares[self._source])
        sums.pull(self._slope_target, slopes[self._slope_source])
