"""The plan file of a run: what was carried out, interval by interval, with courses, breakdowns and windows."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from ...compiler import ir
from ...compiler.objectives import ACTIONS, Objective
from ...langs.frozen import dataclass
from .. import plan as record
from ..planner.plan_assembly import DIGITS, Places, literal_records, phase_record, plan_of
from ..planner.schedule.objective_value import valued
from ..planner.search.stepper import Stepper
from ..skeleton import Array, Phase
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
    objective: Objective = ACTIONS,
) -> record.Plan:  # fmt: skip
    """The record of a run of `problem`, with its value by the `objective`; `places` tells where the literals of the end
    are written."""
    motions = [step.executed for step in steps]
    mode = literal_records(problem, final_mode, places)
    splines = _splines(problem.world, motions)
    plain = plan_of(problem, motions, splines, _phases(problem, steps), mode, statistics)
    if objective != ACTIONS:
        value = valued(problem, objective, plain, statistics.cost, 0.0, None)
        plain = msgspec.structs.replace(plain, statistics=msgspec.structs.replace(statistics, objective=value))
    return msgspec.structs.replace(
        plain,
        courses=[record.CourseRecord(c.body, c.start, [list(p) for p in c.points], c.speed, c.returns)
                 for c in problem.world.courses],
        breakdowns=[record.BreakdownRecord(b.module, b.time, b.kind) for b in problem.world.breakdowns],
        windows=list(windows),
        complete=complete,
    )  # fmt: skip


def _splines(world: ir.World, motions: Sequence[Executed]) -> list[record.SplineRecord]:
    """A spline for every row of intervals in which joints of a module move on, from rest to rest."""
    found = []
    for name in world.modules:
        first = 0
        for last, motion in enumerate(motions):
            if name in motion.interval.through and last + 1 < len(motions):
                continue
            row = motions[first : last + 1]
            values = np.vstack([m.interval.path.modules[name][k > 0 :, 7:] for k, m in enumerate(row)])
            values = np.round(values, DIGITS)
            if np.any(values != values[0]):
                times = [np.linspace(m.times[0], m.times[-1], m.interval.path.samples)[k > 0 :]
                         for k, m in enumerate(row)]  # fmt: skip
                knots = np.round(np.concatenate(times), DIGITS).tolist()
                found.append(record.SplineRecord(name, first, last, knots, values.tolist()))
            first = last + 1
    return sorted(found, key=lambda spline: spline.first)


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


def joint_rows(problem: ir.Problem, steps: Sequence[RunStep]) -> tuple[dict[str, Array], dict[str, Array]]:
    """By module, the joint values `(T, n)` that drives were told and came to, one step after the other."""
    executed = [step.executed for step in steps]
    rest = {m.name: [np.array([m.joints])] for m in problem.world.modules.values()}
    told = {name: np.vstack([e.commanded[name] for e in executed] or rest[name]) for name in rest}
    return told, {name: np.vstack([e.driven[name] for e in executed] or rest[name]) for name in rest}
