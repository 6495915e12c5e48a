"""Joints of a module: kind, axes, limits, value at home, speed and acceleration, as joints of the IR, which are
revolute or prismatic.

A planar joint moves along two axes and then turns about the third: two prismatic joints and a revolute one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ...langs import syntax
from ...langs.diagnostics import did_you_mean
from ...langs.source import Span
from .. import ir
from ..checks.context import Context
from ..checks.kinds import ANGLE, EXAMPLES, LENGTH, RATES, SCALARS, Kind
from ..checks.names import Scope
from ..checks.terms import check_term
from ..checks.values import number, vector
from ..physics.statements import StatedPart, stated
from ..poses import make

AXES: Mapping[str, ir.Vec3] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
SAME_KINDS = {name: kind for kind, names in {
    "revolute": "continuous rotary rotational hinge rotate", "prismatic": "linear slider sliding translational",
    "planar": "plane",
}.items() for name in names.split()}  # fmt: skip
"""What other tools call a kind of joint."""
DEFAULT_SPEED: Mapping[str, float] = {"revolute": 2.0, "prismatic": 0.5, "planar": 0.5}
DEFAULT_ACCELERATION: Mapping[str, float] = {"revolute": 5.0, "prismatic": 1.0, "planar": 1.0}
NO_JERK: Mapping[str, float] = dict.fromkeys(DEFAULT_SPEED, math.inf)
DEFAULTS = {"speed": DEFAULT_SPEED, "acceleration": DEFAULT_ACCELERATION, "jerk": NO_JERK}
AXIS_COUNT: Mapping[str, int] = {"revolute": 1, "prismatic": 1, "planar": 2}
BEARS = {
    "revolute": ("mass", "torque", "bearing", "rotor", "brake"),
    "prismatic": ("mass", "force", "bearing", "brake"),
    "planar": ("mass", "force", "brake"),
}
FULL_TURN = 2 * math.pi
DAY = 86_400.0
SLOWEST = 1e7
"""Seconds for 1 rad or 1 m that a limit may lead to: plans of some 1e7 s are verified, of ten times as much not."""
STRAIGHT = (0.0, 0.0, 0.0, 1.0)


def lower_joint(
    context: Context, scope: Scope, item: syntax.JointItem, parent: int, first: int, offset: ir.Vec3,
    follows: bool = False,
) -> list[ir.Joint] | None:  # fmt: skip
    """The joints that `item` stands for: the first is carried by joint `parent` at `offset` (metres) and gets the index
    `first`, each further one is carried by the one before. One that `follows` another has its home value and its drive
    from there. None where values are missing or wrong."""
    if item.kind is None:
        help = f"write `joint {item.name}: revolute(z) in …`"
        context.findings.report("E0508", item.span, f"joint `{item.name}` has no kind", help=help)
        return None
    if item.kind not in DEFAULT_SPEED:
        where = context.findings.word(item.span, item.kind)
        same = SAME_KINDS.get(item.kind)
        help = did_you_mean(item.kind, DEFAULT_SPEED) or "joints are revolute, prismatic or planar"
        help = f"did you mean `{same}`?" if same else help
        context.findings.report("E0508", where, f"unknown kind of joint `{item.kind}`", help=help)
        return None
    if follows and not _may_follow(context, item):
        return None
    axes = _axes(context, item)
    kind = ANGLE if item.kind == ir.JointKind.REVOLUTE else LENGTH
    planar = item.kind == "planar"
    limits = _planar_limits(context, scope, item) if planar else _limits(context, scope, item, kind, follows)
    speed = joint_rate(context, scope, item, "speed", RATES[kind])
    acceleration = joint_rate(context, scope, item, "acceleration", RATES[RATES[kind]])
    jerk = joint_rate(context, scope, item, "jerk", RATES[RATES[RATES[kind]]])
    if axes is None or limits is None or speed is None or acceleration is None or jerk is None:
        return None
    greatest = (speed, acceleration)
    said = stated(context, scope, item, BEARS[item.kind or ""], f"a {item.kind} joint")
    drive = drive_of(said) | {"jerk": jerk}
    if not planar:
        how = (ir.JointKind(item.kind), parent, make(offset, STRAIGHT), axes[0])
        return [ir.Joint(item.name, *how, *limits[0], *greatest, item.passive, **drive)]
    names = [f"{item.name}.{t.name}" for t in item.axes if isinstance(t, syntax.Name)]
    here = make((0.0, 0.0, 0.0), STRAIGHT)
    both = (*greatest, item.passive)
    return [
        ir.Joint(names[0], ir.JointKind.PRISMATIC, parent, make(offset, STRAIGHT), axes[0], *limits[0], *both, **drive),
        ir.Joint(names[1], ir.JointKind.PRISMATIC, first, here, axes[1], *limits[1], *both, **drive | {"mass": 0.0}),
        ir.Joint(
            f"{item.name}.turn",
            ir.JointKind.REVOLUTE,
            first + 1,
            here,
            _cross(axes[0], axes[1]),
            -FULL_TURN,
            FULL_TURN,
            0.0,
            DEFAULT_SPEED[ir.JointKind.REVOLUTE],
            DEFAULT_ACCELERATION[ir.JointKind.REVOLUTE],
            item.passive,
        ),
    ]


def drive_of(said: StatedPart) -> dict[str, Any]:
    """What a joint states of its drive, as fields of the joint. Where nothing is said, nothing is limited."""
    torque, bearing = (math.inf if value is None else value for value in (said.torque, said.bearing))
    fields = {"mass": said.mass or 0.0, "torque": torque, "bearing": bearing, "rotor": said.rotor or 0.0}
    fields["brake"] = said.brake or 0.0
    return {**fields, "stated": said.span}


def _may_follow(context: Context, item: syntax.JointItem) -> bool:
    """Whether a joint that follows another says nothing that is said there."""
    message = None
    if item.kind == "planar":
        message = f"joint `{item.name}` is planar, and only joints of one value follow others"
    elif item.home is not None:
        message = f"the home value of `{item.name}` comes from the joint that it follows"
    elif item.passive:
        message = f"`{item.name}` has the drive of the joint that it follows, or like that one has none"
    if message is not None:
        context.findings.report("E0521", item.span if item.home is None else item.home.span, message)
    return message is None


def _cross(a: ir.Vec3, b: ir.Vec3) -> ir.Vec3:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _axes(context: Context, item: syntax.JointItem) -> list[ir.Vec3] | None:
    found = [_axis(t, negative=item.kind != "planar") for t in item.axes]
    axes = [a for a in found if a is not None]
    if len(axes) == len(found) == AXIS_COUNT[item.kind or ""] and len(set(axes)) == len(axes):
        return axes
    where = item.axes[0].span if item.axes else item.span
    if item.kind == "planar":
        context.findings.report(
            "E0508", where, "a planar joint has two axes of x, y and z", help="write `planar(x, y)`"
        )
    else:
        context.findings.report(
            "E0508", where, "a joint has one axis: x, y or z", help=_meant_axis(item)
        )
    return None


def _meant_axis(item: syntax.JointItem) -> str:
    """`revolute(Y)`, and `revolute(0, 1, 0)` as an axis in numbers."""
    first = item.axes[0] if item.axes else None
    if len(item.axes) == 1 and isinstance(first, syntax.Name) and first.name.lower() in AXES:
        return f"write `{first.name.lower()}`"
    numbers = tuple(t.value for t in item.axes if isinstance(t, syntax.Number))
    along = next((name for name, axis in AXES.items() if axis == numbers), "z")
    return f"it has the form `{item.kind}({along})`"


def _axis(term: syntax.Term, negative: bool) -> ir.Vec3 | None:
    sign = 1.0
    if negative and isinstance(term, syntax.Negate):
        term, sign = term.operand, -1.0
    if not isinstance(term, syntax.Name) or term.name not in AXES:
        return None
    x, y, z = AXES[term.name]
    return (sign * x, sign * y, sign * z) if sign < 0 else (x, y, z)


Limits = tuple[float, float, float]
"""Lower and upper limit and the value at home, rad or m."""


def _limits(
    context: Context, scope: Scope, item: syntax.JointItem, kind: Kind, follows: bool
) -> list[Limits] | None:
    if item.lower is None or item.upper is None:
        if kind == LENGTH:
            _lacks_limits(context, item, "add `in 0 m .. 0.5 m`")
            return None
        lower: float | None = -math.pi
        upper: float | None = math.pi
    else:
        lower = number(context, scope, item.lower, kind, "a joint limit")
        upper = number(context, scope, item.upper, kind, "a joint limit")
    home = 0.0 if item.home is None else number(context, scope, item.home, kind, "the home value of a joint")
    if lower is None or upper is None or home is None:
        return None
    home = min(max(lower, home), max(lower, upper)) if follows else home
    return [(lower, upper, home)] if _fit(context, item, lower, upper, home) else None


def _lacks_limits(context: Context, item: syntax.JointItem, help: str) -> None:
    context.findings.report("E0508", item.span, f"joint `{item.name}` slides and needs limits", help=help)


def _fit(context: Context, item: syntax.JointItem, lower: float, upper: float, home: float) -> bool:
    findings = context.findings
    if lower >= upper and item.lower is not None and item.upper is not None:
        low, high = item.lower.span, item.upper.span
        both = Span(low.file, low.start, high.end, low.line, low.column, high.end_line, high.end_column)
        help = f"write `{findings.text(high)} .. {findings.text(low)}`" if lower > upper else None
        findings.report("E0508", both, f"the lower limit of joint `{item.name}` is not below its upper one", help=help)
        return False
    if not lower <= home <= upper:
        where = item.home.span if item.home is not None else item.span
        help = "the home value is 0 unless `home` gives another"
        if item.home is not None and item.lower is not None and item.upper is not None:
            bounds = f"{findings.text(item.lower.span)} .. {findings.text(item.upper.span)}"
            help = f"the joint moves in {bounds}"
        findings.report(
            "E0508",
            where,
            f"the home value of joint `{item.name}` is outside its limits",
            help=help,
        )
        return False
    return True


def _planar_limits(context: Context, scope: Scope, item: syntax.JointItem) -> list[Limits] | None:
    """The limits along both axes, from two corners of a rectangle."""
    if item.lower is None or item.upper is None:
        _lacks_limits(context, item, "add `in (-2 m, -2 m) .. (2 m, 2 m)`")
        return None
    lower = vector(context, scope, item.lower, 2, LENGTH, "a limit of a planar joint")
    upper = vector(context, scope, item.upper, 2, LENGTH, "a limit of a planar joint")
    home: tuple[float, ...] | None = (0.0, 0.0)
    if item.home is not None:
        home = vector(context, scope, item.home, 2, LENGTH, "the home value of a planar joint")
    if lower is None or upper is None or home is None:
        return None
    both = list(zip(lower, upper, home, strict=True))
    return both if all(_fit(context, item, *limits) for limits in both) else None


def joint_rate(context: Context, scope: Scope, item: syntax.JointItem, what: str, wanted: Kind) -> float | None:
    """The greatest `what` of the joint, "speed", "acceleration" or "jerk", in SI; None where it is wrong or not known
    yet."""
    term = {"speed": item.speed, "acceleration": item.acceleration, "jerk": item.jerk}[what]
    if term is None:
        return DEFAULTS[what][item.kind or ""]
    typed = check_term(context, scope, term)
    if not typed.kind.known:
        return None
    unit_text = EXAMPLES[wanted.name]
    article = "an" if what == "acceleration" else "a"
    if typed.kind != wanted and typed.kind.name.removeprefix("angular ") != what:
        code = "E0203" if typed.kind.name in SCALARS else "E0208"
        message = f"the {what} of a joint must be {article} {what}, not {typed.kind}"
        context.findings.report(code, term.span, message, help=f"write `2 {unit_text}`")
        return None
    if typed.kind != wanted:
        verb = "moves in" if what == "speed" else "speeds up in"
        context.findings.report("E0203", term.span, f"joint `{item.name}` {verb} {unit_text}")
        return None
    if typed.value is not None and typed.value <= 0:
        context.findings.report("E0508", term.span, f"the {what} of a joint must be positive")
        return None
    if typed.value is not None and _seconds(what, typed.value) > SLOWEST:
        unit = unit_text.split("/")[0]
        long = f"{SLOWEST / DAY:.0f} days or more for 1 {unit}"
        message = f"at a {what} of {typed.value:g} {unit_text} joint `{item.name}` takes {long}"
        help = f"times are not exact then; without `{what}` the usual one counts"
        context.findings.report("E0508", term.span, message, help=help)
        return None
    return typed.value


def _seconds(what: str, limit: float) -> float:
    """How long a way of 1 rad or 1 m takes from rest to rest with this limit alone."""
    match what:
        case "speed":
            return 1.0 / limit
        case "acceleration":
            return 2.0 * math.sqrt(1.0 / limit)
        case _:
            return math.cbrt(32.0 / limit)
