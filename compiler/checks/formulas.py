"""Formulas and effects: predicates, arity and types of arguments checked, loops of goals unrolled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...langs import syntax
from .. import ir
from ..library import Signature
from .binders import bind, unrolled
from .context import Context
from .kinds import added
from .names import Scope, Typed, names_in
from .scalars import warn_bare
from .terms import check_term

TRUE = ir.And(())


def check_formula(context: Context, scope: Scope, formula: syntax.Formula) -> ir.Formula:
    """The lowered formula. What is wrong is reported and lowered as true."""
    match formula:
        case syntax.Literal():
            return _check_condition(context, scope, formula) or TRUE
        case syntax.Not():
            return ir.Not(check_formula(context, scope, formula.operand))
        case syntax.And():
            return ir.And(tuple(check_formula(context, scope, f) for f in formula.operands))
        case syntax.Or():
            return ir.Or(tuple(check_formula(context, scope, f) for f in formula.operands))
        case syntax.Exists() | syntax.Forall():
            return _check_quantifier(context, scope, formula)
        case syntax.Compare():
            return _check_compare(context, scope, formula)
        case syntax.Previous():
            return _check_previous(context, scope, formula)


def _check_condition(context: Context, scope: Scope, literal: syntax.Literal) -> ir.Formula | None:
    if literal.motion:
        context.findings.report(
            "E0310",
            literal.span,
            f"`[{literal.predicate} …]` is a motion literal: conditions read logic literals",
            help=f"did you mean `({literal.predicate} …)`?"
            if literal.predicate in context.logic
            else "motion literals belong into `post`",
        )
        return None
    if scope.place == "scene":
        context.findings.report(
            "E0311", literal.span, "a condition in a scene compares numbers; literals have no value yet"
        )
        return None
    if scope.place == "motion":
        context.findings.report("E0311", literal.span, "a motion predicate cannot read logic literals")
        return None
    if any(isinstance(argument, syntax.Wildcard) for argument in literal.args):
        return _some(check_literal(context, scope.with_wildcard(), literal), context, scope)
    return check_literal(context, scope, literal)


def _some(literal: ir.Literal | None, context: Context, scope: Scope) -> ir.Formula | None:
    """That a literal holds for some objects in place of `ANY`."""
    if literal is None:
        return None
    variables: list[ir.Variable] = []
    arguments = list(literal.args)
    for k, declared in enumerate(context.logic[literal.predicate].variables):
        if isinstance(arguments[k], ir.Any_):
            name = scope.fresh(f"any{k + 1}")
            variables.append(replace(declared, name=name))
            arguments[k] = ir.Var(name, literal.span)
    return ir.Exists(tuple(variables), replace(literal, args=tuple(arguments)))


def check_literal(context: Context, scope: Scope, literal: syntax.Literal) -> ir.Literal | None:
    """The literal with its arguments checked against the predicate's declaration; None after an error."""
    signature = find_signature(context, literal)
    if signature is None:
        return None
    if len(literal.args) != len(signature.variables):
        _report_arity(context, literal, signature)
        return None
    arguments = [check_term(context, scope, a) for a in literal.args]
    swapped = _swapped(context, arguments, signature, literal)
    fits = [
        check_argument(context, typed, variable, arg, signature, swapped)
        for typed, variable, arg in zip(arguments, signature.variables, literal.args, strict=True)
    ]
    if not all(fits) or any(not a.kind.known and not isinstance(a.term, ir.Any_) for a in arguments):
        return None
    return ir.Literal(literal.predicate, tuple(a.term for a in arguments), literal.motion, literal.span)


