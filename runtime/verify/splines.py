"""The cubic splines of plan files, from the slopes at their knots."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from .geometry import Array, Indices

EVEN = 1e-9
"""Relative differences of steps that do not count."""
LARGEST = 256
"""Pieces of a spline whose matrix is kept: half a megabyte."""


class Spline:
    """The cubic spline through `values` `(n + 1, k)` at increasing `knots` `(n + 1,)`, n >= 1, with no slope at the
    ends. A call gives its values, or a derivative, `(T, k)` at `times` `(T,)`.

    `cubic` and `square` `(n, k)` are the leading coefficients of each piece, by the time since its knot. The same
    curves as SciPy's clamped `CubicSpline`. Raises ValueError where knots do not increase or a number is not finite."""

    def __init__(self, knots: ArrayLike, values: ArrayLike) -> None:
        self.knots: Array = np.asarray(knots, dtype=float)
        rows = np.asarray(values, dtype=float)
        steps = np.diff(self.knots)
        if len(steps) < 1 or not (steps > 0).all() or not np.isfinite(rows).all():
            raise ValueError("a spline needs finite values at increasing knots")
        secants = np.diff(rows, axis=0) / steps[:, None]
        slopes = _slopes(steps, secants)
        bend = (slopes[:-1] + slopes[1:] - 2.0 * secants) / steps[:, None]
        self.cubic: Array = bend / steps[:, None]
        self.square: Array = (secants - slopes[:-1]) / steps[:, None] - bend
        self._slopes, self._values = slopes[:-1], rows[:-1]
        self.constant = bool((rows == rows[0]).all())

    def __call__(self, times: ArrayLike, derivative: int = 0) -> Array:
        at = np.asarray(times, dtype=float)
        piece = self.piece(at)
        t = (at - self.knots[piece])[:, None]
        cubic, square, slope = self.cubic[piece], self.square[piece], self._slopes[piece]
        if derivative == 0:
            result = self._values[piece] + t * (slope + t * (square + t * cubic))
        elif derivative == 1:
            result = slope + t * (2.0 * square + 3.0 * t * cubic)
        else:
            result = 2.0 * square + 6.0 * t * cubic
        return np.asarray(result)

    def piece(self, times: Array) -> Indices:
        """The pieces that times `(T,)` lie in."""
        return np.clip(np.searchsorted(self.knots, times, side="right") - 1, 0, len(self.knots) - 2)

    def extrema(self) -> tuple[Array, Array]:
        """Values `(T, k)` at the times `(T, k)` of all knots, and of the turning points between them, of each column
        (elsewhere a knot stands in their place): its greatest and its least value are among them."""
        steps = np.diff(self.knots)[:, None]
        root = np.sqrt(np.maximum(self.square**2 - 3.0 * self.cubic * self._slopes, 0.0))
        half = -(self.square + np.where(self.square < 0.0, -root, root))
        with np.errstate(divide="ignore", invalid="ignore"):
            turns = [half / (3.0 * self.cubic), self._slopes / half]
        times, values = [np.repeat(self.knots[:, None], self._values.shape[1], axis=1)], [self(self.knots)]
        for turn in turns:
            t = np.where((turn > 0.0) & (turn < steps), turn, 0.0)
            times.append(self.knots[:-1, None] + t)
            values.append(self._values + t * (self._slopes + t * (self.square + t * self.cubic)))
        return np.vstack(times), np.vstack(values)


def _slopes(steps: Array, secants: Array) -> Array:
    """Slopes `(n + 1, k)` at the knots, from the lengths `(n,)` of the pieces and their secants `(n, k)`."""
    if np.ptp(steps) <= EVEN * steps[0] and len(steps) <= LARGEST:
        return _even(len(steps)) @ secants
    return _solved(steps, secants)


@lru_cache(maxsize=64)
def _even(count: int) -> Array:
    """The matrix `(n + 1, n)` from secants to slopes where all pieces are equally long."""
    return _solved(np.ones(count), np.eye(count))


def _solved(steps: Array, secants: Array) -> Array:
    """The slopes for which the second derivatives agree at each inner knot, and which are zero at both ends: a
    tridiagonal system, solved by elimination from the first row to the last and back (its diagonal dominates)."""
    slopes = np.zeros((len(steps) + 1, secants.shape[1]))
    above = np.zeros(len(steps) + 1)
    for i in range(1, len(steps)):
        before, after = float(steps[i - 1]), float(steps[i])
        pivot = 2.0 * (before + after) - after * above[i - 1]
        above[i] = before / pivot
        right = 3.0 * (after * secants[i - 1] + before * secants[i])
        slopes[i] = (right - after * slopes[i - 1]) / pivot
    for i in range(len(steps) - 1, 0, -1):
        slopes[i] -= above[i] * slopes[i + 1]
    return slopes
