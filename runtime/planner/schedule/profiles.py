"""Phases as short as the limits of their joints allow: the curve stays, the law of time is new."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ....compiler.ir import World
from ....langs.frozen import dataclass
from ...geometry.resampling import between
from ...geometry.splines import ClampedSpline
from ...skeleton import Array, PhasePath
from ..motion.settings import ACCEPTANCE
from .even_splines import at_rest, bends, greatest_rates, natural_bends, slopes_at_knots
from .settings import SCHEDULE
from .time_optimal import TimeLaw, fastest

STILL = 1e-9
"""Radians or metres: joints that move less rest."""


@dataclass(frozen=True, slots=True)
class _Limits:
    """Of the joints that move, `(n,)` each."""

    speed: Array
    acceleration: Array
    jerk: Array

    def excess(self, values: Array, duration: float) -> float:
        """By what factor too short a time is for a clamped spline through `values`; at most 1 where all is kept."""
        rates, changes, jerks = greatest_rates(values)
        step = duration / (len(values) - 1)
        by_rate = float((rates / self.speed).max()) / step
        by_change = math.sqrt(float((changes / self.acceleration).max())) / step
        by_jerk = float((jerks / self.jerk).max()) ** (1.0 / 3.0) / step
        return float(max(by_rate, by_change, by_jerk) / ACCEPTANCE.limit_share)


def retimed(world: World, path: PhasePath, tick: float) -> PhasePath:
    """The same curve with the fastest law of time, its knots `tick` seconds apart; as before, where that is no faster.
    Its accelerations are zero at both ends, and it lasts a whole number of ticks."""
    before = _on_ticks(path, _even_shares(path, tick), max(1, math.ceil(path.duration / tick - 1e-6)) * tick)
    moved = [(m, k) for m in sorted(path.modules) for k in range(path.modules[m].shape[1] - 7)
             if np.ptp(path.modules[m][:, 7 + k]) > STILL]  # fmt: skip
    if not moved or path.samples < 3:
        return before
    rows = np.stack([path.modules[m][:, 7 + k] for m, k in moved], axis=1)
    joints = [world.modules[m].type.joints[k] for m, k in moved]
    limits = _Limits(*(np.array([getattr(j, name) for j in joints]) for name in ("speed", "acceleration", "jerk")))
    made = _fastest_profile(rows, limits, tick, before.duration - 0.5 * tick)
    if made is None:
        return before if limits.excess(_joints_of(before, moved), before.duration) <= 1.0 else path_as_is(path, tick)
    return _on_ticks(path, *made)


def path_as_is(path: PhasePath, tick: float) -> PhasePath:
    """The curve by its own law, one tick longer for what other knots are off by."""
    return _on_ticks(path, _even_shares(path, tick, 1), (math.ceil(path.duration / tick - 1e-6) + 1) * tick)


def _even_shares(path: PhasePath, tick: float, more: int = 0) -> Array:
    return np.linspace(0.0, 1.0, max(1, math.ceil(path.duration / tick - 1e-6)) + more + 1)


def _joints_of(path: PhasePath, moved: list[tuple[str, int]]) -> Array:
    return np.stack([path.modules[m][:, 7 + k] for m, k in moved], axis=1)


def _on_ticks(path: PhasePath, shares: Array, duration: float) -> PhasePath:
    """A path sampled at shares of its own time."""
    even = np.linspace(0.0, 1.0, path.samples)
    modules = {}
    for name, rows in path.modules.items():
        joints = ClampedSpline(even, rows[:, 7:])(shares)
        joints[[0, -1]] = rows[[0, -1], 7:]
        joints = at_rest(joints) if len(shares) > 4 else joints
        modules[name] = np.hstack([between(even, rows[:, :7], shares), joints])
    bodies = {name: between(even, rows, shares) for name, rows in path.bodies.items()}
    return PhasePath(modules, bodies, duration)


# --- the law of time -----------------------------------------------------------------------------------------------


def _fastest_profile(rows: Array, limits: _Limits, tick: float, below: float) -> tuple[Array, float] | None:
    """Shares of the path's own time at ticks, and seconds `below` some: the shortest that keeps all limits with one of
    some ramps. Longer ramps help only where jerk is limited."""
    curve = _Curve(rows)
    found: tuple[Array, float] | None = None
    factor = 1.0
    while factor < 64.0:
        made = _profile(curve, limits, tick, factor, below)
        if made is not None and (found is None or made[1] < found[1]):
            found = made
        if not np.isfinite(limits.jerk).any() or (found is not None and made is not None and made[1] > found[1]):
            break
        factor *= 1.6
    return found


class _Curve:
    """The curve of a phase by its own length, in which speeds count as one."""

    def __init__(self, rows: Array) -> None:
        own = ClampedSpline(np.linspace(0.0, 1.0, len(rows)), rows)
        dense = np.linspace(0.0, 1.0, SCHEDULE.dense * (len(rows) - 1) + 1)
        self._own, self._dense = own, dense
        values = own(dense)
        steps = np.linalg.norm(np.diff(values, axis=0) / np.ptp(values, axis=0).max(), axis=1)
        self._length = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-12))])
        self._length /= self._length[-1]
        grid = np.linspace(0.0, 1.0, SCHEDULE.grid + 1)
        self.first, self.second = _derivatives(own(self.own_time(grid)), 1.0 / SCHEDULE.grid)

    def own_time(self, shares: Array) -> Array:
        """The path's own time, 0 to 1, at shares of its length."""
        return np.interp(shares, self._length, self._dense)

    def at(self, times: Array) -> Array:
        return self._own(times)


