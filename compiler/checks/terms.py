"""Terms: names resolved, kinds and units checked, numbers folded. Syntax in, IR with its kind out."""

from __future__ import annotations

from ...langs import syntax
from ...langs.source import Span
from .. import ir
from ..builtins import FUNCTIONS
from .binders import bind
from .context import Context
from .evaluate import EvaluationError, arithmetic, function_value, truth
from .functions import apply_function
from .kinds import LENGTH, NUMBER, UNKNOWN, VECTOR, Kind, added, divided, multiplied
from .names import BROKEN, Scope, Typed
from .objects import check_attribute, check_index, check_name
from .scalars import warn_bare

LETTERS = ("x", "y", "z")
OPERATOR_VERBS = {"+": "added to", "-": "subtracted from", "*": "multiplied with", "/": "divided by"}


def check_term(context: Context, scope: Scope, term: syntax.Term) -> Typed:
    """The lowered term and its kind; after an error the kind is unknown and nothing more is said about it."""
    match term:
        case syntax.Number():
            kind = Kind(term.kind or "number")
            return Typed(ir.Number(term.value, term.span), kind, literal=not term.kind)
        case syntax.Text():
            context.findings.report("E0208", term.span, "a quoted text cannot stand here")
            return BROKEN
        case syntax.Wildcard():
            return _check_wildcard(context, scope, term)
        case syntax.Name():
            return check_name(context, scope, term)
        case syntax.Index():
            return check_index(context, scope, term, check_term)
        case syntax.Attribute():
            return check_attribute(context, scope, term, check_term)
        case syntax.Call():
            return _check_call(context, scope, term)
        case syntax.Negate():
            return _check_negate(context, scope, term)
        case syntax.Binary():
            return _check_binary(context, scope, term)
        case syntax.Vector():
            return _check_vector(context, scope, term)
        case syntax.Conditional():
            return _check_conditional(context, scope, term)
        case syntax.Aggregate():
            return _check_aggregate(context, scope, term)


def _check_wildcard(context: Context, scope: Scope, term: syntax.Wildcard) -> Typed:
    if not scope.wildcard:
        context.findings.report(
            "E0303",
            term.span,
            "`ANY` stands only in the literals of conditions, in deleted ones and after `previous is`",
            help="bind a variable with `exists`, or a parameter, instead" if scope.place == "rule" else None,
        )
    return Typed(ir.Any_(term.span), UNKNOWN)


def _check_call(context: Context, scope: Scope, term: syntax.Call) -> Typed:
    findings = context.findings
    builtin = FUNCTIONS.get(term.function)
    name_span = findings.word(term.span, term.function)
    declared = context.library.functions.get(term.function)
    if declared is not None and builtin is None:
        return apply_function(context, scope, term, declared)
    if builtin is None and term.function in scope.objects.families:
        help = f"a place on `{term.function}` stands behind `at`: `{term.function} at (…)`"
        findings.report("E0109", name_span, f"`{term.function}` is no function", help=help)
        return BROKEN
    if builtin is None:
        findings.unknown("E0109", "function", term.function, name_span, [*FUNCTIONS, *context.library.functions])
        return BROKEN
    place = "rule" if scope.place in ("heuristic", "goal") else scope.place
    if place not in builtin.place and not (scope.place == "goal" and "scene" in builtin.place):
        findings.report(
            "E0207",
            name_span,
            f"`{term.function}` cannot be used in {PLACES[scope.place]}",
            help=_instead(term.function, place),
            note=describe(term.function),
        )
        return BROKEN
    counts = sorted({len(o) for o in builtin.overloads})
    if len(term.args) not in counts:
        wanted = " or ".join(map(str, counts))
        findings.report(
            "E0201",
            term.span,
            f"`{term.function}` takes {wanted} argument{'s' if wanted != '1' else ''}, not {len(term.args)}",
            note=describe(term.function),
        )
        return BROKEN
    return _apply(context, scope, term, name_span)


PLACES = {
    "rule": "a rule",
    "motion": "a motion predicate",
    "scene": "a scene",
    "goal": "a goal",
    "heuristic": "a heuristic",
}


def describe(name: str) -> str:
    """The forms of a built-in function and what it gives."""
    forms = " or ".join(f"{name}({', '.join(o)})" for o in FUNCTIONS[name].overloads)
    return f"{forms}: {FUNCTIONS[name].doc}"


