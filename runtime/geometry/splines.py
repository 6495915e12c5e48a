"""Clamped cubic splines: the curves through stored values that begin and end at rest.

They are those of `scipy.interpolate.CubicSpline(knots, values, bc_type="clamped")`, which takes longer to import than a
short task takes to solve.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..skeleton import Array


class ClampedSpline:
    """The cubic spline through `values` `(n + 1, …)` at increasing `knots` `(n + 1,)`, n >= 1, that has no slope at
    either end. A call gives `(T, …)`, its values or a derivative at `times` `(T,)`; the outer pieces go on beyond the
    ends."""

    def __init__(self, knots: ArrayLike, values: ArrayLike) -> None:
        self.knots: Array = np.asarray(knots, dtype=float)
        rows = np.asarray(values, dtype=float)
        self._shape = rows.shape[1:]
        rows = rows.reshape(len(rows), -1)
        steps = np.diff(self.knots)[:, None]
        slopes = np.diff(rows, axis=0) / steps
        bends = _second_derivatives(steps[:, 0], slopes)
        left, right = bends[:-1], bends[1:]
        first = slopes - steps * (2.0 * left + right) / 6.0
        self._terms = (rows[:-1], first, left / 2.0, (right - left) / (6.0 * steps))

    def __call__(self, times: ArrayLike, derivative: int = 0) -> Array:
        at = np.asarray(times, dtype=float)
        piece = np.clip(np.searchsorted(self.knots, at, side="right") - 1, 0, len(self.knots) - 2)
        since = (at - self.knots[piece])[..., None]
        terms = [term[piece] for term in self._terms]
        for _ in range(derivative):
            terms = [power * term for power, term in enumerate(terms)][1:]
        result: Array = np.zeros_like(terms[0]) if terms else np.zeros((*at.shape, self._terms[0].shape[1]))
        for term in reversed(terms):
            result = result * since + term
        return result.reshape(*at.shape, *self._shape)


def _second_derivatives(steps: Array, slopes: Array) -> Array:
    """Second derivatives (n + 1, k) at the knots, from the lengths (n,) of the pieces and their mean slopes (n, k)."""
    system = np.diag(2.0 * (np.append(steps, 0.0) + np.append(0.0, steps)))
    system += np.diag(steps, 1) + np.diag(steps, -1)
    rest = np.zeros((1, slopes.shape[1]))
    changes = np.diff(np.concatenate([rest, slopes, rest]), axis=0)
    return np.asarray(np.linalg.solve(system, 6.0 * changes))


def spline_weights(slices: int, times: Array) -> Array:
    """The matrix `(T, slices + 1)` from the values of a clamped spline at 0, 1 … `slices` to those at `times`."""
    return ClampedSpline(np.arange(slices + 1), np.eye(slices + 1))(times)
