"""The limits that a plan must keep: one table. Metres, radians, ratios."""

from __future__ import annotations

import math

from ...compiler import ir
from .shapes import bounding_radius

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
    "coupling_rad": 1e-6,
    "coupling_m": 1e-6,
    "undriven_rad": 1e-6,
    "undriven_m": 1e-6,
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
    "torque_ratio": 1.0,
    "bearing_ratio": 1.0,
    "dock_ratio": 1.0,
    "foot_ratio": 1.0,
    "tip_m": 1e-4,
    "load_share": 1e-2,
    "quaternion": 1e-6,
    "time_s": 1e-9,
}
"""What each is about, and why it is what it is. Most plans stay below a hundredth of each; the worst figures known of
good plans are given where they come near.

- position_m, gap_m: rows of motion predicates at switches, in metres. An end of 5 cm radius forgives a twenty-fifth of
  it; plans that follow sensed, moving bodies are 0.5 mm off.
- orientation_rad, residual: the same, of axes and of plain numbers. On a lever of 0.4 m as much as position_m.
- during_m, during: rows that hold all the time. As at switches.
- slip_m, slip_rad: change of what a `keep` row holds constant, where closed loops leave that to joints. Half of
  position_m, for it comes on top of it; robots on several feet slip by 0.04 mm between planned instants.
- penetration_m: overlap of two shapes. Half of gap_m: what is meant to touch may overlap by as much as it may gape, and
  keeps a half for what goes by; planners, which look at instants, leave 0.25 mm.
- joint_limit_rad, joint_limit_m: joint values beyond their limits. On a lever of 1 m as much as penetration_m.
- coupling_rad, coupling_m: joints against what those that they follow make of them. Rounding to 10 decimals, times the
  factor.
- undriven_rad, undriven_m: how far joints without drives move in a phase in which nothing drives them. Rounding.
- start_m, start_rad: the first sample against the scene. Rounding to 10 decimals on the way there.
- jump_m, jump_rad: between the two samples at a switch. A hundredth of slip_m: a hundred switches slip no more.
- spline_rad (radians or metres), sample_m, sample_rad: samples against the motion that they draw. Rounding to 10
  decimals on levers of some metres: 1e-9. A thousandth of what the motion itself may be off by.
- switch_rad_s (or m/s): rates of bound modules at switches within a spline. Rounding of values, over knots 1 ms apart.
- rest_m, rest_rad, course_m, course_rad, stuck_rad: samples of what rests, of bodies on their courses, of stuck joints.
  As those of samples.
- torque_ratio, bearing_ratio, dock_ratio, foot_ratio: load times the task's `safety` over strength, where the task asks
  for physics. What is stated is meant as it is; planners keep a hundredth of it.
- tip_m: how far a load leans out over the edge of what only rests. Rounding of samples, on levers of some metres.
- load_share: by which share of their bound rows about loads are missed; they are looked at, not bounded, between
  instants. Planners look at slices, between which loads are up to 0.8 % greater.
- quaternion: lengths less 1. Rounding; quaternions are normalised before they are used.
- time_s: times of phases against those of their samples. Rounding to 10 decimals."""

SHAPED = ("position_m", "gap_m", "during_m", "slip_m", "penetration_m", "joint_limit_m")
"""Limits that are meant for shapes of robots of about a metre. Where all robots of a scene come out less than `SMALL`
without what they slide, a robot of the size of a limit could go through anything: there they shrink as it does."""
SMALL = 0.1
"""Metres."""
SLIDING = 0.1
"""But no further than to this share of how far such robots come with what they slide: figures have errors of their own,
which grow with ways."""


def share_of(world: ir.World) -> float:
    """What is left of the limits of shapes in a scene: 1, or how far, in metres, the largest of small robots comes
    from its frame: along links and joints to the farthest point of a shape, with a share of what slides."""
    types = [module.type for module in world.modules.values()]
    reach, shaped = (max((_comes(kind, slides) for kind in types), default=0.0) for slides in (True, False))
    small = min(reach, max(shaped, SLIDING * reach))
    return small if 0.0 < small < SMALL and shaped < SMALL else 1.0


def _comes(kind: ir.ModuleType, slides: bool) -> float:
    """How far from its frame a module comes at most, in metres; without `slides` up to the ends of its shapes."""
    ways: list[float] = []
    for moved in kind.joints:
        slide = max(-moved.lower, moved.upper, 0.0) if slides and moved.kind == ir.JointKind.PRISMATIC else 0.0
        before = ways[moved.parent] if moved.parent >= 0 else 0.0
        ways.append(before + math.dist(moved.placement[:3], (0.0, 0.0, 0.0)) + slide)
    parts = [(e.joint, e.placement, e.shape) for e in kind.effectors]
    parts += [(link.joint, link.placement, link.shape) for link in kind.links]
    found = [0.0]
    for joint, place, shape in parts:
        before = ways[joint] if joint >= 0 else 0.0
        solids = () if slides or shape is None else shape.solids
        ends = [math.hypot(*s.placement[:3]) + bounding_radius(s.shape.kind, s.shape.size) for s in solids]
        found.append(before + math.dist(place[:3], (0.0, 0.0, 0.0)) + max(ends, default=0.0))
    return max(found)


RATES = ("joint_speed_rad_s", "joint_speed_m_s", "joint_acceleration_rad_s2", "joint_acceleration_m_s2",
         "joint_jerk_rad_s3", "joint_jerk_m_s3")  # fmt: skip
"""Figures whose limit is that of the joint; the worst is the one that comes closest to it, or is farthest above."""
RATE_SLACK = 1.001
"""By what factor a rate may be above its limit: stored figures are rounded."""
UNITS = {"_rad_s3": "rad/s³", "_m_s3": "m/s³",
         "_rad_s2": "rad/s²", "_m_s2": "m/s²", "_rad_s": "rad/s", "_m_s": "m/s", "_m": "m", "_rad": "rad",
         "_s": "s"}  # fmt: skip


def unit_of(kind: str) -> str:
    """The unit that the name of a measure ends with; "" for a plain number."""
    return next((unit for end, unit in UNITS.items() if kind.endswith(end)), "")
