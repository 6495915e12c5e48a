"""Module types: the elements of a declaration, in order, become a tree of joints, links and effectors.

`link L: shape` goes on by L metres along z, or by a vector; a joint turns or slides about an axis of the current frame
and carries all that follows; an effector stands at the current frame; behind a branch the line goes on from where the
branch began.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace

from ...langs import syntax
from ...langs.frozen import dataclass
from ...langs.source import PLACEHOLDER, Span
from .. import ir
from ..checks.context import Context
from ..checks.formulas import check_literal
from ..checks.kinds import LENGTH, NUMBER
from ..checks.names import Entry, Family, Objects, Scope
from ..checks.shapes import LINK_SHAPES, end_shape, shape
from ..checks.values import number, parameter_entries, vector
from ..physics.masses import shape_volume
from ..physics.statements import stated
from ..poses import between, make, orientation, unit
from ..urdf_files import urdf_path
from .couplings import text_couplings
from .joints import lower_joint
from .sunken_ends import sunken
from .urdf import End, build_urdf

ENDS_STATE = ("mass", "density", "holds")
UP: ir.Vec3 = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class BuiltModule:
    """A module type with values for its parameters, and the facts that hold for each module of it, over the names of
    its effectors."""

    type: ir.ModuleType
    facts: tuple[ir.Literal, ...]


@dataclass(slots=True)
class _Line:
    """What is built so far. `parent` is the joint that carries the current frame, -1 the module frame; `offset` is the
    current frame in the moving frame of that joint."""

    joints: list[ir.Joint] = field(default_factory=list)
    effectors: list[ir.Effector] = field(default_factory=list)
    links: list[ir.Link] = field(default_factory=list)
    parent: int = -1
    offset: ir.Vec3 = (0.0, 0.0, 0.0)
    complete: bool = True
    following: frozenset[str] = frozenset()


def effector_types(module: syntax.ModuleDecl) -> dict[str, str]:
    """The effectors of a module type and their types."""
    return {i.name: i.type or "effector" for i in module.flat() if isinstance(i, syntax.EffectorItem)}


def check_modules(context: Context) -> None:
    """Every declared module type without values for its parameters."""
    for module in context.library.modules.values():
        entries = parameter_entries(context, module.parameters)
        built = build_module(context, module, Scope("scene", entries), module.name)
        _check_names(context, module)
        _check_first_end(context, module)
        if built is not None:
            _check_sunken_ends(context, module, built.type)


def build_module(context: Context, module: syntax.ModuleDecl, scope: Scope, name: str) -> BuiltModule | None:
    """The kinematics of `module` with the parameters of `scope`; None where values are missing or wrong."""
    items = module.flat()
    line = _Line(following=frozenset(i.name for i in items if isinstance(i, syntax.CouplingItem)))
    ends = {i.name: Family(i.type or "effector", 0, i.span) for i in items if isinstance(i, syntax.EffectorItem)}
    inner = Scope("scene", scope.entries, Objects(ends), scope.values_known)
    if module.urdf is not None:
        return _from_urdf(context, inner, module, name)
    facts = _add_items(context, inner, module.items, line)
    joints = text_couplings(context, inner, items, line.joints) if line.complete else None
    if joints is None:
        return None
    return BuiltModule(ir.ModuleType(name, joints, tuple(line.effectors), tuple(line.links)), tuple(facts))


def _from_urdf(context: Context, scope: Scope, module: syntax.ModuleDecl, name: str) -> BuiltModule | None:
    """A module whose joints, links and shapes a URDF gives, with the effectors and facts of the declaration."""
    facts, ends = [], []
    for item in module.items:
        if isinstance(item, syntax.FactItem):
            literal = check_literal(context, scope, item.literal)
            facts += [literal] if literal is not None else []
        elif isinstance(item, syntax.EffectorItem):
            end = _urdf_end(context, scope, item)
            ends += [end] if end is not None else []
        elif not isinstance(item, syntax.CouplingItem) and not (isinstance(item, syntax.JointItem) and not item.kind):
            help = f"write `joint {item.name} in …`" if isinstance(item, syntax.JointItem) else None
            message = "joints and links of this module come from its URDF"
            context.findings.report("E0508", item.span, message, help=help)
    path = urdf_path(module.span.file, module)
    source = next((s for s in context.library.models if s.path == path), None)
    complete = source is not None and len(ends) == sum(isinstance(i, syntax.EffectorItem) for i in module.items)
    built = build_urdf(context, scope, module, source, ends, name) if source is not None and complete else None
    joints = None if built is None else text_couplings(context, scope, module.items, built.joints)
    return None if built is None or joints is None else BuiltModule(replace(built, joints=joints), tuple(facts))


def _urdf_end(context: Context, scope: Scope, item: syntax.EffectorItem) -> End | None:
    kind = effector_kind(context, item)
    place = effector_place(context, scope, item)
    form = None if item.shape is None else end_shape(context, scope, item.shape)
    if item.link is None:
        help = f'write `effector {item.name}: "LINK"`'
        context.findings.report("E0508", item.span, "an effector of this module names a link of its URDF", help=help)
        return None
    said = stated(context, scope, item, ENDS_STATE, "an effector")
    if place is None or (form is None and item.shape is not None):
        return None
    return End(item, kind, place, form, said)


def _check_first_end(context: Context, module: syntax.ModuleDecl) -> None:
    """Warn of an end at the beginning of a module that faces along the module instead of away from it."""
    first = next((i for i in module.items if isinstance(i, syntax.EffectorItem | syntax.LinkItem)), None)
    if not isinstance(first, syntax.EffectorItem) or first.normal is not None or first.at is not None:
        return
    behind = [i for i in module.items if isinstance(i, syntax.LinkItem)]
    if behind and not isinstance(behind[0].length, syntax.Vector | syntax.Negate):
        where = context.findings.word(first.span, first.name)
        context.findings.report(
            "W0017", where, f"`{first.name}` faces along its module, not away from it", help="add `normal (0, 0, -1)`"
        )


def _check_sunken_ends(context: Context, module: syntax.ModuleDecl, built: ir.ModuleType) -> None:
    """Warn of ends that can touch nothing but through a link."""
    items = {i.name: i for i in module.flat() if isinstance(i, syntax.EffectorItem)}
    for end, depth, whole in sunken(built):
        item = items[end.name]
        part, reach = ("", "") if whole else ("the face of ", " along its normal")
        inside = f"{1000 * depth:.3g} mm inside the link that it sits on"
        message = f"{part}`{end.name}` lies {inside}: it can touch nothing{reach}"
        help = "make it larger than the link is thick, or move it out with `at`"
        context.findings.report("W0020", context.findings.word(item.span, item.name), message, help=help)


def _add_items(
    context: Context, scope: Scope, items: Sequence[syntax.ModuleItem], line: _Line
) -> list[ir.Literal]:
    """Add the elements to `line`; gives the facts among them."""
    facts: list[ir.Literal] = []
    for item in items:
        match item:
            case syntax.EffectorItem():
                _add_effector(context, scope, item, line)
            case syntax.JointItem():
                _add_joint(context, scope, item, line)
            case syntax.LinkItem():
                _add_link(context, scope, item, line)
            case syntax.BranchItem():
                facts += _add_branch(context, scope, item, line)
            case syntax.FactItem():
                literal = check_literal(context, scope, item.literal)
                facts += [literal] if literal is not None else []
    return facts


def _check_names(context: Context, module: syntax.ModuleDecl) -> None:
    findings = context.findings
    if not any(isinstance(i, syntax.EffectorItem) for i in module.flat()):
        where = findings.word(module.span, module.name)
        findings.report(
            "E0508", where, f"module type `{module.name}` has no effector", help="add `effector A: sphere(5 cm)`"
        )
    seen: dict[str, Span] = {}
    coupled: dict[str, Span] = {}
    for item in module.flat():
        if isinstance(item, syntax.EffectorItem | syntax.JointItem | syntax.CouplingItem):
            where = findings.word(item.span, item.name)
            known = coupled if isinstance(item, syntax.CouplingItem) else seen
            if item.name in known:
                first = [(known[item.name], "first declared here")]
                findings.report("E0507", where, f"`{item.name}` is declared twice", labels=first)
            known.setdefault(item.name, where)


def _add_effector(context: Context, scope: Scope, item: syntax.EffectorItem, line: _Line) -> None:
    kind = effector_kind(context, item)
    place = effector_place(context, scope, item)
    form = None if item.shape is None else end_shape(context, scope, item.shape)
    if item.link is not None:
        context.findings.report("E0508", item.link.span, "only a module from a URDF has links with names")
    if form is None or place is None:
        line.complete = False
        return
    said = stated(context, scope, item, ENDS_STATE, "an effector")
    where, mass = _shifted(place, line.offset), said.weight(shape_volume(form))
    line.effectors.append(ir.Effector(item.name, kind, line.parent, where, form, mass, said.holds))


def effector_kind(context: Context, item: syntax.EffectorItem) -> str:
    """The type of an effector, checked."""
    findings, kind = context.findings, item.type or "effector"
    if kind not in context.library.types:
        findings.unknown("E0102", "type", kind, findings.word(item.span, kind), context.library.types)
    elif not context.library.is_a(kind, "effector"):
        findings.report("E0202", findings.word(item.span, kind), f"`{kind}` is not a type of effectors")
    return kind


def effector_place(context: Context, scope: Scope, item: syntax.EffectorItem) -> ir.Pose | None:
    """Where an effector is, from the frame at which it is declared; its z-axis is the normal."""
    at = (0.0, 0.0, 0.0) if item.at is None else vector(context, scope, item.at, 3, LENGTH, "`at` of an effector")
    normal = UP if item.normal is None else vector(context, scope, item.normal, 3, NUMBER, "a normal")
    direction = unit(normal) if normal is not None else None
    if item.normal is not None and normal is not None and direction is None:
        context.findings.report("E0508", item.normal.span, "a normal cannot be the zero vector")
    if at is None or direction is None:
        return None
    return make((at[0], at[1], at[2]), between(UP, direction))


def _shifted(pose: ir.Pose, offset: ir.Vec3) -> ir.Pose:
    return make((offset[0] + pose[0], offset[1] + pose[1], offset[2] + pose[2]), orientation(pose))


def _add_joint(context: Context, scope: Scope, item: syntax.JointItem, line: _Line) -> None:
    follows = item.name in line.following
    joints = lower_joint(context, scope, item, line.parent, len(line.joints), line.offset, follows)
    if joints is None:
        line.complete = False
        return
    line.joints += joints
    line.parent, line.offset = len(line.joints) - 1, (0.0, 0.0, 0.0)


def _add_branch(context: Context, scope: Scope, item: syntax.BranchItem, line: _Line) -> list[ir.Literal]:
    """The items of a branch; the line then goes on from where it was before."""
    parent, offset = line.parent, line.offset
    facts = _add_items(context, scope, item.items, line)
    line.parent, line.offset = parent, offset
    return facts


def _add_link(context: Context, scope: Scope, item: syntax.LinkItem, line: _Line) -> None:
    step = _step(context, scope, item.length)
    form = None if item.shape is None else shape(context, scope, item.shape, LINK_SHAPES)
    if step is None or (form is None and item.shape is not None):
        line.complete = False
        return
    length = math.sqrt(sum(s * s for s in step))
    direction = unit(step)
    if direction is None:
        context.findings.report("E0508", item.length.span, "a link must have a length above 0")
        line.complete = False
        return
    if form is not None:
        middle = (line.offset[0] + step[0] / 2, line.offset[1] + step[1] / 2, line.offset[2] + step[2] / 2)
        size = form.size if form.kind == ir.ShapeKind.SPHERE else (*form.size, length)
        drawn = ir.Shape(form.kind, size)
        mass = stated(context, scope, item, ("mass", "density"), "a link").weight(shape_volume(drawn))
        line.links.append(ir.Link(line.parent, make(middle, between(UP, direction)), drawn, mass))
    elif item.physics:
        help = "give it a shape, or the mass to the joint or effector that follows"
        context.findings.report("E0522", item.physics[0].span, "a link without shape states no mass", help=help)
    line.offset = (line.offset[0] + step[0], line.offset[1] + step[1], line.offset[2] + step[2])


def _step(context: Context, scope: Scope, term: syntax.Term) -> ir.Vec3 | None:
    if isinstance(term, syntax.Vector):
        step = vector(context, scope, term, 3, LENGTH, "a link")
        return None if step is None else (step[0], step[1], step[2])
    if isinstance(term, syntax.Name) and term.name not in scope.entries and term.name != PLACEHOLDER:
        help = "its length stands in place of a name, as in `link 40 cm: capsule(4 cm)`"
        context.findings.report("E0508", term.span, "a link has a length, and no name", help=help)
        return None
    value = number(context, scope, term, LENGTH, "the length of a link")
    if value is not None and value < 0:
        help = f"a link that goes back is a vector: `(0, 0, {value:g} m)`"
        message = f"the length of a link must be positive, not {value:g} m"
        context.findings.report("E0508", term.span, message, help=help)
        return None
    return None if value is None else (0.0, 0.0, value)


def entries_key(entries: Mapping[str, Entry]) -> tuple[float | None, ...]:
    """The values of parameters, to build each module type once."""
    return tuple(e.typed.value for e in entries.values())
