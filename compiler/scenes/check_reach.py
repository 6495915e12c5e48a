"""Goals that all modules of a scene together cannot reach, told before a search has to prove it."""

from __future__ import annotations

from ...langs.trees import parts
from .. import ir
from ..checks.findings import Findings
from .reach import Lengths, Reach

MOST_OBJECTS = 150
"""Larger scenes are left to the solver."""
MOST_MODULES = 8
"""How many modules more are tried, to tell how many it would take."""


def check_reach(findings: Findings, problem: ir.Problem) -> None:
    """Warn of each conjunct of the goal that no number of actions of all modules together reaches."""
    if len(problem.objects) > MOST_OBJECTS or not problem.rules:
        return
    lengths = Lengths(problem)
    reach = Reach(problem, lengths, 0)
    goals = problem.goal.operands if isinstance(problem.goal, ir.And) else (problem.goal,)
    for goal in goals:
        if not reach.possible(goal):
            _report(findings, problem, lengths, reach, goal)
    _count(findings, problem, reach, goals)


def _report(findings: Findings, problem: ir.Problem, lengths: Lengths, reach: Reach, goal: ir.Formula) -> None:
    literal = next((p for p in parts(goal) if isinstance(p, ir.Literal)), None)
    count = len(problem.world.modules)
    enough = next((m for m in range(1, MOST_MODULES + 1) if Reach(problem, lengths, m).possible(goal)), None)
    modules = "the scene's only module" if count == 1 else f"all {count} modules of the scene together"
    miss = reach.nearest(goal)
    shown = f"`({' '.join([literal.predicate, *map(_word, literal.args)])})`" if literal else "the goal"
    findings.report(
        "W0009",
        literal.span if literal else None,
        f"{shown} is out of reach of {modules}",
        help=f"it would take {count + enough} modules or more" if enough else None,
        note=None if miss is None else f"`{miss.rule}` needs at most {miss.limit:.2f} m, and {miss.pair[0]} and "
        f"{miss.pair[1]}, which come nearest to that, are {miss.length:.2f} m apart",
        labels=[(miss.bound.span, f"the bound of `{miss.rule}`")] if miss is not None and miss.bound.span else [],
    )


def _count(findings: Findings, problem: ir.Problem, reach: Reach, goals: tuple[ir.Formula, ...]) -> None:
    """Warn when different values of one functional predicate are wanted at once, more than there are keys for them."""
    wanted: dict[str, dict[str, ir.Formula]] = {}
    for goal in goals:
        literal = reach.normal.normal(goal, {}, False)
        while isinstance(literal, ir.Exists):
            literal = literal.body
        if isinstance(literal, ir.Literal) and literal.predicate in problem.predicates:
            key_at = problem.predicates[literal.predicate].functional_in
            value = literal.args[1 - key_at] if key_at is not None and len(literal.args) == 2 else None
            if isinstance(value, ir.Object):
                wanted.setdefault(literal.predicate, {})[value.name] = goal
    for predicate, values in wanted.items():
        keys = reach.column(predicate, problem.predicates[predicate].functional_in or 0)
        if len(values) > len(keys):
            last = next((p for p in parts(list(values.values())[-1]) if isinstance(p, ir.Literal)), None)
            findings.report(
                "W0009",
                last.span if last else None,
                f"the goal needs `{predicate}` of {len(values)} things at once, but only {len(keys)} can have one each",
                help="the scene has too few modules, or the goal asks for too much at once",
                note=f"`{predicate}` is functional: {', '.join(sorted(keys))}",
            )


def _word(term: ir.Term) -> str:
    return str(getattr(term, "name", "…"))
