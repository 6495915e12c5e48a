"""Joints of a module from those of a URDF, with what its declaration says of them beside.

A planar joint becomes three, a floating one six; one whose limits leave it no way becomes none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...langs import syntax
from ...langs.frozen import dataclass
from .. import ir
from ..checks.context import Context
from ..checks.kinds import ANGLE, LENGTH, RATES
from ..checks.names import Scope
from ..checks.values import number, vector
from ..physics.statements import stated
from ..poses import about, between, compose, make
from .joints import BEARS, DEFAULT_ACCELERATION, DEFAULT_SPEED, FULL_TURN, STRAIGHT, drive_of, joint_rate
from .urdf_reading import BALL, Reading, UrdfJoint

FREE = 10.0
"""Metres that a planar or floating joint moves each way unless the module says otherwise: across a large hall."""
ENDLESS = 1e6
"""From here on a number stands for none: files say 1e16, and infinity."""
AXES: tuple[ir.Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
HERE = make((0.0, 0.0, 0.0), STRAIGHT)
SCALAR = {"revolute": ir.JointKind.REVOLUTE, "continuous": ir.JointKind.REVOLUTE, "prismatic": ir.JointKind.PRISMATIC}


@dataclass(frozen=True, slots=True)
class Moved:
    """The frame that a joint moves: `joints` on the way to it, and where it is behind the last of them (or, without
    any, behind the frame that carries the joint)."""

    joints: tuple[ir.Joint, ...]
    frame: ir.Pose


@dataclass(frozen=True, slots=True)
class JointBuilder:
    """Builds the joints of a module whose declaration has the `items` by joint name."""

    context: Context
    scope: Scope
    reading: Reading
    items: Mapping[str, syntax.JointItem]

    def build(self, joint: UrdfJoint, parent: int, first: int, frame: ir.Pose) -> Moved | None:
        """What joint `parent` carries at `frame`; the first joint made gets the index `first`. None after a fault."""
        item = self.items.get(joint.name)
        if joint.kind == "fixed":
            if item is not None:
                self.context.findings.report("E0508", item.span, f"joint `{joint.name}` is fixed in the URDF")
            return Moved((), compose(frame, joint.origin))
        placement = compose(frame, joint.origin)
        if joint.kind in SCALAR:
            return self._scalar(joint, item, parent, placement)
        return self._free(joint, item, parent, first, placement)

    def _scalar(
        self, joint: UrdfJoint, item: syntax.JointItem | None, parent: int, placement: ir.Pose
    ) -> Moved | None:
        kind = SCALAR[joint.kind]
        own = self._given(item, kind)
        limits = self._limits(joint, own)
        rates = [self._rate(joint, item, kind, what) for what in ("speed", "acceleration")]
        if own is None or limits is None or rates[0] is None or rates[1] is None:
            return None
        lower, upper = limits
        if lower == upper:
            message = f"joint `{joint.name}` cannot move, from {lower:g} to {upper:g}, and is fixed"
            self.reading.warn(joint.element, message)
            shift = (lower * joint.axis[0], lower * joint.axis[1], lower * joint.axis[2])
            turns = kind == ir.JointKind.REVOLUTE
            motion = make(HERE[:3], about(joint.axis, lower)) if turns else make(shift, STRAIGHT)
            return Moved((), compose(placement, motion))
        home = own.home if own.home is not None else 0.0 if lower <= 0 <= upper else (lower + upper) / 2
        if not lower <= home <= upper and item is not None:
            message = f"the home value {home:g} of joint `{joint.name}` is outside {lower:g} .. {upper:g}"
            self.context.findings.report("E0508", item.span, message)
            return None
        limit = joint.element.find("limit")
        effort = 0.0 if limit is None else self.reading.number(limit, "effort", "0", endless=True)
        if limit is not None and effort is not None and effort < 0.0:
            told = f"joint `{joint.name}` has an effort of {effort:g}: it is left out"
            self.reading.warn(limit, told, "an effort is positive; 0 says that none is known")
        drive: dict[str, Any] = {"torque": effort if effort is not None and effort > 0 else math.inf}
        if item is not None and item.physics:
            own_drive = drive_of(stated(self.context, self.scope, item, BEARS[kind], f"a {kind} joint"))
            drive = own_drive | (drive if math.isinf(own_drive["torque"]) else {})
        drive["passive"] = item is not None and item.passive
        if item is not None and item.jerk is not None:
            wanted = RATES[RATES[RATES[ANGLE if kind == ir.JointKind.REVOLUTE else LENGTH]]]
            jerk = joint_rate(self.context, self.scope, replace(item, kind=kind), "jerk", wanted)
            if jerk is None:
                return None
            drive["jerk"] = jerk
        place = (parent, placement, joint.axis)
        made = ir.Joint(joint.name, kind, *place, lower, upper, home, rates[0], rates[1], **drive)
        return Moved((made,), HERE)

    def _limits(self, joint: UrdfJoint, own: _Given | None) -> tuple[float, float] | None:
        """Lower and upper limit, the module's own before those of the file."""
        if own is None:
            return None
        if own.limits is not None:
            return own.limits
        if joint.kind == "continuous":
            return -FULL_TURN, FULL_TURN
        limit = joint.element.find("limit")
        example = "-90 deg .. 90 deg" if joint.kind == "revolute" else "0 m .. 50 cm"
        name = joint.name if joint.name.isidentifier() and joint.name.isascii() else f'"{joint.name}"'
        help = f"write `joint {name} in {example}` into module `{self.reading.module.name}`"
        if limit is None or (limit.get("lower") is None and limit.get("upper") is None):
            where = joint.element if limit is None else limit
            self.reading.fault(where, f"joint `{joint.name}` has no limits", help)
            return None
        ends = [self.reading.number(limit, end, "0", endless=True) for end in ("lower", "upper")]
        if ends[0] is None or ends[1] is None:
            return None
        lower, upper = ends[0], ends[1]
        if lower > upper or lower >= ENDLESS or upper <= -ENDLESS:
            message = f"the limits of joint `{joint.name}` are empty: {lower:g} .. {upper:g}"
            self.reading.fault(limit, message, help)
            return None
        if lower > -ENDLESS and upper < ENDLESS:
            return lower, upper
        reach, way = (FULL_TURN, "a turn") if joint.kind == "revolute" else (FREE, f"{FREE:g} m")
        lower, upper = max(lower, min(0.0, upper) - reach), min(upper, max(0.0, lower) + reach)
        told = f"joint `{joint.name}` has limits of {ends[0]:g} .. {ends[1]:g}: it moves up to {way} each way"
        self.reading.warn(limit, told, help)
        return lower, upper

    def _rate(self, joint: UrdfJoint, item: syntax.JointItem | None, kind: ir.JointKind, what: str) -> float | None:
        """The greatest speed or acceleration, SI; the module's own before that of the file."""
        if item is not None and (item.speed if what == "speed" else item.acceleration) is not None:
            wanted = RATES[ANGLE if kind == ir.JointKind.REVOLUTE else LENGTH]
            asked = wanted if what == "speed" else RATES[wanted]
            return joint_rate(self.context, self.scope, replace(item, kind=kind), what, asked)
        limit, default = joint.element.find("limit"), DEFAULT_SPEED if what == "speed" else DEFAULT_ACCELERATION
        name = "velocity" if what == "speed" else "acceleration"
        given = 0.0 if limit is None else self.reading.number(limit, name, "0", endless=True)
        return given if given is None or 0 < given < ENDLESS else default[kind]

    def _free(
        self, joint: UrdfJoint, item: syntax.JointItem | None, parent: int, first: int, placement: ir.Pose
    ) -> Moved | None:
        """The joints of a planar one, in the plane across its axis, of a floating one, or of one that only turns."""
        planar, ball = joint.kind == "planar", joint.kind == BALL
        if ball and item is not None:
            self.context.findings.report("E0508", item.span, f"joint `{joint.name}` turns any way, and has no limits")
        corners = ((), ()) if ball else self._corners(joint, item, 2 if planar else 3)
        if corners is None:
            return None
        turn = between(AXES[2], joint.axis) if planar else STRAIGHT
        made: list[ir.Joint] = []

        def add(name: str, kind: ir.JointKind, axis: ir.Vec3, lower: float, upper: float) -> None:
            at = compose(placement, make(HERE[:3], turn)) if not made else HERE
            home = 0.0 if lower <= 0 <= upper else (lower + upper) / 2
            on = first + len(made) - 1 if made else parent
            speeds = DEFAULT_SPEED[kind], DEFAULT_ACCELERATION[kind]
            made.append(ir.Joint(f"{joint.name}.{name}", kind, on, at, axis, lower, upper, home, *speeds))

        for name, axis, lower, upper in zip("xyz", AXES, *corners, strict=False):
            add(name, ir.JointKind.PRISMATIC, axis, lower, upper)
        for name, axis in [("turn", AXES[2])] if planar else zip(("yaw", "pitch", "roll"), AXES[::-1], strict=True):
            add(name, ir.JointKind.REVOLUTE, axis, -FULL_TURN, FULL_TURN)
        back = make(HERE[:3], (-turn[0], -turn[1], -turn[2], turn[3]))
        return Moved(tuple(made), back)

    def _corners(
        self, joint: UrdfJoint, item: syntax.JointItem | None, count: int
    ) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        """Between which two corners a planar or floating joint moves."""
        if item is None or item.lower is None or item.upper is None:
            example = f"({', '.join(['-2 m'] * count)}) .. ({', '.join(['2 m'] * count)})"
            message = f"nothing limits joint `{joint.name}`: it moves up to {FREE:g} m each way"
            self.reading.warn(joint.element, f"{message}, unless the module says `joint {joint.name} in {example}`")
            return (-FREE,) * count, (FREE,) * count
        ends = [
            vector(self.context, self.scope, end, count, LENGTH, f"a limit of a {joint.kind} joint")
            for end in (item.lower, item.upper)
        ]
        if ends[0] is None or ends[1] is None:
            return None
        if any(a >= b for a, b in zip(ends[0], ends[1], strict=True)):
            self.context.findings.report("E0508", item.lower.span, f"the limits of joint `{joint.name}` are empty")
            return None
        return ends[0], ends[1]

    def _given(self, item: syntax.JointItem | None, kind: ir.JointKind) -> _Given | None:
        """Limits and home value of the declaration; None where a value is wrong or not known yet."""
        if item is None:
            return _Given(None, None)
        unit = ANGLE if kind == ir.JointKind.REVOLUTE else LENGTH
        home = None if item.home is None else number(self.context, self.scope, item.home, unit, "a home value")
        if item.home is not None and home is None:
            return None
        if item.lower is None or item.upper is None:
            return _Given(None, home)
        lower = number(self.context, self.scope, item.lower, unit, "a joint limit")
        upper = number(self.context, self.scope, item.upper, unit, "a joint limit")
        if lower is None or upper is None:
            return None
        if not -math.inf < lower < upper:
            message = f"the limits of joint `{item.name}` are empty: {lower:g} .. {upper:g}"
            self.context.findings.report("E0508", item.lower.span, message)
            return None
        return _Given((lower, upper), home)


@dataclass(frozen=True, slots=True)
class _Given:
    limits: tuple[float, float] | None
    home: float | None
