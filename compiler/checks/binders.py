"""Parameters and bound variables: their types, and the scope in which they are seen."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from ...langs import syntax
from ...langs.source import Span
from .. import ir
from ..library import VALUE_TYPE_NAMES
from .context import Context
from .kinds import NUMBER, UNKNOWN, VALUE_TYPES, Kind
from .names import Entry, Scope, Typed
from .scalars import check_scalar

LARGEST_LOOP = 20_000
MOST_ROUNDS = 100_000
"""How many rounds all loops of a program may have together, ten for each thing that a scene may have; one takes some
ten microseconds for each line in it."""


def bind(context: Context, scope: Scope, binders: Sequence[syntax.Parameter]) -> tuple[Scope, tuple[ir.Variable, ...]]:
    """The scope inside a quantifier, loop or rule, and its variables. Later binders see earlier ones. Reports names
    bound twice and unknown types."""
    variables: list[ir.Variable] = []
    seen: dict[str, Span] = {}
    for binder in binders:
        where = context.findings.word(binder.span, binder.name)
        if binder.name in seen:
            first = [(seen[binder.name], "first bound here")]
            context.findings.report("E0309", where, f"`{binder.name}` is bound twice", labels=first)
            continue
        seen[binder.name] = where
        variable_type, kind = check_type(context, scope, binder.type)
        name = scope.fresh(binder.name)
        variables.append(ir.Variable(name, variable_type))
        scope = scope.with_entries([(binder.name, Entry(Typed(ir.Var(name, where), kind), where))])
    return scope, tuple(variables)


def check_type(context: Context, scope: Scope, node: syntax.Type) -> tuple[ir.Type, Kind]:
    """The lowered type of a bound variable and the kind of its values."""
    if isinstance(node, syntax.RangeType):
        return _check_range(context, scope, node), NUMBER
    if isinstance(node, syntax.ChainType):
        return _check_chain(context, scope, node)
    if node.name in VALUE_TYPE_NAMES:
        context.findings.report(
            "E0208", node.span, f"a variable cannot range over `{node.name}`", help="use a range such as `1 .. 3`"
        )
        return ir.ObjectType("object"), VALUE_TYPES[node.name]
    name = context.object_type(node)
    if name is None:
        return ir.ObjectType("object"), UNKNOWN
    return ir.ObjectType(name), Kind("object", name)


def _check_range(context: Context, scope: Scope, node: syntax.RangeType) -> ir.RangeType:
    first = check_scalar(context, scope, node.first, NUMBER, "the first value of a range")
    last = check_scalar(context, scope, node.last, NUMBER, "the last value of a range")
    return ir.RangeType(first.term, last.term)


def _check_chain(context: Context, scope: Scope, node: syntax.ChainType) -> tuple[ir.Type, Kind]:
    findings, library = context.findings, context.library
    chain = ir.ChainType(node.element, node.predicate)
    if scope.place not in ("rule", "heuristic", "goal"):
        findings.report("E0311", node.span, "chains are formed in rules, goals and heuristics only")
        return chain, UNKNOWN
    if node.element not in library.types:
        findings.unknown("E0102", "type", node.element, findings.word(node.span, node.element), library.types)
        return chain, UNKNOWN
    if not library.is_a(node.element, "module"):
        where = findings.word(node.span, node.element)
        findings.report("E0202", where, f"chains are formed of modules, and `{node.element}` is none")
        return chain, UNKNOWN
    where = findings.word(node.span, node.predicate)
    signature = context.logic.get(node.predicate)
    if signature is None:
        findings.unknown("E0103", "predicate", node.predicate, where, context.logic)
        return chain, UNKNOWN
    ends = [v.type.name for v in signature.variables if isinstance(v.type, ir.ObjectType)]
    if len(ends) != 2 or not all(library.is_a(e, "effector") for e in ends) or signature.derived or signature.static:
        findings.report(
            "E0202",
            where,
            f"chains are linked by a predicate of two effectors that rules change; `{node.predicate}` is none",
            labels=[(signature.span, "declared here")],
        )
        return chain, UNKNOWN
    return chain, Kind("chain", node.element, ends[0])


def unrolled(
    context: Context, scope: Scope, binders: Sequence[syntax.Parameter], allowed: int = LARGEST_LOOP
) -> Iterator[Scope] | None:
    """One scope for every choice of values of range binders; None when a bound is not known, or after an error."""
    if not binders:
        return iter((scope,))
    head, *rest = binders
    if not isinstance(head.type, syntax.RangeType):
        return None
    bounds = [_whole(context, scope, t) for t in (head.type.first, head.type.last)]
    first, last = bounds
    if first is None or last is None:
        return None
    if last - first >= allowed:
        message = f"this loop has more than {LARGEST_LOOP} rounds"
        context.findings.report("E0510", head.type.span, message, help=f"it runs from {first} to {last}")
        return None
    if not spend(context, max(0, last - first + 1), head.span):
        return None
    where = context.findings.word(head.span, head.name)
    inner = [
        scope.with_entries([(head.name, Entry(Typed(ir.Number(i), NUMBER), where))]) for i in range(first, last + 1)
    ]
    if not rest:
        return iter(inner)
    room = allowed // max(1, len(inner))
    nested = [unrolled(context, s, rest, room) for s in inner]
    if any(n is None for n in nested):
        return None
    return itertools.chain.from_iterable(n for n in nested if n is not None)


def spend(context: Context, rounds: int, span: Span) -> bool:
    """Whether so many rounds more are still allowed; reports once, at `span`, that they are too many."""
    before = context.rounds
    context.rounds += rounds
    if before <= MOST_ROUNDS < context.rounds:
        message = f"with this the program goes through more than {MOST_ROUNDS} rounds of loops and uses of scenes"
        context.findings.report("E0510", span, message)
    return context.rounds <= MOST_ROUNDS


def _whole(context: Context, scope: Scope, term: syntax.Term) -> int | None:
    typed = check_scalar(context, scope, term, NUMBER, "a bound of a range")
    if typed.value is None or not typed.kind.known:
        return None
    if typed.value != int(typed.value):
        context.findings.report("E0205", term.span, f"a bound of a range must be a whole number, not {typed.value:g}")
        return None
    return int(typed.value)