def _instead(name: str, place: str) -> str | None:
    twins = {"gap": "distance", "distance": "gap"}
    twin = twins.get(name)
    if twin is not None and place in FUNCTIONS[twin].place:
        return f"use `{twin}` here"
    return None


def _apply(context: Context, scope: Scope, term: syntax.Call, name_span: Span) -> Typed:
    builtin = FUNCTIONS[term.function]
    overloads = [o for o in builtin.overloads if len(o) == len(term.args)]
    arguments: list[Typed] = []
    for i, arg in enumerate(term.args):
        if all(o[i] == "letter" for o in overloads):
            arguments.append(_check_letter(context, arg))
        elif all(o[i] == "joint" for o in overloads):
            arguments.append(_check_joint(context, scope, arg))
        else:
            arguments.append(check_term(context, scope, arg))
    if any(not a.kind.known for a in arguments):
        return Typed(ir.Function(term.function, tuple(a.term for a in arguments), term.span), UNKNOWN)
    for i, (arg, typed) in enumerate(zip(term.args, arguments, strict=True)):
        fitting = [o for o in overloads if _fits(typed, o[i])]
        if not fitting:
            wanted = " or ".join(
                dict.fromkeys(Kind(o[i]).__str__() if o[i] != "object" else "an object" for o in overloads)
            )
            expected = f"argument {i + 1} of `{term.function}` must be {wanted}, not {typed.kind}"
            code = "E0203" if typed.kind.is_scalar and any(Kind(o[i]).is_scalar for o in overloads) else "E0208"
            context.findings.report(code, arg.span, expected, note=describe(term.function))
            return BROKEN
        overloads = fitting
    same = "rows" if "rows" in overloads[0] else overloads[0][0]
    kind = Kind(same if builtin.result == "same" else builtin.result)
    literal = all(a.literal for a in arguments)
    values = [a.value for a in arguments]
    if all(v is not None for v in values):
        try:
            value = function_value(term.function, [v for v in values if v is not None], context.random)
        except EvaluationError as error:
            context.findings.report(error.code, term.span, str(error))
            return BROKEN
        if value is not None:
            return Typed(ir.Number(value, term.span), kind, literal)
    lowered: list[ir.Term] = []
    for typed in arguments:
        if typed.kind.name == "joint" and isinstance(typed.term, ir.Vector):
            lowered += typed.term.items
        else:
            lowered.append(typed.term)
    literal = literal or term.function == "dot"  # an inner product is a plain number or a length, as it is compared
    return Typed(ir.Function(term.function, tuple(lowered), term.span), kind, literal)


def _fits(typed: Typed, wanted: str) -> bool:
    if wanted == "vector" and typed.is_zero:
        return False
    return (
        typed.kind.name == wanted
        or (wanted in ("length", "angle") and typed.is_zero)
        or (wanted == "length" and typed.literal)
    )


def _check_letter(context: Context, term: syntax.Term) -> Typed:
    if isinstance(term, syntax.Name) and term.name in LETTERS:
        return Typed(ir.Letter(term.name), Kind("letter"))
    context.findings.report("E0208", term.span, "one of the letters x, y, z is needed here")
    return BROKEN


def _check_joint(context: Context, scope: Scope, term: syntax.Term) -> Typed:
    """`X.j2`: a thing and the name of a joint, which is looked for once the scene is built."""
    if not isinstance(term, syntax.Attribute):
        context.findings.report("E0208", term.span, "a joint of a thing is needed here, such as `X.j2`")
        return BROKEN
    base = check_term(context, scope, term.base)
    if base.kind.known and base.kind.name != "object":
        context.findings.report("E0208", term.base.span, f"an object is needed here, not {base.kind}")
        return BROKEN
    pair = ir.Vector((base.term, ir.Letter(term.name)), term.span)
    return Typed(pair, Kind("joint") if base.kind.known else UNKNOWN)


def _check_negate(context: Context, scope: Scope, term: syntax.Negate) -> Typed:
    operand = check_term(context, scope, term.operand)
    if operand.value is not None:
        return Typed(ir.Number(-operand.value, term.span), operand.kind, operand.literal)
    if operand.kind.known and not (operand.kind.is_scalar or operand.kind.name in ("vector", "rows", "wrench")):
        context.findings.report("E0208", term.operand.span, f"{operand.kind} has no negative")
        return BROKEN
    return Typed(ir.Arith("neg", (operand.term,), term.span), operand.kind, operand.literal)


