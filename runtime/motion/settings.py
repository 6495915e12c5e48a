"""The numbers that steer the motion programs, in one place. SI units."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """`slices` per phase on a path; `margin` between surfaces along a path and `switch_margin` at switches, metres;
    `limit_margin` pulls joint limits in at switches, radians; `tolerance` is the largest violation of a single row
    that still counts as feasible (metres or radians). With `polish`, motions become cheaper once they are feasible."""

    slices: int = 20
    margin: float = 0.02
    switch_margin: float = 0.025
    limit_margin: float = 0.03
    tolerance: float = 2e-3
    solver: str = "algn"
    collisions: bool = True
    polish: bool = True
