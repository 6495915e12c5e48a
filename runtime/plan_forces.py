"""What a plan file tells of forces. `docs/plan-format.md` explains it."""

from __future__ import annotations

import msgspec


class ForceRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A part of what is told of forces; as of `plan.Record`, a field that it does not have is refused."""


class WeightRecord(ForceRecord, frozen=True):
    """What weighs in one rigid part, of a module the moving frame of joint `joint` (-1: the module frame) and of a body
    the body (-1): kilograms, the centre there, and the inertia about it along the axes there: xx, xy, xz, yy, yz, zz,
    kg m²."""

    name: str
    joint: int
    mass: float
    centre: list[float]
    inertia: list[float]


class DriveRecord(ForceRecord, frozen=True):
    """How strong a joint is: the `torque` of its drive and the moment `bearing` across its axis, N m (N), the inertia
    `rotor` of its drive, kg m², and what its `brake` bears while it does not move, N m (N)."""

    module: str
    joint: str
    torque: float
    bearing: float
    rotor: float
    brake: float = 0.0


class HoldRecord(ForceRecord, frozen=True):
    """How an effector or a body holds in a `manner`: the force along the normal, the `shear` across it, N, the bending
    `moment` and the `twist` about the normal, N m, and the coefficient of friction."""

    name: str
    manner: str
    force: float
    shear: float
    moment: float
    twist: float
    friction: float


class TorqueRecord(ForceRecord, frozen=True):
    """What the drives of a module give in a phase, N m (N): one row per time, in the order of its joints, at
    equidistant times from the start of the phase to its end."""

    module: str
    phase: int
    values: list[list[float]]


class WrenchRecord(ForceRecord, frozen=True):
    """What the first of two things that are kept together puts on the second in a phase: rows of force, N, and moment,
    N m, about the point where they meet, along the axes there, of which the third is the normal. They are those of the
    effector or body `at`, but upright of what stands (`pad`, `rest`), which tips `radius` metres from that point. Times
    are as of torques; a single row holds all along."""

    between: list[str]
    manner: str
    at: str
    radius: float
    phase: int
    values: list[list[float]]


class StaticsRecord(ForceRecord, frozen=True):
    """Weights, strengths, the torques of feed-forward, and what pairs bear; loads times `safety` keep the strengths.
    What holds after the last switch is told as of one phase more."""

    weights: list[WeightRecord]
    drives: list[DriveRecord]
    torques: list[TorqueRecord]
    holds: list[HoldRecord] = []
    wrenches: list[WrenchRecord] = []
    safety: float = 1.0
