"""Collects what the checks measure: the worst figure of every kind, and whatever breaks its limit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ...langs.source import Span
from ..budget import Budget
from ..plan import NO_LIMIT, FailureRecord, MeasureRecord, PlaceRecord, VerdictRecord
from .limits import LIMITS, RATE_SLACK, RATES, SHAPED, unit_of

UNMEASURABLE = 1e10
"""Stands for a figure that is infinite or no number: JSON has neither."""


class Findings:
    """Measures and failures of one verification, which ends by OutOfTime when its budget is spent."""

    def __init__(self, budget: Budget | None = None) -> None:
        self._budget = budget
        self.measures: dict[str, MeasureRecord] = {}
        self.failures: list[FailureRecord] = []
        self.residuals: list[MeasureRecord] = []
        self.unmet: list[str] | None = None
        """The parts of the goal that do not hold at the end; None where the end is not known."""
        self.at_rest = False
        self.share = 1.0
        """What is left of the limits of shapes where robots are small."""
        self.names: Mapping[str, str] = {}
        """How the plan calls sources, by the paths that spans tell."""

    def place_of(self, span: Span | None) -> PlaceRecord | None:
        """The record of a source place."""
        return None if span is None else PlaceRecord(self.names.get(span.file, span.file), span.line, span.column)

    def check_time(self) -> None:
        """Raise OutOfTime once the budget is spent."""
        if self._budget is not None:
            self._budget.check()

    def limit(self, kind: str) -> float:
        """The limit of a kind in the table."""
        return LIMITS[kind] * (self.share if kind in SHAPED else 1.0)

    def fail(
        self,
        kind: str,
        message: str,
        *,
        amount: float = 0.0,
        unit: str = "",
        time: float | None = None,
        between: Sequence[str] = (),
        place: PlaceRecord | None = None,
    ) -> None:
        """Refuse the plan for a reason that is no measure, or whose measure says too little."""
        finite = float(amount) if math.isfinite(amount) else 0.0
        self.failures.append(FailureRecord(kind, message, finite, unit, time, place, list(between)))

    def measure(
        self,
        kind: str,
        amount: float,
        message: str,
        *,
        time: float | None = None,
        between: Sequence[str] = (),
        place: PlaceRecord | None = None,
        limit: float | None = None,
    ) -> bool:
        """Record one figure of a kind; a failure when it is over its limit in the table, for rates over `limit`. True
        when it is kept. Raises OutOfTime."""
        self.check_time()
        slack = 1.0 if limit is None else RATE_SLACK
        limit, unit = self.limit(kind) if limit is None else min(limit, NO_LIMIT), unit_of(kind)
        amount = float(amount) if math.isfinite(amount) else UNMEASURABLE
        worst = self.measures.get(kind)
        if worst is None or amount * worst.limit > worst.amount * limit:
            self.measures[kind] = MeasureRecord(kind, amount, limit, unit, time, list(between), place)
        if amount <= limit * slack:
            return True
        figures = f"{amount:.3g} {unit}".rstrip() + f", limit {limit:g}"
        self.fail(kind, f"{message}: {figures}", amount=amount, unit=unit, time=time, between=between, place=place)
        return False

    def verdict(self) -> VerdictRecord:
        """What was found; verified when nothing failed."""
        measures = [self.measures[k] for k in (*LIMITS, *RATES) if k in self.measures]
        worst = {m.kind: m.amount for m in measures}
        return VerdictRecord(
            not self.failures, worst, measures, self.failures, self.residuals,
            goal_reached=self.unmet == [], unmet=self.unmet or [], at_rest=self.at_rest,
        )  # fmt: skip
