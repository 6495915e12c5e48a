"""The plan of a schedule: phases cut at its switches, in their order, and splines that go on through the switches that
do not bind their module.

All begins and ends are ticks, and so are the knots: a segment's own spline begins and ends with neither rate nor
acceleration, so that with the rest before and after it is one spline through all knots, to the last digit.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ....compiler.ir import Action, Problem
from ... import plan as record
from ...geometry.resampling import EffectorPoses, Linker, Resampled
from ...skeleton import Array, Configuration, Skeleton, start_configuration
from ..plan_assembly import DIGITS, literal_records, phase_records, plan_of
from .dependencies import Precedence, Segment
from .list_schedule import Timetable


def plan_order(schedule: Timetable) -> list[int]:
    """The phases in the order of their switches."""
    return sorted(range(len(schedule.switches)), key=lambda k: schedule.switches[k])


def scheduled_plan(
    problem: Problem, actions: Sequence[Action], skeleton: Skeleton, order: Precedence, schedule: Timetable,
    tick: float, statistics: record.StatisticsRecord,
) -> record.Plan:  # fmt: skip
    """The plan file; `actions` and `skeleton` are in the order of the schedule's switches."""
    ends = [0, *sorted(schedule.switches)]
    segments = [(start, s) for start, s in zip(schedule.starts, order.segments, strict=True) if s is not None]
    placed = sorted(((int(start or 0), s) for start, s in segments), key=lambda p: (p[0], p[1].phase))
    joints = _joint_rows(problem, placed, ends[-1])
    here = [{m: rows[a : b + 1] for m, rows in joints.items()} for a, b in pairwise(ends)]
    poses = EffectorPoses(problem, here)
    motions, now = [], start_configuration(problem)
    for k, phase in enumerate(skeleton.phases):
        motions.append(_moved(problem, phase.mode, placed, here[k], now, (ends[k], ends[k + 1]), tick, (poses, k)))
        now = motions[-1].end(now)
    phases = phase_records(problem, actions, skeleton, motions)
    final = literal_records(problem, skeleton.final_mode, {})
    return plan_of(problem, motions, _splines(problem, placed, joints, ends, tick), phases, final, statistics)


def _joint_rows(problem: Problem, placed: Sequence[tuple[int, Segment]], last: int) -> dict[str, Array]:
    """Joint values `(ticks + 1, n)` of all modules, as they are written."""
    world = problem.world
    rows = {name: np.tile(np.asarray(m.joints, dtype=float), (last + 1, 1)) for name, m in world.modules.items()}
    for start, segment in placed:
        for name in segment.moved & rows.keys():
            values = segment.path.modules[name][:, 7:]
            rows[name][start : start + len(values)] = values
            rows[name][start + len(values) :] = values[-1]
    return {name: np.round(values, DIGITS) for name, values in rows.items()}


def _moved(
    problem: Problem, mode: frozenset[tuple[str, ...]], placed: Sequence[tuple[int, Segment]],
    here: dict[str, Array], now: Configuration, ticks: tuple[int, int], tick: float, known: tuple[EffectorPoses, int],
) -> Resampled:  # fmt: skip
    """Everything from one switch to the next: poses follow the joints through whatever the mode holds fixed."""
    begin, end = ticks
    count = end - begin + 1
    active = [(start, s) for start, s in placed if start < end and start + s.ticks > begin]
    carried = {b for _, s in active for b in s.path.bodies if b in s.moved}
    own = {b: pose[None, :] for b, pose in now.bodies.items() if b not in carried}
    linker = Linker(problem, here, now, own, count, known)
    linker.follow(mode)
    drawn: dict[str, Array] = {name: np.tile(row[:7], (count, 1)) for name, row in now.modules.items()}
    drawn |= {b: np.tile(now.bodies[b], (count, 1)) for b in carried}
    for start, segment in active:
        at = np.clip(np.arange(begin, end + 1) - start, 0, segment.ticks)
        for name in segment.moved:
            path = segment.path.modules.get(name, segment.path.bodies.get(name))
            assert path is not None
            drawn[name] = np.where((at > 0)[:, None], path[at, :7], drawn[name])
    poses = {m: linker.poses.get(m, drawn[m]) for m in now.modules}
    bodies = {b: linker.poses.get(b, drawn[b]) for b in carried}
    return Resampled(np.round(np.arange(begin, end + 1) * tick, DIGITS), poses, here, bodies)


def _splines(
    problem: Problem, placed: Sequence[tuple[int, Segment]], joints: dict[str, Array], ends: Sequence[int], tick: float
) -> list[record.SplineRecord]:
    """One spline for each row of phases in which a module moves, or waits between two motions within one phase."""
    found = []
    for name in problem.world.modules:
        spans: list[tuple[int, int]] = []
        for start, segment in placed:
            values = joints[name]
            if name in segment.moved and np.any(values[start : start + segment.ticks + 1] != values[start]):
                first = int(np.searchsorted(ends, start, side="right")) - 1
                last = int(np.searchsorted(ends, start + segment.ticks, side="left")) - 1
                if spans and spans[-1][1] >= first:
                    spans[-1] = spans[-1][0], max(last, spans[-1][1])
                else:
                    spans.append((first, last))
        for first, last in spans:
            begin, end = ends[first], ends[last + 1]
            knots = np.round(np.arange(begin, end + 1) * tick, DIGITS).tolist()
            found.append((first, record.SplineRecord(name, first, last, knots, joints[name][begin : end + 1].tolist())))
    return [spline for _, spline in sorted(found, key=lambda f: f[0])]
