"""Negative cycles of a heuristic: two rules that undo each other and together lower the cost-to-go (W0004).

Only values that are constant, apart from cases that prune, are compared, so that a cost-to-go that follows from the
state is never blamed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from ...langs import syntax
from .. import ir
from .context import Context
from .evaluate import EvaluationError, arithmetic

PRUNES = 1000.0
"""The thesis prunes by a cost-to-go of 1000."""


def check_cycles(
    context: Context, declared: syntax.HeuristicDecl, heuristic: ir.Heuristic, rules: Mapping[str, ir.Rule]
) -> None:
    """Report the constant negative cases of a heuristic of the main file whose rule another one undoes too cheaply."""
    if declared.span.file != context.library.path:
        return
    values = {name: constant(heuristic.cases[name].value) if name in heuristic.cases else 0.0 for name in rules}
    for case in declared.cases:
        value = values.get(case.rule)
        if value is None or value >= 0:
            continue
        for name, rule in rules.items():
            back = values[name]
            if back is not None and value + back < 0 and undoes(rule, rules[case.rule]):
                way = "itself" if name == case.rule else f"`{name}`"
                context.findings.report(
                    "W0004",
                    case.value.span,
                    f"`{case.rule}` and then {way} lead back and lower the cost-to-go by {-(value + back):g}",
                    help="let the two values sum up to 0 or more",
                )
                break


def undoes(rule: ir.Rule, other: ir.Rule) -> bool:
    """Whether `rule` can take back all that `other` changes, as far as the predicates tell."""
    added, deleted = _changes(other)
    adds, deletes = _changes(rule)
    return bool(added | deleted) and added <= deletes and deleted <= adds


def _changes(rule: ir.Rule) -> tuple[set[str], set[str]]:
    """The predicates that a rule adds and deletes."""
    effects = [e for e in ir.effects_of(rule.effects) if not e.literal.motion]
    return {e.literal.predicate for e in effects if not e.negated}, {e.literal.predicate for e in effects if e.negated}


def constant(term: ir.Term) -> float | None:
    """The one value that a term has where it does not prune; None when it varies."""
    match term:
        case ir.Number():
            return float(term.value)
        case ir.Prune():
            return math.inf
        case ir.Arith():
            operands = [constant(t) for t in term.operands]
            known = [o for o in operands if o is not None]
            if len(known) < len(operands):
                return None
            try:
                return -known[0] if term.operator == "neg" else arithmetic(term.operator, *known)
            except EvaluationError:
                return None
        case ir.Conditional():
            branches = [constant(term.then), constant(term.otherwise)]
            if None in branches:
                return None
            kept = {b for b in branches if b is not None and b < PRUNES}
            return min(kept, default=math.inf) if len(kept) <= 1 else None
    return None
