"""The limits that a plan must keep: one table. Metres, radians, ratios."""

from __future__ import annotations

LIMITS: dict[str, float] = {
    "position_m": 2e-3,
    "gap_m": 2e-3,
    "orientation_rad": 5e-3,
    "residual": 2e-3,
    "during_m": 2e-3,
    "during": 5e-3,
    "slip_m": 1e-3,
    "slip_rad": 2e-3,
    "penetration_m": 1e-3,
    "joint_limit_rad": 1e-3,
    "joint_limit_m": 1e-3,
    "joint_speed_ratio": 1.05,
    "start_m": 1e-6,
    "start_rad": 1e-6,
    "jump_m": 1e-5,
    "jump_rad": 1e-5,
    "spline_rad": 1e-6,
    "rest_m": 1e-6,
    "rest_rad": 1e-6,
    "quaternion": 1e-6,
    "time_s": 1e-9,
}
"""position, gap, orientation, residual: rows of motion predicates at switches, by the unit of the row; during: the
same while a literal holds. slip: change of what a `keep` row holds constant. penetration: overlap of two shapes.
joint_speed_ratio: speed over the joint's own limit. start: first sample against the scene. jump: between the two
samples at a switch. spline: stored joints against the stored splines. rest: motion of what nothing carries."""

UNITS = {"m": "m", "rad": "rad", "s": "s", "ratio": "ratio"}


def unit_of(kind: str) -> str:
    """The unit that the name of a measure ends with; "" for a plain number."""
    return UNITS.get(kind.rpartition("_")[2], "")