def _derivatives(values: Array, step: float) -> tuple[Array, Array]:
    """First and second derivatives at even points, of the natural cubic spline through values `(N + 1, n)`."""
    bent = natural_bends(values)
    return slopes_at_knots(values, bent) / step, bent / step**2


def _profile(
    curve: _Curve, limits: _Limits, tick: float, factor: float, below: float
) -> tuple[Array, float] | None:  # fmt: skip
    """With ramps `factor` times as long as they are at least. Where the stored spline passes a limit, that is lowered
    around there, a few times; what is left is slowed down as a whole."""
    ones = np.ones(len(curve.first))
    share = {"speed": ones.copy(), "acceleration": ones.copy()}
    best: tuple[Array, float] | None = None
    for _ in range(SCHEDULE.rounds):
        law = fastest(curve.first, curve.second, share["speed"][:, None] * limits.speed * ACCEPTANCE.limit_share,
                      share["acceleration"][:, None] * limits.acceleration * ACCEPTANCE.limit_share)  # fmt: skip
        if law is None:
            break
        ramp = max(2.0 * tick, min(SCHEDULE.ramp, SCHEDULE.ramp_share * law.duration)) * factor
        made, times, duration = _stored(curve, law, ramp, tick, 1.0)
        slow, total = made, duration
        for _ in range(SCHEDULE.slower):
            excess = limits.excess(slow, total)
            slower = max(total * excess, total + tick)
            if excess <= 1.0 or slower >= below:
                break
            stretch = slower / (law.duration + ramp)
            slow, times, total = _stored(curve, law, ramp, tick, stretch)
        if total < (below if best is None else best[1] - STILL) and limits.excess(slow, total) <= 1.0:
            best = times, total
        if best is not None and best[1] <= duration + tick + STILL:  # lower limits gain a tick at most
            break
        if not _lower(share, curve, law, ramp, made, duration, limits):
            break
    return best


def _stored(curve: _Curve, law: TimeLaw, ramp: float, tick: float, stretch: float) -> tuple[Array, Array, float]:
    """The values at ticks, the path's own times there, and the whole duration."""
    count = max(5, math.ceil((law.duration + ramp) * stretch / tick - 1e-6))
    times = curve.own_time(law.smoothed(ramp, count))
    return at_rest(curve.at(times)), times, count * tick


def _lower(
    share: Mapping[str, Array], curve: _Curve, law: TimeLaw, ramp: float, made: Array, duration: float,
    limits: _Limits,
) -> bool:  # fmt: skip
    """Lower the limits near knots at which a stored profile passes them; whether there are any."""
    bent, step = bends(made), duration / (len(made) - 1)
    at = law.smoothed(ramp, len(made) - 1)
    changed = False
    grid = np.linspace(0.0, 1.0, len(curve.first))
    for name, rate in (("speed", slopes_at_knots(made, bent) / step / limits.speed),
                       ("acceleration", bent / step**2 / limits.acceleration)):  # fmt: skip
        over = np.abs(rate).max(axis=1) / ACCEPTANCE.limit_share
        if over.max() <= 1.0:
            continue
        changed = True
        wide = np.maximum(over, np.maximum(np.append(over[1:], 0.0), np.append(0.0, over[:-1])))
        share[name][:] /= np.maximum(1.0, np.interp(grid, at, wide))
    return changed
