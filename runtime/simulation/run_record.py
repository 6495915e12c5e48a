"""The plan file of a run: what was carried out, interval by interval, with courses, breakdowns and windows."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from ...compiler import ir
from ...langs.frozen import dataclass
from .. import plan as record
from ..planner.plan_assembly import Places, literal_records, phase_record, plan_of, splines_of
from ..planner.search.stepper import Stepper
from ..skeleton import Phase
from .world import Executed


@dataclass(frozen=True, slots=True)
class RunStep:
    """An interval that took place, and where the literals before it, and those that it added, are written."""

    executed: Executed
    before: Places
    after: Places


def plan_of_run(
    problem: ir.Problem, steps: Sequence[RunStep], final_mode: frozenset[ir.Fact], places: Places,
    windows: Sequence[record.WindowRecord], statistics: record.StatisticsRecord, complete: bool,
) -> record.Plan:  # fmt: skip
    """The record of a run of `problem`; `places` tells where the literals of the end are written."""
    motions = [step.executed for step in steps]
    paths = [executed.interval.path for executed in motions]
    mode = literal_records(problem, final_mode, places)
    splines = splines_of(problem.world, motions, paths)
    plain = plan_of(problem, motions, splines, _phases(problem, steps), mode, statistics)
    return msgspec.structs.replace(
        plain,
        courses=[record.CourseRecord(c.body, c.start, [list(p) for p in c.points], c.speed, c.returns)
                 for c in problem.world.courses],
        breakdowns=[record.BreakdownRecord(b.module, b.time, b.kind) for b in problem.world.breakdowns],
        windows=list(windows),
        complete=complete,
    )  # fmt: skip


def _phases(problem: ir.Problem, steps: Sequence[RunStep]) -> list[record.PhaseRecord]:
    stepper = Stepper(problem)
    result = []
    for step in steps:
        interval = step.executed.interval
        phase = Phase(interval.action, interval.mode, interval.added)
        facts = stepper.fluents(step.executed.before.facts)
        result.append(
            phase_record(problem, phase, step.executed, facts, step.before, step.after, interval.completed)
        )
    return result
