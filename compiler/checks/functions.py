"""Functions that the text declares: a call stands for the body with the arguments put in."""

from __future__ import annotations

from ...langs import syntax
from ...langs.trees import parts
from ..builtins import FUNCTIONS
from .context import Context
from .names import BROKEN, Entry, Scope, Typed
from .values import bind_arguments, parameter_entries


def check_functions(context: Context) -> None:
    """Every declared function, with parameters that stand for themselves. One that asks for the action before is read
    only where it is used, since its rules may be declared there."""
    for function in context.library.functions.values():
        where = context.findings.word(function.span, function.name)
        if function.name in FUNCTIONS:
            context.findings.report("E0118", where, f"`{function.name}` is a built-in function")
            continue
        entries = parameter_entries(context, function.parameters, objects=True)
        if any(isinstance(n, syntax.Previous) for n in parts(function.body)):
            continue
        context.open_functions.append(function.name)
        context.check_term(context, Scope(_place(function.body)).with_entries(entries.items()), function.body)
        context.open_functions.pop()


def apply_function(context: Context, scope: Scope, call: syntax.Call, function: syntax.FunctionDecl) -> Typed:
    """The body of `function` with the arguments of `call`, checked as if it stood in place of the call."""
    findings = context.findings
    if function.name in context.open_functions:
        ring = " uses ".join(f"`{n}`" for n in [*context.open_functions, function.name])
        findings.report("E0312", findings.word(call.span, call.function), f"a function cannot use itself: {ring}")
        return BROKEN
    if not context.expands:
        return BROKEN
    arguments = [syntax.Argument(None, a, span=a.span) for a in call.args]
    declared = findings.word(function.span, function.name)
    before = findings.errors
    entries = bind_arguments(context, scope, function.parameters, arguments, call.span, declared)
    if entries is None or findings.errors > before:
        return BROKEN
    context.open_functions.append(function.name)
    typed = context.check_term(context, _inner(scope, entries), function.body)
    context.open_functions.pop()
    return typed


def _inner(scope: Scope, entries: dict[str, Entry]) -> Scope:
    """Only the parameters are in sight, but no variable of the caller may be captured."""
    inner = Scope(scope.place, {}, values_known=scope.values_known, used=scope.used)
    return inner.with_entries(entries.items())


def _place(body: syntax.Term) -> str:
    """Where a function may be used, by the built-in functions in its body."""
    called = {n.function for n in parts(body) if isinstance(n, syntax.Call)} & FUNCTIONS.keys()
    fitting = [p for p in ("rule", "motion", "scene") if all(p in FUNCTIONS[c].place for c in called)]
    return "heuristic" if not fitting or fitting[0] == "rule" else fitting[0]

