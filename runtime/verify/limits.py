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
    "start_m": 1e-6,
    "start_rad": 1e-6,
    "jump_m": 1e-5,
    "jump_rad": 1e-5,
    "spline_rad": 1e-6,
    "sample_m": 1e-6,
    "sample_rad": 1e-6,
    "switch_rad_s": 1e-6,
    "rest_m": 1e-6,
    "rest_rad": 1e-6,
    "course_m": 1e-6,
    "course_rad": 1e-6,
    "stuck_rad": 1e-6,
    "quaternion": 1e-6,
    "time_s": 1e-9,
}
"""position, gap, orientation, residual: rows of motion predicates at switches, by the unit of the row; during: the
same while a literal holds. slip: change of what a `keep` row holds constant. penetration: overlap of two shapes.
start: first sample against the scene. jump: between the two
samples at a switch. spline: stored joints against the stored splines. rest: motion of what nothing carries.
course: bodies that move on their own against where their courses take them. stuck: joints of a locked module."""

RATES = ("joint_speed_rad_s", "joint_speed_m_s", "joint_acceleration_rad_s2", "joint_acceleration_m_s2")
"""Figures whose limit is that of the joint; the worst is the one that comes closest to it, or is farthest above."""
RATE_SLACK = 1.001
"""By what factor a rate may be above its limit: stored figures are rounded."""
UNITS = {"_rad_s2": "rad/s²", "_m_s2": "m/s²", "_rad_s": "rad/s", "_m_s": "m/s", "_m": "m", "_rad": "rad", "_s": "s"}


def unit_of(kind: str) -> str:
    """The unit that the name of a measure ends with; "" for a plain number."""
    return next((unit for end, unit in UNITS.items() if kind.endswith(end)), "")
