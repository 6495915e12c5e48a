"""Heuristics: the value at the start and the change by each rule, over the rule's own variables."""

from __future__ import annotations

from collections.abc import Mapping

from ...langs import syntax
from .. import ir
from .binders import bind
from .context import Context
from .cycles import check_cycles
from .names import Entry, Scope, Typed
from .terms import check_term
from .values import parameter_entries


def check_heuristics(context: Context, rules: Mapping[str, ir.Rule]) -> None:
    """Every declared heuristic, with parameters that stand for themselves."""
    for heuristic in context.library.heuristics.values():
        entries = parameter_entries(context, heuristic.parameters, objects=True)
        check_cycles(context, heuristic, lower_heuristic(context, heuristic, entries), rules)


def lower_heuristic(context: Context, heuristic: syntax.HeuristicDecl, entries: Mapping[str, Entry]) -> ir.Heuristic:
    """The heuristic with its parameters replaced by what `entries` says."""
    scope = Scope("heuristic").with_entries(entries.items())
    start = None if heuristic.start is None else _value(context, scope, heuristic.start)
    cases: dict[str, ir.Case] = {}
    for case in heuristic.cases:
        lowered = _check_case(context, scope, case)
        if lowered is None:
            continue
        if case.rule in cases:
            where = context.findings.word(case.span, case.rule)
            context.findings.report("E0110", where, f"there are two cases for rule `{case.rule}`")
        cases[case.rule] = lowered
    return ir.Heuristic(heuristic.name, start, cases)


def _value(context: Context, scope: Scope, term: syntax.Term) -> ir.Term:
    typed = check_term(context, scope, term)
    if typed.kind.known and typed.kind.name not in ("number", "length"):
        context.findings.report("E0208", term.span, f"a heuristic gives a number or a length, not {typed.kind}")
    return typed.term


def _check_case(context: Context, scope: Scope, case: syntax.HeuristicCase) -> ir.Case | None:
    findings = context.findings
    rule = context.library.rules.get(case.rule)
    where = findings.word(case.span, case.rule)
    if rule is None:
        findings.unknown("E0105", "rule", case.rule, where, context.library.rules)
        return None
    declared = findings.word(rule.span, rule.name)
    if len(case.parameters) != len(rule.parameters):
        names = ", ".join(p.name for p in rule.parameters)
        findings.report(
            "E0201",
            where,
            f"rule `{rule.name}` has {len(rule.parameters)} parameters, not {len(case.parameters)}",
            help=f"write `{rule.name}({names})`",
            labels=[(declared, "declared here")],
        )
        return None
    return ir.Case(case.rule, _value(context, _pattern_scope(context, scope, case, rule), case.value))


def _pattern_scope(context: Context, scope: Scope, case: syntax.HeuristicCase, rule: syntax.RuleDecl) -> Scope:
    """The pattern's names stand for the rule's variables."""
    inner, variables = bind(context, Scope("rule"), rule.parameters)
    entries: dict[str, Entry] = {}
    for name, parameter, variable in zip(case.parameters, rule.parameters, variables, strict=False):
        where = context.findings.word(case.span, name)
        if name in entries:
            context.findings.report("E0309", where, f"`{name}` is bound twice")
        kind = inner.entries[parameter.name].typed.kind
        entries[name] = Entry(Typed(ir.Var(variable.name), kind), where)
    merged = scope.with_entries(entries.items())
    used = merged.used | {v.name for v in variables}
    return Scope("heuristic", merged.entries, merged.objects, merged.values_known, merged.wildcard, used)
