"""The fastest way through a given curve under limits of speed and acceleration, by reachability (Pham and Pham 2018).

Along the curve q(s), s from 0 to 1, let x be the square of the rate of s and u half the slope of x, the second
derivative of s. Rates of joints are q' √x, accelerations q' u + q'' x, both linear in (u, x) but for the root: from the
end back, the greatest x is found from which rest can still be reached, and then, from the start, u is chosen as large
as these allow.
"""

from __future__ import annotations

import numpy as np

from ....langs.frozen import dataclass
from ...skeleton import Array

EPSILON = 1e-9
"""Of coefficients: less is nothing."""


@dataclass(frozen=True, slots=True)
class TimeLaw:
    """Where on the curve one is when: at `times` `(N + 1,)` seconds at the evenly spaced shares 0 … 1, with `rates`
    `(N + 1,)` that are linear in time between."""

    times: Array
    rates: Array

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    def smoothed(self, ramp: float, count: int) -> Array:
        """Shares `(count + 1,)` at even times over the duration and `ramp` seconds more, averaged over `ramp` seconds:
        so accelerations are zero at both ends, and change no faster than by their spread in that time."""
        at = np.linspace(0.0, self.duration + ramp, count + 1)
        shares = (self._integral(at) - self._integral(at - ramp)) / ramp
        shares[0], shares[-1] = 0.0, 1.0
        return np.clip(shares, 0.0, 1.0)

    def _integral(self, at: Array) -> Array:
        """The integral of the share from the start to times `(T,)`; the share is 0 before the start, 1 behind the
        end."""
        places = np.linspace(0.0, 1.0, len(self.times))
        steps = np.diff(self.times)
        slopes = np.diff(self.rates) / steps
        pieces = places[:-1] * steps + self.rates[:-1] * steps**2 / 2.0 + slopes * steps**3 / 6.0
        sums = np.concatenate([[0.0], np.cumsum(pieces)])
        inside = np.clip(at, 0.0, self.duration)
        k = np.clip(np.searchsorted(self.times, inside, side="right") - 1, 0, len(steps) - 1)
        since = inside - self.times[k]
        found = sums[k] + since * (places[k] + since * (self.rates[k] / 2.0 + since * slopes[k] / 6.0))
        return np.asarray(found + np.maximum(at - self.duration, 0.0))


def fastest(first: Array, second: Array, speed: Array, acceleration: Array) -> TimeLaw | None:
    """The fastest law through a curve of derivatives `first` and `second` `(N + 1, n)` by its share, from rest to rest;
    `speed` and `acceleration` `(N + 1, n)` are the limits there. None where rounding leaves none."""
    count = len(first) - 1
    step = 1.0 / count
    lines = _lines(first, second, acceleration, step)
    with np.errstate(divide="ignore"):
        caps = ((speed / np.maximum(np.abs(first), EPSILON)) ** 2).min(axis=1)
    caps[:-1] = _feasible(lines, caps[:-1])
    most = np.zeros(count + 1)
    for k in range(count - 1, -1, -1):
        most[k] = min(caps[k], _controllable(lines, k, most[k + 1], step))
    squares = np.zeros(count + 1)
    for k in range(count):
        gain = min(_upper(lines, k, squares[k]), (most[k + 1] - squares[k]) / (2.0 * step))
        squares[k + 1] = min(max(squares[k] + 2.0 * step * gain, 0.0), most[k + 1])
    rates = np.sqrt(squares)
    sums = rates[1:] + rates[:-1]
    if not (sums > EPSILON).all():
        return None
    return TimeLaw(np.concatenate([[0.0], np.cumsum(2.0 * step / sums)]), rates)


@dataclass(frozen=True, slots=True)
class _Lines:
    """Rows `c u + d x <= e` `(N, R)` of every stretch, as bounds of u: where c > 0 `e/c - (d/c) x` from above, where
    c < 0 from below. `start` and `slope` `(N, R)` are those of the bounds; `above`, `below` tell which they are."""

    above_start: Array
    above_slope: Array
    below_start: Array
    below_slope: Array
    flat: Array
    """The greatest x that rows without u allow `(N,)`."""


def _lines(first: Array, second: Array, limit: Array, step: float) -> _Lines:
    """The limits of acceleration at both ends of each stretch."""
    c = np.concatenate([first[:-1], first[1:] + 2.0 * step * second[1:]], axis=1)
    d = np.concatenate([second[:-1], second[1:]], axis=1)
    e = np.concatenate([limit[:-1], limit[1:]], axis=1)
    scale = np.maximum(np.abs(c).max(axis=1, keepdims=True), EPSILON)
    tilted = np.abs(c) > EPSILON * scale
    size = np.where(tilted, np.abs(c), 1.0)
    slope = np.where(tilted, np.sign(c) * d / size, 0.0)
    start = np.where(tilted, e / size, np.inf)
    with np.errstate(divide="ignore"):
        flat = np.where(tilted, np.inf, e / np.maximum(np.abs(d), EPSILON)).min(axis=1)
    return _Lines(start, -slope, -start, -slope, flat)


def _feasible(lines: _Lines, caps: Array) -> Array:
    """The greatest x `(N,)` up to `caps` for which some u keeps all rows: the lowest bound from above, less the highest
    from below, is a concave function of x, so that Newton's steps from the caps end at its root, at a pair of bounds
    each."""
    found = np.minimum(lines.flat, caps)
    every = np.arange(len(found))
    for _ in range(lines.above_start.shape[1]):
        above = (lines.above_start + lines.above_slope * found[:, None]).argmin(axis=1)
        below = (lines.below_start + lines.below_slope * found[:, None]).argmax(axis=1)
        room = lines.above_start[every, above] - lines.below_start[every, below]
        closing = lines.below_slope[every, below] - lines.above_slope[every, above]
        nearer = (closing > EPSILON) & (room < closing * found * (1.0 - EPSILON))
        if not nearer.any():
            break
        found = np.where(nearer, room / np.where(nearer, closing, 1.0), found)
    return found


def _controllable(lines: _Lines, k: int, following: float, step: float) -> float:
    """The greatest x from which one may come to `following` or less, and not below zero, at the end of stretch k."""
    closing = lines.below_slope[k] + 0.5 / step
    room = 0.5 * following / step - lines.below_start[k]
    bound = np.where(closing > EPSILON, room / np.where(closing > EPSILON, closing, 1.0), np.inf).min()
    falling = -lines.above_slope[k] - 0.5 / step
    other = np.where(falling > EPSILON, lines.above_start[k] / np.where(falling > EPSILON, falling, 1.0), np.inf).min()
    return max(0.0, min(float(bound), float(other)))


def _upper(lines: _Lines, k: int, square: float) -> float:
    return float((lines.above_start[k] + lines.above_slope[k] * square).min())