def find_signature(context: Context, literal: syntax.Literal) -> Signature | None:
    """The predicate that `literal` names, or None after reporting that there is none."""
    table, other = (context.motion, context.logic) if literal.motion else (context.logic, context.motion)
    signature = table.get(literal.predicate)
    if signature is not None:
        return signature
    where = context.findings.word(literal.span, literal.predicate)
    if literal.predicate in other:
        right = f"({literal.predicate} …)" if literal.motion else f"[{literal.predicate} …]"
        kind = "logic" if literal.motion else "motion"
        context.findings.report(
            "E0209",
            where,
            f"`{literal.predicate}` is a {kind} predicate",
            help=f"write `{right}`",
            labels=[(other[literal.predicate].span, "declared here")],
        )
    else:
        code, what = ("E0104", "motion predicate") if literal.motion else ("E0103", "predicate")
        names = [a.name if isinstance(a, syntax.Name) else "" for a in literal.args]
        late = next((k for k, name in enumerate(names) if name in table), None)
        if late is not None and all(names):
            left, right = "[]" if literal.motion else "()"
            words = [names[late], *([literal.predicate, *names][: late + 1]), *names[late + 1 :]]
            help = f"write `{left}{' '.join(words)}{right}`"
            told = f"unknown {what} `{literal.predicate}`: the predicate stands first"
            context.findings.report(code, literal.span, told, help=help)
            return None
        context.findings.unknown(code, what, literal.predicate, where, table)
    return None


def _report_arity(context: Context, literal: syntax.Literal, signature: Signature) -> None:
    wanted, given = len(signature.variables), len(literal.args)
    left, right = "[]" if literal.motion else "()"
    form = " ".join([signature.name, *(v.name for v in signature.variables)])
    context.findings.report(
        "E0201",
        literal.span,
        f"`{literal.predicate}` takes {wanted} argument{'s' * (wanted != 1)}, not {given}",
        help=f"it has the form `{left}{form}{right}`",
        labels=[(signature.span, "declared here")],
    )


def _swapped(context: Context, arguments: Sequence[Typed], signature: Signature, literal: syntax.Literal) -> str | None:
    """The hint for two arguments that fit only the other way round."""
    if len(arguments) != 2 or not all(a.kind.name == "object" for a in arguments):
        return None
    wanted = [v.type.name for v in signature.variables if isinstance(v.type, ir.ObjectType)]
    if all(context.library.is_a(a.kind.type, w) for a, w in zip(arguments, wanted[::-1], strict=True)):
        left, right = "[]" if literal.motion else "()"
        words = [literal.predicate, *(context.findings.text(a.span) for a in literal.args[::-1])]
        return f"the arguments fit the other way round: `{left}{' '.join(words)}{right}`"
    return None


def check_argument(
    context: Context,
    typed: Typed,
    variable: ir.Variable,
    arg: syntax.Term,
    signature: Signature,
    swapped: str | None = None,
) -> bool:
    """Whether an argument is an object of the declared type or below it; reports otherwise."""
    if not typed.kind.known:
        return True
    assert isinstance(variable.type, ir.ObjectType)
    wanted = variable.type.name
    if typed.kind.name != "object":
        help = None
        if typed.kind.name == "chain":
            help = f"name one of its ends, such as `{_written(arg)}.first`"
        context.findings.report(
            "E0208",
            arg.span,
            f"`{signature.name}` takes an object here, not {typed.kind}",
            help=help,
            labels=[(signature.span, "declared here")],
        )
        return False
    if context.library.is_a(typed.kind.type, wanted):
        return True
    help = swapped
    if help is None:
        help = _end_of(context, typed, wanted)
    if help is None and isinstance(typed.term, ir.Var) and context.library.is_a(wanted, typed.kind.type):
        help = f"declare it as `{wanted}`, which is below `{typed.kind.type}`"
    context.findings.report(
        "E0202",
        arg.span,
        f"parameter {variable.name} of `{signature.name}` must be of type `{wanted}`, not `{typed.kind.type}`",
        help=help,
        labels=[(signature.span, "declared here")],
    )
    return False


def _end_of(context: Context, typed: Typed, wanted: str) -> str | None:
    """Which ends of a module would fit where the module itself does not."""
    module = context.library.modules.get(typed.kind.type)
    if module is None or not isinstance(typed.term, ir.Object):
        return None
    items = [i for i in module.items if isinstance(i, syntax.EffectorItem)]
    ends = [i.name for i in items if context.library.is_a(i.type or "effector", wanted)]
    if not ends:
        return None
    return "name one of its ends: " + " or ".join(f"`{typed.term.name}.{end}`" for end in ends)


def _written(term: syntax.Term) -> str:
    return term.name if isinstance(term, syntax.Name) else "…"


