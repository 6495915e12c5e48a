"""The plan file of a run: what was carried out, interval by interval, with courses, breakdowns and windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...compiler import ir
from ...langs.source import Span
from .. import plan as record
from ..assemble import DIGITS, body_record, literal_records, module_record, rounded_row, rounded_rows, task_record
from ..assemble import versions as found_versions
from ..skeleton import Array
from ..verify.findings import place_of
from ..verify.replay import Interpreter
from .world import Executed

Places = Mapping[ir.Fact, Span | None]


@dataclass(frozen=True, slots=True)
class Step:
    """An interval that took place, and where the literals before it, and those that it added, are written."""

    executed: Executed
    before: Places
    after: Places


def plan_of_run(
    problem: ir.Problem, steps: Sequence[Step], final_mode: frozenset[ir.Fact], places: Places,
    windows: Sequence[record.WindowRecord], statistics: record.StatisticsRecord, complete: bool,
) -> record.Plan:  # fmt: skip
    """The record of a run of `problem`; `places` tells where the literals of the end are written."""
    world = problem.world
    moving = [b for b in world.bodies if any(b in s.executed.bodies for s in steps)]
    return record.Plan(
        format=record.FORMAT,
        versions=found_versions(),
        task=task_record(problem),
        modules=[module_record(m) for m in world.modules.values()],
        bodies=[body_record(b) for b in world.bodies.values()],
        phases=_phases(problem, steps),
        final_mode=literal_records(problem, final_mode, places),
        times=rounded_row(np.concatenate([s.executed.times for s in steps])) if steps else [0.0],
        tracks=[_track(m, steps) for m in world.modules.values()],
        body_tracks=[_body_track(b, np.array(world.bodies[b].pose), steps) for b in moving],
        splines=_splines(steps),
        statistics=statistics,
        courses=[record.CourseRecord(c.body, c.start, [list(p) for p in c.points], c.speed, c.returns)
                 for c in world.courses],
        breakdowns=[record.BreakdownRecord(b.module, b.time, b.kind) for b in world.breakdowns],
        windows=list(windows),
        complete=complete,
    )  # fmt: skip


def _phases(problem: ir.Problem, steps: Sequence[Step]) -> list[record.PhaseRecord]:
    interpreter = Interpreter(problem)
    result = []
    for step in steps:
        interval, times = step.executed.interval, step.executed.times
        action = interval.action
        result.append(
            record.PhaseRecord(
                action=str(action),
                rule=action.rule,
                args=[str(a) for a in action.args],
                place=place_of(problem.rules[action.rule].span),
                start=round(float(times[0]), DIGITS),
                end=round(float(times[-1]), DIGITS),
                literals=literal_records(problem, interpreter.fluents(step.executed.before.facts), step.before),
                mode=literal_records(problem, interval.mode, step.before),
                added=literal_records(problem, interval.added, step.after),
                completed=interval.completed,
            )
        )
    return result


def _track(module: ir.Module, steps: Sequence[Step]) -> record.TrackRecord:
    poses = [s.executed.poses[module.name] for s in steps] or [np.array([module.pose])]
    joints = [s.executed.joints[module.name] for s in steps] or [np.array([module.joints])]
    return record.TrackRecord(module.name, rounded_rows(np.vstack(poses)), rounded_rows(np.vstack(joints)))


def _body_track(name: str, pose: Array, steps: Sequence[Step]) -> record.BodyTrackRecord:
    rows = []
    for step in steps:
        poses = step.executed.bodies.get(name)
        if poses is None:
            poses = np.broadcast_to(pose, (len(step.executed.times), 7))
        rows.append(poses)
        pose = poses[-1]
    return record.BodyTrackRecord(name, rounded_rows(np.vstack(rows)))


def _splines(steps: Sequence[Step]) -> list[record.SplineRecord]:
    result = []
    for index, step in enumerate(steps):
        path, times = step.executed.interval.path, step.executed.times
        for name in step.executed.poses:
            values = path.modules[name][:, 7:]
            knots = np.linspace(times[0], times[-1], len(values))
            result.append(record.SplineRecord(name, index, rounded_row(knots), rounded_rows(values)))
    return result
