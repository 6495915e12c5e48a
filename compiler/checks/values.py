"""Values that the text of modules and scenes gives: numbers with units, vectors, shapes, and arguments of uses."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs import syntax
from ...langs.source import Span
from .. import ir
from .context import Context
from .kinds import EXAMPLES, LENGTH, UNKNOWN, VALUE_TYPES, Kind
from .names import BROKEN, Entry, Scope, Typed
from .scalars import check_scalar, expect_kind

LONGEST = 1e6
"""Metres: no size or place in a scene is larger; beyond, double precision does not hold what motions need."""
PARAMETER_TYPES = ", ".join(VALUE_TYPES)


def number(
    context: Context, scope: Scope, term: syntax.Term | None, kind: Kind, what: str, lenient: bool = False
) -> float | None:
    """The value in SI, or None where it is not known yet or wrong."""
    if term is None:
        return None
    value = context.repeated.value(term, scope.entries)
    if value is not None and abs(value) <= LONGEST:
        return value
    typed = context.check_term(context, scope, term)
    if not expect_kind(context, typed, kind, term, what, lenient) or not typed.kind.known:
        return None
    if typed.value is not None:
        context.repeated.checked(term)
    if kind == LENGTH and typed.value is not None and abs(typed.value) > LONGEST:
        context.findings.report("E0009", term.span, f"{what} is more than {LONGEST:g} m")
        return None
    return typed.value


def vector(
    context: Context, scope: Scope, term: syntax.Term, count: int, kind: Kind, what: str
) -> tuple[float, ...] | None:
    """`count` numbers of one kind; a plain number passes for a length."""
    if not isinstance(term, syntax.Vector):
        typed = context.check_term(context, scope, term)
        if typed.kind.known:
            context.findings.report("E0208", term.span, f"{what} is a vector of {count} components, not {typed.kind}")
        return None
    if len(term.items) != count:
        form = ", ".join("xyz"[:count])
        message = f"{what} has {count} components, not {len(term.items)}"
        context.findings.report("E0208", term.span, message, help=f"it has the form `({form})`")
        return None
    values = [number(context, scope, item, kind, f"a component of {what}", lenient=True) for item in term.items]
    return None if None in values else tuple(v for v in values if v is not None)


def parameter_entries(
    context: Context, parameters: Sequence[syntax.Parameter], objects: bool = False
) -> dict[str, Entry]:
    """The parameters of a declaration as seen inside it while they have no values; checks types and defaults. With
    `objects`, parameters may be objects too."""
    entries: dict[str, Entry] = {}
    for parameter in parameters:
        where = context.findings.word(parameter.span, parameter.name)
        if parameter.name in entries:
            context.findings.report("E0309", where, f"`{parameter.name}` is bound twice")
            continue
        kind = parameter_kind(context, parameter.type, objects)
        if parameter.allowed is not None:
            _check_allowed(context, parameter, kind)
        if parameter.default is not None:
            _default(context, entries, parameter, parameter.default, kind)
        entries[parameter.name] = Entry(Typed(ir.Var(parameter.name, where), kind), where)
    return entries


def parameter_kind(context: Context, node: syntax.Type, objects: bool) -> Kind:
    """The kind of a parameter's values; reports types that a parameter cannot have."""
    if isinstance(node, syntax.NamedType):
        if node.name in VALUE_TYPES:
            return VALUE_TYPES[node.name]
        if not objects:
            known = node.name in context.library.types
            if known:
                context.findings.report("E0208", node.span, f"parameters here are {PARAMETER_TYPES}")
            else:
                context.findings.unknown("E0102", "type", node.name, node.span, VALUE_TYPES)
            return UNKNOWN
        name = context.object_type(node) if node.name in context.library.types else None
        if name is None:
            context.findings.unknown("E0102", "type", node.name, node.span, [*context.library.types, *VALUE_TYPES])
            return UNKNOWN
        return Kind("object", name)
    context.findings.report(
        "E0208", node.span, f"parameters here are {PARAMETER_TYPES}" + ", or objects" * objects
    )
    return UNKNOWN


def _check_allowed(context: Context, parameter: syntax.Parameter, kind: Kind) -> None:
    """The range of a parameter: two plain values of its kind, in order."""
    assert parameter.allowed is not None
    ends = parameter.allowed.first, parameter.allowed.last
    if not kind.is_scalar:
        if kind.known:
            context.findings.report("E0208", parameter.allowed.span, f"{kind} has no range")
        return
    first, last = (number(context, Scope("scene"), e, kind, "an end of a range") for e in ends)
    for end in ends:
        if plain_value(end) is None:
            context.findings.report("E0208", end.span, "the ends of this range are plain numbers, with a unit")
    if first is not None and last is not None and first > last:
        context.findings.report("E0205", parameter.allowed.span, f"this range is empty: {first:g} .. {last:g}")