def _check_quantifier(context: Context, scope: Scope, formula: syntax.Exists | syntax.Forall) -> ir.Formula:
    if scope.place in ("goal", "scene"):
        ranges = [b for b in formula.binders if isinstance(b.type, syntax.RangeType) and _has_value(scope, formula, b)]
        if ranges and scope.values_known:
            return _unroll(context, scope, formula, ranges)
    inner, variables = bind(context, scope, formula.binders)
    body = check_formula(context, inner, formula.body)
    return ir.Exists(variables, body) if isinstance(formula, syntax.Exists) else ir.Forall(variables, body)


def _has_value(scope: Scope, formula: syntax.Exists | syntax.Forall, binder: syntax.Parameter) -> bool:
    """Whether the ends of a range depend on no variable, such as a chain, whose values the state decides."""
    own = {b.name for b in formula.binders if not isinstance(b.type, syntax.RangeType)}
    bound = {name for name, entry in scope.entries.items() if isinstance(entry.typed.term, ir.Var)}
    return not names_in(binder.type) & (own | bound)


def _unroll(
    context: Context, scope: Scope, formula: syntax.Exists | syntax.Forall, ranges: list[syntax.Parameter]
) -> ir.Formula:
    """Loops over ranges are written out; the rest of the binders stays a quantifier inside."""
    others = tuple(b for b in formula.binders if b not in ranges)
    rounds = unrolled(context, scope, ranges)
    if rounds is None:
        return TRUE
    operands: list[ir.Formula] = []
    for inner in rounds:
        bound, variables = bind(context, inner, others)
        body = check_formula(context, bound, formula.body)
        if variables:
            body = ir.Exists(variables, body) if isinstance(formula, syntax.Exists) else ir.Forall(variables, body)
        operands.append(body)
    return ir.Or(tuple(operands)) if isinstance(formula, syntax.Exists) else ir.And(tuple(operands))


def _check_compare(context: Context, scope: Scope, formula: syntax.Compare) -> ir.Formula:
    left, right = check_term(context, scope, formula.left), check_term(context, scope, formula.right)
    lowered = ir.Compare(formula.operator, left.term, right.term, formula.span)
    if not (left.kind.known and right.kind.known):
        return TRUE
    if left.kind.name == "object" and right.kind.name == "object":
        if formula.operator not in ("=", "!="):
            context.findings.report("E0208", formula.span, f"objects compare by = and !=, not by {formula.operator}")
        elif not context.library.overlap(left.kind.type, right.kind.type):
            context.findings.report(
                "E0202",
                formula.span,
                f"these are never the same: no object is both `{left.kind.type}` and `{right.kind.type}`",
            )
        return lowered
    scalar = left.kind.is_scalar and right.kind.is_scalar
    zero = (left.is_zero and right.kind.is_scalar) or (right.is_zero and left.kind.is_scalar)
    if not scalar or not (zero or added(left.kind, right.kind, left.literal, right.literal)):
        _report_compared(context, formula, left, right, scalar)
    warn_bare(context, ((formula.left, left), (formula.right, right)))
    return lowered


def _report_compared(context: Context, formula: syntax.Compare, left: Typed, right: Typed, scalar: bool) -> None:
    help = None
    if "chain" in (left.kind.name, right.kind.name):
        help = "compare one of its ends, or `length(…)`"
    context.findings.report(
        "E0203" if scalar else "E0208", formula.span, f"{left.kind} cannot be compared with {right.kind}", help=help
    )


def _check_previous(context: Context, scope: Scope, formula: syntax.Previous) -> ir.Formula:
    findings = context.findings
    if scope.place != "heuristic":
        findings.report("E0311", formula.span, "`previous is` stands only in heuristics")
        return TRUE
    rule = context.library.rules.get(formula.rule)
    where = findings.word(formula.span, formula.rule)
    if rule is None:
        findings.unknown("E0105", "rule", formula.rule, where, context.library.rules)
        return TRUE
    if formula.args is None:
        return ir.Previous(formula.rule, None)
    if len(formula.args) != len(rule.parameters):
        findings.report(
            "E0201",
            formula.span,
            f"`{rule.name}` has {len(rule.parameters)} parameters, not {len(formula.args)}",
            help="leave the arguments out to accept any",
            labels=[(findings.word(rule.span, rule.name), "declared here")],
        )
        return TRUE
    inner = scope.with_wildcard()
    return ir.Previous(formula.rule, tuple(check_term(context, inner, a).term for a in formula.args))
