"""Module types: the elements of a declaration, in order, become a serial chain of joints, links and effectors.

`link L: shape` goes on by L metres along z, or by a vector; a joint turns or slides about an axis of the current frame
and carries all that follows; an effector stands at the current frame.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ...langs import syntax
from ...langs.source import Span
from .. import ir
from ..checks.context import Context
from ..checks.formulas import check_literal
from ..checks.kinds import ANGLE, LENGTH, NUMBER, SCALARS, Kind
from ..checks.names import Entry, Family, Objects, Scope
from ..checks.terms import check_term
from ..checks.values import LINK_SHAPES, number, parameter_entries, shape, vector
from ..poses import between, make, unit

AXES: Mapping[str, ir.Vec3] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
DEFAULT_SPEED = {"revolute": 2.0, "prismatic": 0.5}
UP: ir.Vec3 = (0.0, 0.0, 1.0)
STRAIGHT = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class BuiltModule:
    """A module type with values for its parameters, and the facts that hold for each module of it, over the names of
    its effectors."""

    type: ir.ModuleType
    facts: tuple[ir.Literal, ...]


@dataclass(slots=True)
class _Chain:
    """What is built so far; `offset` is the current frame in the moving frame of the last joint."""

    joints: list[ir.Joint] = field(default_factory=list)
    effectors: list[ir.Effector] = field(default_factory=list)
    links: list[ir.Link] = field(default_factory=list)
    offset: ir.Vec3 = (0.0, 0.0, 0.0)
    complete: bool = True

    @property
    def last(self) -> int:
        return len(self.joints) - 1


def effector_types(module: syntax.ModuleDecl) -> dict[str, str]:
    """The effectors of a module type and their types."""
    return {i.name: i.type or "effector" for i in module.items if isinstance(i, syntax.EffectorItem)}


def check_modules(context: Context) -> None:
    """Every declared module type without values for its parameters."""
    for module in context.library.modules.values():
        entries = parameter_entries(context, module.parameters)
        build_module(context, module, Scope("scene", entries), module.name)
        _check_names(context, module)


def build_module(context: Context, module: syntax.ModuleDecl, scope: Scope, name: str) -> BuiltModule | None:
    """The kinematics of `module` with the parameters of `scope`; None where values are missing or wrong."""
    if module.urdf is not None:
        context.findings.report("E0508", module.urdf.span, "modules are described in the language; URDF is not read")
        return None
    chain = _Chain()
    ends = {i.name: Family(i.type or "effector", 0, i.span) for i in module.items if isinstance(i, syntax.EffectorItem)}
    inner = Scope("scene", scope.entries, Objects(ends), scope.values_known)
    facts: list[ir.Literal] = []
    for item in module.items:
        match item:
            case syntax.EffectorItem():
                _add_effector(context, inner, item, chain)
            case syntax.JointItem():
                _add_joint(context, inner, item, chain)
            case syntax.LinkItem():
                _add_link(context, inner, item, chain)
            case syntax.FactItem():
                literal = check_literal(context, inner, item.literal)
                facts += [literal] if literal is not None else []
    if not chain.complete:
        return None
    return BuiltModule(
        ir.ModuleType(name, tuple(chain.joints), tuple(chain.effectors), tuple(chain.links)), tuple(facts)
    )


def _check_names(context: Context, module: syntax.ModuleDecl) -> None:
    findings = context.findings
    if not any(isinstance(i, syntax.EffectorItem) for i in module.items):
        where = findings.word(module.span, module.name)
        findings.report(
            "E0508", where, f"module type `{module.name}` has no effector", help="add `effector A: sphere(5 cm)`"
        )
    seen: dict[str, Span] = {}
    for item in module.items:
        if isinstance(item, syntax.EffectorItem | syntax.JointItem):
            where = findings.word(item.span, item.name)
            if item.name in seen:
                first = [(seen[item.name], "first declared here")]
                findings.report("E0507", where, f"`{item.name}` is declared twice", labels=first)
            seen.setdefault(item.name, where)


def _add_effector(context: Context, scope: Scope, item: syntax.EffectorItem, chain: _Chain) -> None:
    findings = context.findings
    kind = item.type or "effector"
    if kind not in context.library.types:
        findings.unknown("E0102", "type", kind, findings.word(item.span, kind), context.library.types)
    elif not context.library.is_a(kind, "effector"):
        findings.report("E0202", findings.word(item.span, kind), f"`{kind}` is not a type of effectors")
    if isinstance(item.shape, syntax.Text):
        findings.report("E0509", item.shape.span, "an effector has a shape here, such as `sphere(5 cm)`")
        chain.complete = False
        return
    form = shape(context, scope, item.shape)
    at = (0.0, 0.0, 0.0) if item.at is None else vector(context, scope, item.at, 3, LENGTH, "`at` of an effector")
    normal = UP if item.normal is None else vector(context, scope, item.normal, 3, NUMBER, "a normal")
    direction = unit(normal) if normal is not None else None
    if item.normal is not None and normal is not None and direction is None:
        findings.report("E0508", item.normal.span, "a normal cannot be the zero vector")
    if form is None or at is None or direction is None:
        chain.complete = False
        return
    place = (chain.offset[0] + at[0], chain.offset[1] + at[1], chain.offset[2] + at[2])
    chain.effectors.append(ir.Effector(item.name, kind, chain.last, make(place, between(UP, direction)), form))


def _add_joint(context: Context, scope: Scope, item: syntax.JointItem, chain: _Chain) -> None:
    findings = context.findings
    if item.kind not in DEFAULT_SPEED:
        where = findings.word(item.span, item.kind)
        findings.report("E0508", where, f"unknown kind of joint `{item.kind}`", help=_near_joint(item.kind))
        chain.complete = False
        return
    axis = _axis(context, item)
    kind = ANGLE if item.kind == "revolute" else LENGTH
    limits = _limits(context, scope, item, kind)
    speed = _speed(context, scope, item, kind)
    if axis is None or limits is None or speed is None:
        chain.complete = False
        return
    lower, upper, home = limits
    placement = make(chain.offset, STRAIGHT)
    chain.joints.append(ir.Joint(item.name, item.kind, chain.last, placement, axis, lower, upper, home, speed))
    chain.offset = (0.0, 0.0, 0.0)


def _near_joint(kind: str) -> str:
    from ...langs.diagnostics import did_you_mean

    return did_you_mean(kind, DEFAULT_SPEED) or "joints are revolute or prismatic"


def _axis(context: Context, item: syntax.JointItem) -> ir.Vec3 | None:
    term = item.axes[0] if len(item.axes) == 1 else None
    sign = 1.0
    if isinstance(term, syntax.Negate):
        term, sign = term.operand, -1.0
    if isinstance(term, syntax.Name) and term.name in AXES:
        x, y, z = AXES[term.name]
        return (sign * x, sign * y, sign * z) if sign < 0 else (x, y, z)
    where = item.axes[0].span if item.axes else item.span
    context.findings.report("E0508", where, "a joint has one axis: x, y or z", help=f"write `{item.kind}(z)`")
    return None


def _limits(context: Context, scope: Scope, item: syntax.JointItem, kind: Kind) -> tuple[float, float, float] | None:
    findings = context.findings
    if item.lower is None or item.upper is None:
        if kind == LENGTH:
            findings.report(
                "E0508", item.span, f"joint `{item.name}` slides and needs limits", help="add `in 0 m .. 0.5 m`"
            )
            return None
        lower: float | None = -math.pi
        upper: float | None = math.pi
    else:
        lower = number(context, scope, item.lower, kind, "a joint limit")
        upper = number(context, scope, item.upper, kind, "a joint limit")
    home = 0.0 if item.home is None else number(context, scope, item.home, kind, "the home value of a joint")
    if lower is None or upper is None or home is None:
        return None
    if lower >= upper and item.lower is not None:
        findings.report(
            "E0508", item.lower.span, f"the limits of joint `{item.name}` are empty: {lower:g} .. {upper:g}"
        )
        return None
    if not lower <= home <= upper:
        where = item.home.span if item.home is not None else item.span
        help = None if item.home is not None else "the home value is 0 unless `home` gives another"
        findings.report(
            "E0508",
            where,
            f"the home value {home:g} of joint `{item.name}` is outside {lower:g} .. {upper:g}",
            help=help,
        )
        return None
    return lower, upper, home


def _speed(context: Context, scope: Scope, item: syntax.JointItem, kind: Kind) -> float | None:
    if item.speed is None:
        return DEFAULT_SPEED[item.kind]
    typed = check_term(context, scope, item.speed)
    if not typed.kind.known:
        return None
    unit_text = "rad/s" if kind == ANGLE else "m/s"
    if typed.kind.name != "speed":
        code = "E0203" if typed.kind.name in SCALARS else "E0208"
        context.findings.report(
            code,
            item.speed.span,
            f"the speed of a joint must be a speed, not {typed.kind}",
            help=f"write `2 {unit_text}`",
        )
        return None
    linear = isinstance(item.speed, syntax.Number) and item.speed.text.rstrip().endswith("m/s")
    if isinstance(item.speed, syntax.Number) and linear != (kind == LENGTH):
        context.findings.report("E0203", item.speed.span, f"joint `{item.name}` moves in {unit_text}")
        return None
    if typed.value is not None and typed.value <= 0:
        context.findings.report("E0508", item.speed.span, "the speed of a joint must be positive")
        return None
    return typed.value


def _add_link(context: Context, scope: Scope, item: syntax.LinkItem, chain: _Chain) -> None:
    step = _step(context, scope, item.length)
    form = None if item.shape is None else shape(context, scope, item.shape, LINK_SHAPES)
    if step is None or (form is None and item.shape is not None):
        chain.complete = False
        return
    length = math.sqrt(sum(s * s for s in step))
    direction = unit(step)
    if direction is None:
        context.findings.report("E0508", item.length.span, "a link must have a length above 0")
        chain.complete = False
        return
    if form is not None:
        middle = (chain.offset[0] + step[0] / 2, chain.offset[1] + step[1] / 2, chain.offset[2] + step[2] / 2)
        size = form.size if form.kind == "sphere" else (*form.size, length)
        chain.links.append(ir.Link(chain.last, make(middle, between(UP, direction)), ir.Shape(form.kind, size)))
    chain.offset = (chain.offset[0] + step[0], chain.offset[1] + step[1], chain.offset[2] + step[2])


def _step(context: Context, scope: Scope, term: syntax.Term) -> ir.Vec3 | None:
    if isinstance(term, syntax.Vector):
        step = vector(context, scope, term, 3, LENGTH, "a link")
        return None if step is None else (step[0], step[1], step[2])
    value = number(context, scope, term, LENGTH, "the length of a link")
    if value is not None and value < 0:
        context.findings.report("E0508", term.span, f"the length of a link must be positive, not {value:g} m")
        return None
    return None if value is None else (0.0, 0.0, value)


def home_values(module: ir.ModuleType) -> tuple[float, ...]:
    """The joint values in which a module starts."""
    return tuple(j.home for j in module.joints)


def entries_key(entries: Mapping[str, Entry]) -> tuple[float | None, ...]:
    """The values of parameters, to build each module type once."""
    return tuple(e.typed.value for e in entries.values())
