"""Rules whose loops of effects give a functional predicate as many values as the scene has things."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .. import ir
from ..checks.findings import Findings


def check_loops(findings: Findings, problem: ir.Problem) -> None:
    """Reports E0306 of such rules: they can never be done."""
    for rule in problem.rules.values():
        for literal, variables in _added(rule.effects, ()):
            declared = problem.predicates[literal.predicate]
            if declared.functional_in is None:
                continue
            key = literal.args[declared.functional_in]
            others = [a for k, a in enumerate(literal.args) if k != declared.functional_in]
            values = {a.name for a in others if isinstance(a, ir.Var)}
            loop = next((v for v in variables if v.name in values and ir.Var(v.name) != key), None)
            count = 0 if loop is None else _count(problem, loop)
            if loop is not None and count > 1:
                findings.report(
                    "E0306",
                    literal.span or rule.span,
                    f"`{rule.name}` would leave {count} values of `{literal.predicate}`, one for each `{loop.name}`, "
                    "so it can do nothing",
                    help=f"make `{loop.name}` a parameter of the rule, or give each `{loop.name}` a value of its own",
                )


def _added(
    items: Sequence[ir.EffectItem], loops: tuple[ir.Variable, ...]
) -> Iterator[tuple[ir.Literal, tuple[ir.Variable, ...]]]:
    """Facts that are added under no condition, with the variables of the loops around them."""
    for item in items:
        if isinstance(item, ir.EffectFor):
            yield from _added(item.effects, (*loops, *item.variables))
        elif isinstance(item, ir.Effect) and not item.negated and not item.literal.motion:
            yield item.literal, loops


def _count(problem: ir.Problem, loop: ir.Variable) -> int:
    """How many values a variable has; 0 where that depends on the state."""
    match loop.type:
        case ir.ObjectType(name):
            return len(problem.of_type(name))
        case ir.RangeType(ir.Number(first), ir.Number(last)):
            return max(0, round(last) - round(first) + 1)
        case _:
            return 0
