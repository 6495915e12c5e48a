"""What was refused and why: the records for report and plan, and the explanation for a task that found no plan."""

from __future__ import annotations

from ..compiler.ir import Problem
from ..langs.diagnostics import Diagnostic, Label
from ..langs.source import Span
from .bounds import Conflict
from .plan import PlaceRecord, RefusalRecord
from .skeleton import Skeleton, Violation

MOST_EXPLAINED = 5


class Refusals:
    """Collects conflicts in the order in which they were found."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._found: list[tuple[Skeleton, Conflict]] = []

    def add(self, skeleton: Skeleton, conflict: Conflict) -> None:
        self._found.append((skeleton, conflict))

    def records(self) -> list[RefusalRecord]:
        return [self._record(skeleton, conflict) for skeleton, conflict in self._found]

    def explain(self, status: str) -> list[Diagnostic]:
        """S-diagnostics, most telling first: the refusals with the fewest actions, then the largest violation."""
        if not self._found:
            return [self._nothing_found(status)]
        ranked = sorted(
            self._found,
            key=lambda item: (item[1].last - item[1].first, -max((v.amount for v in item[1].violations), default=0.0)),
        )
        seen: set[tuple[str, str]] = set()
        diagnostics: list[Diagnostic] = []
        for skeleton, conflict in ranked:
            action = str(skeleton.phases[conflict.last].action)
            reason = self._reason(conflict)
            if (action, reason) not in seen and len(diagnostics) < MOST_EXPLAINED:
                seen.add((action, reason))
                diagnostics.append(self._diagnostic(skeleton, conflict, action, reason))
        return diagnostics

    def _nothing_found(self, status: str) -> Diagnostic:
        if status == "infeasible":
            return Diagnostic(
                "S0001",
                "no sequence of actions reaches the goal: the symbolic search went through every reachable state",
                help="look at the conditions of the rules that achieve the goal, and at the reach of the robots",
            )
        return Diagnostic(
            "S0004",
            "the budget ended before a skeleton was judged",
            help="give more with --time or --nodes, or a smaller instance",
        )

    def _diagnostic(self, skeleton: Skeleton, conflict: Conflict, action: str, reason: str) -> Diagnostic:
        rule = self.problem.rules.get(skeleton.phases[conflict.last].action.rule)
        context = " from the start" if conflict.from_start else ""
        span = self._span(conflict)
        labels = (Label(rule.span, "the rule of this action"),) if rule is not None and rule.span else ()
        earlier = ", ".join(str(p.action) for p in skeleton.phases[conflict.first : conflict.last])
        return Diagnostic(
            "S0002",
            f"{action}{context} was refused by {_BOUND_NAMES[conflict.bound]}: {reason}",
            span or (rule.span if rule else None),
            labels if span else (),
            note=f"the actions before it: {earlier}" if earlier else None,
        )

    def _reason(self, conflict: Conflict) -> str:
        if not conflict.violations:
            return "no motion was found"
        return describe(conflict.violations[0])

    def _span(self, conflict: Conflict) -> Span | None:
        for violation in conflict.violations[:1]:
            motion = self.problem.motions.get(violation.literal[0])
            if motion is not None:
                return motion.span
        return None

    def _record(self, skeleton: Skeleton, conflict: Conflict) -> RefusalRecord:
        worst = conflict.violations[0] if conflict.violations else None
        span = self._span(conflict)
        return RefusalRecord(
            bound=conflict.bound,
            actions=[str(p.action) for p in skeleton.phases[conflict.first : conflict.last + 1]],
            reason=self._reason(conflict),
            amount=worst.amount if worst else 0.0,
            unit=worst.unit if worst else "",
            place=PlaceRecord(span.file, span.line, span.column) if span else None,
        )


_BOUND_NAMES = {"seq": "P_seq", "seq-path": "P_seqPath", "path": "P_path"}
_LIMITS = {
    "collision": "{0} and {1} would overlap",
    "self": "parts of {0} would overlap",
    "limit": "a joint limit of {0} is exceeded",
}


def describe(violation: Violation) -> str:
    """One clause for a violated row: `[touch c.B item] is missed by 0.213 m`."""
    kind, *args = violation.literal
    amount = f"{violation.amount:.3g} {violation.unit}"
    if kind in _LIMITS and len(args) >= 1:
        return f"{_LIMITS[kind].format(*args, '')} by {amount}"
    return f"[{' '.join(violation.literal)}] is missed by {amount}"
