"""The symbolic part of a plan for planners and validators: its task as PDDL, and the plan itself as they read it."""

from __future__ import annotations

from pathlib import Path

from ...compiler.ir import Problem
from ..plan import Plan


def task(problem: Problem, path: Path) -> dict[Path, bytes]:
    """The problem, and beside it the domain, `NAME-domain.pddl`. Raises UsageError for what PDDL cannot say."""
    from ...compiler.symbolic.pddl import to_pddl

    domain, text = to_pddl(problem)
    return {path.with_name(f"{path.stem}-domain{path.suffix}"): domain.encode(), path: text.encode()}


def actions(plan: Plan, problem: Problem) -> bytes:
    """The actions in order, one a line, in the words of `task`. Raises UsageError for what PDDL cannot say."""
    from ...compiler.symbolic.pddl_plans import plan_lines

    lines = plan_lines(problem, [(phase.rule, phase.args) for phase in plan.phases if phase.completed])
    return "".join(f"{line}\n" for line in [*lines, f"; cost = {len(lines)} (unit cost)"]).encode()
