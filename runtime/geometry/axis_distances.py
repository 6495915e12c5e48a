"""Distances of round shapes to each other and to boxes: closed forms on their axes, as stage Functions.

In batches of some ten pairs, as motion programs ask for them, a Function takes a tenth of what array operations take.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from ...compiler.motion.stages import Stage
from ..skeleton import Array

TINY = 1e-12
MOST = 256
"""Pairs of one call: larger batches keep more memory and are no faster."""
COLUMNS = (slice(1, 4), slice(4, 7), slice(7, 10))
"""Of a result: the normal towards the first shape, the nearest points of the first and of the second. Before them
stands the distance, behind them that of an axis from a box."""


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _between(value: Any, least: Any, most: Any) -> Any:
    return ca.fmin(ca.fmax(value, least), most)


@cache
def round_stage() -> Stage:
    """Of two round shapes: centre and half axis of each `(12,)`, the sum of their radii `(1,)`; `(10,)`. Ericson,
    Real-Time Collision Detection, section 5.1.9."""
    given, radii = ca.SX.sym("x", 12), ca.SX.sym("p", 1)
    first, second = 2.0 * given[3:6], 2.0 * given[9:12]
    start, other = given[:3] - given[3:6], given[6:9] - given[9:12]
    way = start - other
    uu, vv, uv = _dot(first, first), _dot(second, second), _dot(first, second)
    uw, vw = _dot(first, way), _dot(second, way)
    across = uu * vv - uv * uv
    skew = across > TINY * uu * vv + TINY
    s = _between(ca.if_else(skew, (uv * vw - uw * vv) / ca.fmax(across, TINY), 0.5), 0.0, 1.0)
    free = ca.if_else(vv > TINY, (uv * s + vw) / ca.fmax(vv, TINY), 0.0)
    t = _between(free, 0.0, 1.0)
    ends = ca.logic_or(ca.logic_or(free < 0.0, free > 1.0), vv <= TINY)
    s = ca.if_else(ends, _between((uv * t - uw) / ca.fmax(uu, TINY), 0.0, 1.0), s)
    p, q = start + s * first, other + t * second
    apart = p - q
    length = ca.sqrt(_dot(apart, apart))
    normal = ca.if_else(length > TINY, apart / ca.fmax(length, TINY), ca.DM([0.0, 0.0, 1.0]))
    return Stage("rounds", given, radii, ca.vertcat(length - radii, normal, p, q))


@cache
def box_stage() -> Stage:
    """Of a round shape and a box: centre and half axis, centre and rotation by rows `(18,)`, half the sides of the box
    and the radius `(4,)`; `(11,)`. The slope of half the squared distance along the axis is piecewise linear and grows:
    it is zero between two of the places where the axis passes a plane of the box; where it is so all the way between
    two, the middle is taken. Where the axis goes through the box there is no normal."""
    given, sizes = ca.SX.sym("x", 18), ca.SX.sym("p", 4)
    rotation, half = ca.reshape(given[9:18], 3, 3).T, sizes[:3]
    start = rotation.T @ (given[:3] - given[3:6] - given[6:9])
    way = 2.0 * (rotation.T @ given[3:6])

    def slope(share: Any) -> Any:
        point = start + share * way
        return _dot(point - _between(point, -half, half), way)

    safe = ca.if_else(ca.fabs(way) > TINY, way, TINY)
    passes = [_between(plane[i] / safe[i], 0.0, 1.0) for plane in (half - start, -half - start) for i in range(3)]
    looks = [(share, slope(share)) for share in (*passes, ca.SX(0.0), ca.SX(1.0))]

    def crossing(level: Any) -> Any:
        low, high = ca.SX(0.0), ca.SX(1.0)
        for share, grown in looks:
            below = grown < level
            low, high = ca.fmax(low, below * share), ca.fmin(high, below + share)
        least = slope(low)
        rise = slope(high) - least
        return low + _between(ca.if_else(rise > 0.0, (level - least) / rise, 0.0), 0.0, 1.0) * (high - low)

    level = 1e-10 * _dot(way, way)
    point = start + 0.5 * (crossing(-level) + crossing(level)) * way
    nearest = _between(point, -half, half)
    apart = point - nearest
    length = ca.sqrt(_dot(apart, apart))
    ends = (given[6:9] + rotation @ at for at in (point, nearest))
    normal = rotation @ (apart / ca.fmax(length, TINY))
    return Stage("boxes", given, sizes, ca.vertcat(length - sizes[3], normal, *ends, length))


def evaluated(stage: Stage, given: Array, sizes: Array) -> Array:
    """The results `(N, rows)` of N pairs."""
    if len(given) <= MOST:
        return stage.values(given, sizes)
    parts = [slice(at, at + MOST) for at in range(0, len(given), MOST)]
    return np.concatenate([stage.values(given[part], sizes[part]) for part in parts])