def plain_value(term: syntax.Term) -> float | None:
    """The value of a number in the text, which may have a minus before it."""
    if isinstance(term, syntax.Negate) and isinstance(term.operand, syntax.Number):
        return -term.operand.value
    return term.value if isinstance(term, syntax.Number) else None


def outside(parameter: syntax.Parameter, value: float) -> str | None:
    """What the range of a parameter says against a value, or None."""
    if parameter.allowed is None:
        return None
    first, last = plain_value(parameter.allowed.first), plain_value(parameter.allowed.last)
    if first is None or last is None or first <= value <= last:
        return None
    name = getattr(parameter.type, "name", "")
    unit = f" {EXAMPLES[name]}" if name in EXAMPLES else ""
    return f"parameter `{parameter.name}` must be {first:g} .. {last:g}{unit}, not {value:g}{unit}"


def _value_of(context: Context, scope: Scope, parameter: syntax.Parameter, term: syntax.Term, kind: Kind) -> Typed:
    what = f"parameter `{parameter.name}`"
    if kind.name == "object":
        typed = context.check_term(context, scope, term)
        fits = typed.kind.name == "object" and context.library.is_a(typed.kind.type, kind.type)
        if typed.kind.known and not fits:
            context.findings.report("E0202", term.span, f"{what} must be {kind}, not {typed.kind}")
            return BROKEN
        return typed
    typed = check_scalar(context, scope, term, kind, what)
    wrong = None if typed.value is None else outside(parameter, typed.value)
    if wrong is not None:
        context.findings.report("E0205", term.span, wrong)
        return BROKEN
    whole = isinstance(parameter.type, syntax.NamedType) and parameter.type.name == "int"
    if whole and typed.value is not None and typed.value != int(typed.value):
        context.findings.report("E0205", term.span, f"{what} must be a whole number, not {typed.value:g}")
        return BROKEN
    if whole and typed.value is not None:
        return Typed(ir.Number(int(typed.value), term.span), kind)
    return Typed(typed.term, kind if typed.kind.known else UNKNOWN)


def _default(
    context: Context, entries: dict[str, Entry], parameter: syntax.Parameter, term: syntax.Term, kind: Kind
) -> Typed:
    """The value of a parameter that is not given; the parameters before it are in sight."""
    if parameter.span in context.open_defaults:
        message = f"a function cannot use itself: the default of `{parameter.name}` does"
        context.findings.report("E0312", term.span, message)
        return BROKEN
    context.open_defaults.append(parameter.span)
    typed = _value_of(context, Scope("scene", dict(entries)), parameter, term, kind)
    context.open_defaults.pop()
    return typed


def bind_arguments(
    context: Context,
    scope: Scope,
    parameters: Sequence[syntax.Parameter],
    arguments: Sequence[syntax.Argument],
    use: Span,
    declared: Span,
) -> dict[str, Entry] | None:
    """What the parameters of a scene, module type or heuristic stand for in one use, defaults filled in; None after an
    error. `use` is the place of the use, `declared` that of the declaration."""
    given = _match(context, parameters, arguments, use, declared)
    if given is None:
        return None
    entries: dict[str, Entry] = {}
    complete = True
    for parameter in parameters:
        kind = parameter_kind(context, parameter.type, objects=True)
        term = given.get(parameter.name)
        if term is not None:
            typed = _value_of(context, scope, parameter, term, kind)
        elif parameter.default is not None:
            typed = _default(context, entries, parameter, parameter.default, kind)
        else:
            context.findings.report(
                "E0206",
                use,
                f"parameter `{parameter.name}` is missing",
                labels=[(context.findings.word(parameter.span, parameter.name), "declared here without default")],
            )
            typed = BROKEN
        complete = complete and typed.kind.known
        entries[parameter.name] = Entry(typed, parameter.span)
    return entries if complete else None


def _match(
    context: Context,
    parameters: Sequence[syntax.Parameter],
    arguments: Sequence[syntax.Argument],
    use: Span,
    declared: Span,
) -> dict[str, syntax.Term] | None:
    names = [p.name for p in parameters]
    given: dict[str, syntax.Term] = {}
    fine = True
    for i, argument in enumerate(arguments):
        name = argument.name
        if name is None:
            if i >= len(names):
                takes = f"{len(names)} argument{'s' * (len(names) != 1)}"
                context.findings.report(
                    "E0201",
                    argument.span,
                    f"this takes {takes}, not {len(arguments)}",
                    labels=[(declared, "declared here")],
                )
                return None
            name = names[i]
        where = context.findings.word(argument.span, name)
        if name not in names:
            context.findings.unknown("E0204", "parameter", name, where, names)
            fine = False
        elif name in given:
            context.findings.report("E0309", where, f"parameter `{name}` is given twice")
            fine = False
        given[name] = argument.value
    return given if fine else None
