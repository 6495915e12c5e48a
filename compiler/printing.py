"""Readable texts of the stages, for `tamplang compile --emit ast` and `--emit ir`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping

from ..langs import syntax
from . import ir
from .printing_terms import format_effect, format_formula, format_term, format_variable


def format_ast(file: syntax.File) -> str:
    """The syntax tree, one node per line, indented by depth; spans are left out."""
    return "\n".join(_tree(file, 0)) + "\n"


def _tree(node: object, depth: int, label: str = "") -> Iterator[str]:
    margin = "  " * depth + (f"{label}: " if label else "")
    if isinstance(node, syntax.Node):
        fields = [(f.name, getattr(node, f.name)) for f in dataclasses.fields(node) if f.name != "span"]
        plain = [f"{n}={v!r}" for n, v in fields if not _has_nodes(v)]
        yield margin + " ".join([type(node).__name__, *plain])
        for name, value in fields:
            if _has_nodes(value):
                yield from _tree(value, depth + 1, name)
    elif isinstance(node, tuple):
        yield margin.rstrip()
        for part in node:
            yield from _tree(part, depth + 1)
    else:
        yield f"{margin}{node!r}"


def _has_nodes(value: object) -> bool:
    return isinstance(value, syntax.Node) or (isinstance(value, tuple) and any(map(_has_nodes, value)))


def format_ir(problem: ir.Problem) -> str:
    """The whole problem as text: the logic in the notation of the language, the world as tables. Equal problems give
    equal texts."""
    blocks = [
        _task(problem),
        _block("types", (f"{n} < {p}" if p else n for n, p in problem.types.items())),
        _block("predicates", map(_predicate, problem.predicates.values())),
        _block("derived", (_derived(d) for d in problem.derived.values())),
        *(_motion(m) for m in problem.motions.values()),
        *(_rule(r) for r in problem.rules.values()),
        _heuristic(problem.heuristic) if problem.heuristic else "",
        *(_module_type(m) for m in _module_types(problem.world)),
        _block("bodies", (_body(b) for b in problem.world.bodies.values())),
        _block("modules", (_module(m) for m in problem.world.modules.values())),
        _block("courses", map(_course, problem.world.courses)),
        _block("breakdowns", (f"{b.module}: {b.kind} at {b.time:g}" for b in problem.world.breakdowns)),
        _block("objects", (f"{n}: {t}" for n, t in problem.objects.items())),
        _block("start", (f"({' '.join(f)})" for f in sorted(problem.init))),
        _block("start motion", (f"[{' '.join(f)}]" for f in sorted(problem.init_motion))),
        f"goal\n  {format_formula(problem.goal)}\n",
        _options(problem.options),
    ]
    return "\n".join(b for b in blocks if b)


def _block(title: str, lines: Iterable[str]) -> str:
    body = [f"  {line}" for line in lines]
    return "\n".join([title, *body]) + "\n" if body else ""


def _task(problem: ir.Problem) -> str:
    values = ", ".join(f"{n} = {v:g}" for n, v in problem.parameters.items())
    return f"task {problem.task}({values}) of {problem.file}, seed {problem.seed}\n"


def _parameters(variables: Iterable[ir.Variable]) -> str:
    return ", ".join(map(format_variable, variables))


def _predicate(p: ir.Predicate) -> str:
    words = ["static"] * p.static + ["symmetric"] * p.symmetric
    if p.functional_in is not None:
        words.append(f"functional in {p.variables[p.functional_in].name}")
    return " ".join([f"({p.name}{' ' * bool(p.variables)}{_parameters(p.variables)})", *words])


def _derived(d: ir.Derived) -> str:
    return f"({d.name} {_parameters(d.variables)}) = {format_formula(d.body)}"


def _motion(m: ir.MotionPredicate) -> str:
    title = f"motion [{m.name} {_parameters(m.variables)}]" + " symmetric" * m.symmetric
    title += f" borne {m.borne}" if m.borne else ""
    return _block(title, [*map(_row, m.rows), *(f"touching {a} {b}" for a, b in m.touching)]) or title + "\n"


def _row(row: ir.Row) -> str:
    head = {"switch": "at switch ", "during": "during ", "keep": "keep "}[row.when]
    right = f" {row.operator} {format_term(row.right)}" if row.right is not None else ""
    return f"{head}{format_term(row.left)}{right}  # {row.rows} row{'s' * (row.rows != 1)}"


def _rule(r: ir.Rule) -> str:
    lines = [f"pre  {format_formula(r.condition)}"]
    lines += [f"post {format_effect(e)}" for e in r.effects]
    lines.append(f"cost {format_term(r.cost)}")
    return _block(f"rule {r.name}({_parameters(r.variables)})", lines)


def _heuristic(h: ir.Heuristic) -> str:
    lines = [] if h.start is None else [f"start {format_term(h.start)}"]
    lines += [f"{name}: {format_term(case.value)}" for name, case in h.cases.items()]
    return _block(f"heuristic {h.name}", lines)


def _module_types(world: ir.World) -> Iterable[ir.ModuleType]:
    found: Mapping[str, ir.ModuleType] = {m.type.name: m.type for m in world.modules.values()}
    return found.values()


def _module_type(m: ir.ModuleType) -> str:
    lines = [
        f"joint {i} {j.name}: {j.kind} about {_numbers(j.axis)} on {j.parent} at {_numbers(j.placement)} in "
        f"{j.lower:g} .. {j.upper:g} home {j.home:g} speed {j.speed:g} acceleration {j.acceleration:g}"
        f"{f' jerk {j.jerk:g}' if math.isfinite(j.jerk) else ''}"
        f"{' passive' * j.passive}{_coupling(j.follows)}{_drive(j)}"
        for i, j in enumerate(m.joints)
    ]
    lines += [f"link on {k.joint} at {_numbers(k.placement)}: {_shape(k.shape)}{_weight(k.mass)}" for k in m.links]
    for e in m.effectors:
        shape = _shape(e.shape) if e.shape else "no shape"
        weight = _weight(e.mass, e.holds)
        lines.append(f"effector {e.name}: {e.type} on {e.joint} at {_numbers(e.placement)}: {shape}{weight}")
    lines += [
        f"inertial on {i.joint} at {_numbers(i.centre)}: {i.mass:g} kg, {_numbers(i.inertia)}" for i in m.inertials
    ]
    return _block(f"module type {m.name}", lines)


def _coupling(follows: ir.Coupling | None) -> str:
    return "" if follows is None else f" = {follows.factor:g} * joint {follows.leader} + {follows.offset:g}"


def _drive(joint: ir.Joint) -> str:
    """What a joint states of its drive."""
    text = f" mass {joint.mass:g}" if joint.mass else ""
    text += f" torque {joint.torque:g}" if math.isfinite(joint.torque) else ""
    text += f" bearing {joint.bearing:g}" if math.isfinite(joint.bearing) else ""
    text += f" brake {joint.brake:g}" if joint.brake else ""
    return text + (f" rotor {joint.rotor:g}" if joint.rotor else "")


def _weight(mass: float | None, holds: Iterable[ir.Hold] = ()) -> str:
    """What a part states of its mass and strength."""
    text = f" mass {mass:g}" if mass is not None else ""
    for hold in holds:
        numbers = [(n, getattr(hold, n)) for n in ("force", "shear", "moment", "twist", "friction")]
        text += f" holds {hold.manner}({', '.join(f'{n} {v:g}' for n, v in numbers if math.isfinite(v))})"
    return text


def _numbers(values: Iterable[float]) -> str:
    return "(" + ", ".join(f"{v + 0.0:.6g}" for v in values) + ")"


def _shape(shape: ir.Shape) -> str:
    if shape.parts:
        return f"union({', '.join(f'{_shape(p.shape)} at {_numbers(p.at)}' for p in shape.parts)})"
    return f"{shape.kind}({', '.join(f'{s:g}' for s in shape.size)})"


def _body(b: ir.Body) -> str:
    rest = " movable" * b.movable + _weight(b.mass, b.holds)
    return f"{b.name}: {b.type} {_shape(b.shape)} at {_numbers(b.pose)}{rest}"


def _module(m: ir.Module) -> str:
    return f"{m.name}: {m.type.name} at {_numbers(m.pose)} joints {_numbers(m.joints)}"


def _course(c: ir.Course) -> str:
    way = ", ".join(map(_numbers, c.points))
    return f"{c.body}: along {way} at {c.speed:g} from {c.start:g}" + " and back" * c.returns


def _options(options: ir.Options) -> str:
    given = [f"{f.name} = {getattr(options, f.name)}" for f in dataclasses.fields(options)]
    return _block("options", (g for g in given if not g.endswith("= None")))