def _check_binary(context: Context, scope: Scope, term: syntax.Binary) -> Typed:
    left, right = check_term(context, scope, term.left), check_term(context, scope, term.right)
    literal = left.literal and right.literal
    if term.operator in "+-":
        kind = added(left.kind, right.kind, left.literal, right.literal)
        warn_bare(context, ((term.left, left), (term.right, right)))
    else:
        kind = multiplied(left.kind, right.kind) if term.operator == "*" else divided(left.kind, right.kind)
    if kind is None:
        _report_mixed(context, term, left, right)
        return BROKEN
    if left.value is not None and right.value is not None and kind.known:
        try:
            return Typed(ir.Number(arithmetic(term.operator, left.value, right.value), term.span), kind, literal)
        except EvaluationError as error:
            where = term.right.span if error.code == "E0211" else term.span
            context.findings.report(error.code, where, str(error))
            return BROKEN
    if term.operator in "*/":  # what an inner product is times or over a number is still either; over another, a number
        ones = [t.literal and t.value is None for t in (left, right)]
        literal = ones in ([True, False], [False, True]) if term.operator == "*" else ones == [True, False]
    return Typed(ir.Arith(term.operator, (left.term, right.term), term.span), kind, literal and kind == NUMBER)


def _report_mixed(context: Context, term: syntax.Binary, left: Typed, right: Typed) -> None:
    scalar = left.kind.is_scalar and right.kind.is_scalar
    help = None
    number = term.left if left.kind == NUMBER else term.right
    if {left.kind, right.kind} == {NUMBER, LENGTH} and term.operator in "+-":
        help = "give the number a unit, or multiply it by a length such as `1 m`"
    elif left.kind == right.kind == LENGTH and term.operator == "*":
        help = "divide one of them by `1 m` to get a plain number"
    elif {left.kind.name, right.kind.name} == {"vector", "length"} and term.operator in "+-":
        help = "write the length as a vector, such as `(0, 0, 1 m)`, or multiply it by an axis"
    first, second = (right, left) if term.operator == "-" else (left, right)
    context.findings.report(
        "E0203" if scalar else "E0208",
        number.span if help and NUMBER in (left.kind, right.kind) else term.span,
        f"{first.kind} cannot be {OPERATOR_VERBS[term.operator]} {second.kind}",
        help=help,
    )


def _check_vector(context: Context, scope: Scope, term: syntax.Vector) -> Typed:
    items = [check_term(context, scope, item) for item in term.items]
    for item, typed in zip(term.items, items, strict=True):
        if typed.kind.known and not typed.kind.is_scalar:
            context.findings.report("E0208", item.span, f"a component of a vector must be a number, not {typed.kind}")
            return BROKEN
    known = all(i.kind.known for i in items)
    vector = ir.Vector(tuple(i.term for i in items), term.span)
    return Typed(vector, VECTOR if known else UNKNOWN, items=tuple(items))


def _check_conditional(context: Context, scope: Scope, term: syntax.Conditional) -> Typed:
    condition = context.check_formula(context, scope, term.condition)
    then, otherwise = check_term(context, scope, term.then), check_term(context, scope, term.otherwise)
    chosen = truth(condition)
    if chosen is not None and scope.values_known:
        return then if chosen else otherwise
    kind = then.kind if not isinstance(then.term, ir.Prune) else otherwise.kind
    both = not isinstance(then.term, ir.Prune) and not isinstance(otherwise.term, ir.Prune)
    if (
        both
        and added(then.kind, otherwise.kind, then.literal, otherwise.literal) is None
        and not (then.is_zero or otherwise.is_zero)
    ):
        context.findings.report(
            "E0203", term.otherwise.span, f"`then` gives {then.kind} and `else` gives {otherwise.kind}"
        )
        return BROKEN
    if both and (then.is_zero or then.literal):
        kind = otherwise.kind
    return Typed(ir.Conditional(condition, then.term, otherwise.term), kind, then.literal and otherwise.literal)


def _check_aggregate(context: Context, scope: Scope, term: syntax.Aggregate) -> Typed:
    if scope.place == "motion":
        context.findings.report(
            "E0311", term.span, f"`{term.operator}` over objects cannot stand in a motion predicate"
        )
        return BROKEN
    inner, variables = bind(context, scope, term.binders)
    body = check_term(context, inner, term.body)
    if body.kind.known and not body.kind.is_scalar:
        context.findings.report("E0208", term.body.span, f"`{term.operator}` needs numbers, not {body.kind}")
        return BROKEN
    return Typed(ir.Aggregate(term.operator, variables, body.term), body.kind)
