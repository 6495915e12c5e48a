"""The cubic splines of plan files, from the slopes at their knots."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from .geometry import Array

EVEN = 1e-9
"""Relative differences of steps that do not count."""


class Spline:
    """The cubic spline through `values` `(n + 1, k)` at increasing `knots` `(n + 1,)`, n >= 1: with no slope at the
    ends when `clamped`, else with the first two pieces, and the last two, parts of one cubic. A call gives its values,
    or a derivative, `(T, k)` at `times` `(T,)`.

    `cubic` and `square` `(n, k)` are the leading coefficients of each piece, by the time since its knot. The same
    curves as SciPy's `CubicSpline`. Raises ValueError where knots do not increase or a number is not finite."""

    def __init__(self, knots: ArrayLike, values: ArrayLike, clamped: bool) -> None:
        self.knots: Array = np.asarray(knots, dtype=float)
        rows = np.asarray(values, dtype=float)
        steps = np.diff(self.knots)
        if len(steps) < 1 or not (steps > 0).all() or not np.isfinite(rows).all():
            raise ValueError("a spline needs finite values at increasing knots")
        secants = np.diff(rows, axis=0) / steps[:, None]
        slopes = _slopes(steps, secants, clamped)
        bend = (slopes[:-1] + slopes[1:] - 2.0 * secants) / steps[:, None]
        self.cubic: Array = bend / steps[:, None]
        self.square: Array = (secants - slopes[:-1]) / steps[:, None] - bend
        self._slopes, self._values = slopes[:-1], rows[:-1]

    def __call__(self, times: ArrayLike, derivative: int = 0) -> Array:
        at = np.asarray(times, dtype=float)
        piece = np.clip(np.searchsorted(self.knots, at, side="right") - 1, 0, len(self.knots) - 2)
        t = (at - self.knots[piece])[:, None]
        cubic, square, slope = self.cubic[piece], self.square[piece], self._slopes[piece]
        if derivative == 0:
            result = self._values[piece] + t * (slope + t * (square + t * cubic))
        elif derivative == 1:
            result = slope + t * (2.0 * square + 3.0 * t * cubic)
        else:
            result = 2.0 * square + 6.0 * t * cubic
        return np.asarray(result)


def _slopes(steps: Array, secants: Array, clamped: bool) -> Array:
    """Slopes `(n + 1, k)` at the knots, from the lengths `(n,)` of the pieces and their secants `(n, k)`."""
    if np.ptp(steps) <= EVEN * steps[0]:
        return _even(len(steps), clamped) @ secants
    left, right = _system(steps, clamped)
    return np.asarray(np.linalg.solve(left, right @ secants))


@lru_cache(maxsize=64)
def _even(count: int, clamped: bool) -> Array:
    """The matrix `(n + 1, n)` from secants to slopes where all pieces are equally long."""
    return np.asarray(np.linalg.solve(*_system(np.ones(count), clamped)))


def _system(steps: Array, clamped: bool) -> tuple[Array, Array]:
    """Matrices `(n + 1, n + 1)` and `(n + 1, n)`: the first times the slopes equals the second times the secants. The
    second derivatives agree at each inner knot."""
    count = len(steps)
    left, right = np.eye(count + 1), np.zeros((count + 1, count))
    for i in range(1, count):
        before, after = steps[i - 1], steps[i]
        left[i, i - 1 : i + 2] = after, 2.0 * (before + after), before
        right[i, i - 1 : i + 1] = 3.0 * after, 3.0 * before
    if not clamped:
        _free_end(left[0], right[0], steps)
        _free_end(left[-1, ::-1], right[-1, ::-1], steps[::-1])
    return left, right


def _free_end(left: Array, right: Array, steps: Array) -> None:
    """Fill the first equation where the end is free: the third derivatives agree at the second knot. Of two pieces one
    parabola is made, of one a line."""
    if len(steps) == 1:
        right[0] = 1.0
        return
    first, both = steps[0], steps[0] + steps[1]
    left[1] = 1.0 if len(steps) == 2 else both / steps[1]
    if len(steps) == 2:
        right[0] = 2.0
    else:
        right[:2] = (first + 2.0 * both) / both, first**2 / (both * steps[1])
