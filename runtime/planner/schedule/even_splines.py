"""Clamped cubic splines through values at even times, of many knots: their banded systems are solved as such."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from ...skeleton import Array
from ..motion.nlp.banded_cholesky import factored, solved


@lru_cache(maxsize=64)
def _factor(count: int, ends: float) -> Any:
    """The factor of the matrix `(count, count)` with 4, at the ends `ends`, on its diagonal and 1 beside it."""
    band = np.ones((count, 2))
    band[:, 0] = 4.0
    band[[0, -1], 0] = ends
    return factored(np.ascontiguousarray(band))


def bends(values: Array) -> Array:
    """Second derivatives `(n + 1, k)` at the knots of the spline through `values` `(n + 1, k)`, n >= 1, by the time in
    knots, that has no slope at its ends."""
    slopes = np.diff(values, axis=0)
    rest = np.zeros((1, values.shape[1]))
    right = 6.0 * np.diff(np.concatenate([rest, slopes, rest]), axis=0)
    return np.asarray(solved(_factor(len(values), 2.0), right))


def natural_bends(values: Array) -> Array:
    """The same of the spline that has no second derivative at its ends, n >= 2."""
    result = np.zeros_like(values)
    right = 6.0 * (values[2:] - 2.0 * values[1:-1] + values[:-2])
    result[1:-1] = solved(_factor(len(right), 4.0), right)
    return result


def slopes_at_knots(values: Array, bent: Array) -> Array:
    """First derivatives `(n + 1, k)` at the knots, from their second derivatives."""
    secants = np.diff(values, axis=0)
    first = secants - (2.0 * bent[:-1] + bent[1:]) / 6.0
    last = secants[-1:] + (bent[-2:-1] + 2.0 * bent[-1:]) / 6.0
    return np.concatenate([first, last])


def at_rest(values: Array) -> Array:
    """Values whose spline has no second derivative at its ends, n >= 4: the second and the last but one are moved."""
    last = len(values) - 1
    both = np.zeros((last + 1, 2))
    both[1, 0] = both[last - 1, 1] = 1.0
    response, missed = bends(both)[[0, last]], bends(values)[[0, last]]
    moved = values.copy()
    moved[[1, last - 1]] -= np.linalg.solve(response, missed)
    return moved


def greatest_rates(values: Array) -> tuple[Array, Array, Array]:
    """Greatest absolute first, second and third derivatives `(k,)`, by the time in knots: accelerations are greatest at
    knots, speeds there or where the acceleration is zero, jerk is constant between."""
    bent = bends(values)
    left, right = bent[:-1], bent[1:]
    first = np.diff(values, axis=0) - (2.0 * left + right) / 6.0
    change = right - left
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.clip(np.nan_to_num(-left / change), 0.0, 1.0)
    speeds = [np.abs(first + u * left + 0.5 * u * u * change).max(axis=0) for u in (0.0, 1.0, turn)]
    return np.max(speeds, axis=0), np.abs(bent).max(axis=0), np.abs(change).max(axis=0)


def between_knots(values: Array, looks: int) -> Array:
    """The spline through values `(n + 1, k)` at `looks` even instants per knot, `(looks n + 1, k)`."""
    bent = bends(values)
    slopes = slopes_at_knots(values, bent)[:-1]
    since = (np.arange(looks) / looks)[None, :, None]
    rows = values[:-1, None] + since * (
        slopes[:, None] + since * (bent[:-1, None] / 2.0 + since * np.diff(bent, axis=0)[:, None] / 6.0)
    )
    return np.concatenate([rows.reshape(-1, values.shape[1]), values[-1:]])
