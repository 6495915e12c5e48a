"""Looking closer: instants of a phase are added until a limit is kept, or broken, for certain."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...langs.frozen import dataclass
from .bounds import Bounds
from .findings import Findings
from .geometry import Array, Frames, angles
from .sampler import Grid, Sampler

DEEPEST = 18
"""How often a stretch is halved at most. From some 10 ms that leads to a tenth of a microsecond, in which what moves at
10 m/s moves by a thousandth of the limit of 1 mm: what is not known then is too close to its limit to be told."""
MOST = 20_000
"""Stretches that are looked into at the same time, at most."""
ROUNDING = 1e-9
"""Metres or radians by which a figure may seem to be over its limit by rounding alone: nothing is halved for it."""


@dataclass(frozen=True, slots=True)
class Look:
    """A figure at the instants of a grid `(T,)`, what it may reach at most in each stretch between them `(T - 1,)`, and
    its limit."""

    amounts: Array
    highest: Array
    limit: float


def settle(grid: Grid, look: Callable[[Grid], Look], findings: Findings) -> tuple[float, float] | None:
    """The greatest amount that was seen, and when; None where it could not be found out whether it stays within its
    limit. Raises OutOfTime."""
    worst, time = -np.inf, float(grid.times[0])
    for part in grid.parts():
        current = part
        for _ in range(DEEPEST + 1):
            findings.check_time()
            seen = look(current)
            at = int(np.argmax(seen.amounts))
            if seen.amounts[at] > worst:
                worst, time = float(seen.amounts[at]), float(current.times[at])
            if worst > seen.limit:
                return worst, time
            open_stretches = np.flatnonzero(current.joined & ~(seen.highest <= seen.limit + ROUNDING))
            if not len(open_stretches):
                break
            if len(open_stretches) > MOST:
                return None
            current = current.halved(open_stretches)
        else:
            return None
    return worst, time


class Slip:
    """How far a frame has left the pose relative to another one in which it is kept, where this follows from the joints
    of closed loops only."""

    def __init__(
        self, sampler: Sampler, phase: int, own: str, base: str, begin: Frames,
        limits: tuple[float, float],
    ) -> None:  # fmt: skip
        """`limits` are those of how far and how much, metres and radians."""
        self._limits = limits
        self._sampler, self._phase, self._begin = sampler, phase, begin
        self._own, self._base = own, base

    def shift(self, grid: Grid) -> Look:
        """Metres. Along a straight line the distance from a point is greatest at an end."""
        relative, (_, acceleration), bounds = self._relative(grid)
        off = np.linalg.norm(relative.position - self._begin.position, axis=1)
        return Look(off, np.maximum(off[1:], off[:-1]) + bounds.strayed(acceleration), self._limits[0])

    def turn(self, grid: Grid) -> Look:
        """Radians. What a rotation matrix strays from the straight line between two is at most the square root of 2
        times what a point at distance 1 does, in the Frobenius norm, which is convex and tells the angle."""
        relative, (acceleration, _), bounds = self._relative(grid)
        off = np.linalg.norm(relative.rotation - self._begin.rotation, axis=(1, 2))
        highest = np.maximum(off[1:], off[:-1]) + np.sqrt(2.0) * bounds.strayed(acceleration)
        most = 2.0 * np.arcsin(np.clip(highest / (2.0 * np.sqrt(2.0)), 0.0, 1.0))
        return Look(angles(relative.rotation, self._begin.rotation), most, self._limits[1])

    def _relative(self, grid: Grid) -> tuple[Frames, tuple[Array, Array], Bounds]:
        """The relative poses, and bounds of the acceleration of a point at distance 1, by turning alone, and of the
        frame's origin."""
        placement = self._sampler.at(self._phase, grid.times)
        bounds = Bounds(self._sampler, self._phase, grid, placement)
        count = len(grid.times)
        own, base = (placement.frame(n).spread(count) for n in (self._own, self._base))
        apart = np.linalg.norm(own.position - base.position, axis=1)
        seat, point = (self._sampler.mount(name) for name in (self._base, self._own))
        _, seen = bounds.relative(seat[:2], _offset(seat[2]), point[:2], _offset(point[2]), apart)
        return own.relative_to(base), (seen.turning + seen.turn**2, seen.acceleration), bounds


def _offset(placement: Frames | None) -> float:
    return 0.0 if placement is None else float(np.linalg.norm(placement.position[0]))
