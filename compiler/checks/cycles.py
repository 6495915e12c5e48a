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
    ways_back = WaysBack(rules, values)
    for case in declared.cases:
        value = values.get(case.rule)
        if value is None or value >= 0:
            continue
        name = ways_back.cheapest(rules[case.rule])
        back = None if name is None else values[name]
        if back is not None and value + back < 0:
            way = "itself" if name == case.rule else f"`{name}`"
            context.findings.report(
                "W0004",
                case.value.span,
                f"`{case.rule}` and then {way} lead back and lower the cost-to-go by {-(value + back):g}",
                help="let the two values sum up to 0 or more",
            )


Changes = tuple[frozenset[str], frozenset[str]]
"""The predicates that a rule adds and those that it deletes."""


class WaysBack:
    """The cheapest rule that takes back what another changes, found by what rules change, which many have in common."""

    def __init__(self, rules: Mapping[str, ir.Rule], values: Mapping[str, float | None]) -> None:
        self._values = {name: value for name, value in values.items() if value is not None}
        self._cheapest: dict[Changes, str] = {}
        for name in self._values:
            changes = changes_of(rules[name])
            if self._values[name] < self._values.get(self._cheapest.get(changes, ""), math.inf):
                self._cheapest[changes] = name
        self._answers: dict[Changes, str | None] = {}

    def cheapest(self, rule: ir.Rule) -> str | None:
        """The rule of the least value that can take back all that `rule` changes, as far as the predicates tell."""
        changed = changes_of(rule)
        if changed not in self._answers:
            ways = (name for changes, name in self._cheapest.items() if undoes(changes, changed))
            self._answers[changed] = min(ways, key=self._values.__getitem__, default=None)
        return self._answers[changed]


def undoes(changes: Changes, others: Changes) -> bool:
    """Whether what a rule changes takes back all that another changed."""
    (adds, deletes), (added, deleted) = changes, others
    return bool(added or deleted) and added <= deletes and deleted <= adds


def changes_of(rule: ir.Rule) -> Changes:
    """What a rule changes of the symbolic state; motion literals belong to the motion."""
    effects = [e for e in ir.effects_of(rule.effects) if not e.literal.motion]
    return (
        frozenset(e.literal.predicate for e in effects if not e.negated),
        frozenset(e.literal.predicate for e in effects if e.negated),
    )


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
