"""The `options` block of a task."""

from __future__ import annotations

import dataclasses
from typing import Any

from ...langs import syntax
from ...langs.diagnostics import did_you_mean
from .. import ir
from ..checks.context import Context
from ..checks.kinds import LENGTH, NUMBER, TIME
from ..checks.names import Scope
from ..checks.values import number
from ..objective_terms import ObjectiveFault, objective_of
from ..objectives import Objective
from ..options import Option, given_at

KINDS = {"whole": NUMBER, "number": NUMBER, "amount": NUMBER, "time": TIME, "length": LENGTH}


def check_options(context: Context, scope: Scope, item: syntax.OptionsItem, before: ir.Options) -> ir.Options:
    """`before` with the entries of this block; reports unknown options and values that they do not take."""
    known = given_at("task")
    changes: dict[str, Any] = {}
    for name, term in item.entries:
        option = known.get(name)
        if option is None:
            where = context.findings.word(item.span, name)
            if name == "seed":
                help = "the command line takes it: `tamplang solve FILE --seed 3`"
                context.findings.report("E0116", where, "a task does not set its seed", help=help)
            else:
                context.findings.unknown("E0116", "option", name, where, known)
        elif option.kind == "word":
            changes[name] = _word(context, option, term)
        elif option.kind == "objective":
            changes[name] = _objective(context, scope, term)
        else:
            changes[name] = _number(context, scope, option, term)
    return dataclasses.replace(before, **{k: v for k, v in changes.items() if v is not None})


def _word(context: Context, option: Option, term: syntax.Term) -> str | None:
    word = _text(term)
    if word in option.choices:
        return word
    near = did_you_mean(word or "", option.choices) if len(word or "") > 2 else None
    if isinstance(term, syntax.Text) and term.value in option.choices:
        near = f"write `{term.value}`"
    help = near or f"{option.name} is one of {', '.join(option.choices)}"
    context.findings.report("E0210", term.span, f"option `{option.name}` does not take this value", help=help)
    return None


def _text(term: syntax.Term) -> str | None:
    """A word; one with a hyphen reads as a difference of two names."""
    if isinstance(term, syntax.Name):
        return term.name.replace("_", "-")
    if isinstance(term, syntax.Binary) and term.operator == "-":
        left, right = _text(term.left), _text(term.right)
        return f"{left}-{right}" if left and right else None
    return None


def _objective(context: Context, scope: Scope, term: syntax.Term) -> Objective | None:
    def weight(part: syntax.Term) -> float | None:
        return number(context, scope, part, NUMBER, "a weight of an objective")

    try:
        return objective_of(term, weight, lambda name: name in scope.entries)
    except ObjectiveFault as fault:
        context.findings.report(fault.code, fault.span, str(fault), help=fault.help)
        return None


def _number(context: Context, scope: Scope, option: Option, term: syntax.Term) -> float | int | None:
    name, kind = option.name, KINDS[option.kind]
    value = number(context, scope, term, kind, f"option `{name}`")
    if value is None:
        return None
    if value < 0 or (value == 0 and name not in ("margin", "gap")):
        least = "at least 0" if name in ("margin", "gap") else "positive"
        context.findings.report("E0210", term.span, f"option `{name}` must be {least}", help=option.hint)
        return None
    if option.kind == "number" and value < 1:
        context.findings.report("E0210", term.span, f"option `{name}` must be at least 1", help=option.hint)
        return None
    if option.kind == "whole":
        if value != int(value):
            context.findings.report("E0210", term.span, f"option `{name}` must be a whole number", help=option.hint)
            return None
        return int(value)
    return value
