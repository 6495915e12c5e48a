"""What a plan is worth by an objective: its measures, taken from the plan itself, and bounds that none undercuts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec
import numpy as np

from ....compiler.ir import Problem
from ....compiler.objectives import Objective
from ....compiler.physics.frames import poses
from ....compiler.physics.statics import drives
from ...geometry.attachments import robots
from ...plan import ObjectiveRecord, PhaseRecord, Plan
from ...skeleton import Array
from ...tracks import body_rows
from .least_times import least_time
from .profiles import STILL

THESE, ANY, ALIKE = "these actions", "any actions", "any actions, none below those here"
"""What a bound holds for. Of the last, no action takes less than the least one of its rule in the plans that were made,
and one of a rule that was never used no less than the shortest way between switches takes straight ahead."""


def valued(
    problem: Problem, objective: Objective, plan: Plan, cost: float, least_cost: float, critical: float | None
) -> ObjectiveRecord:
    """The objective of a plan of this `cost`. None of any actions costs less than `least_cost`, none with these motions
    ends before `critical` seconds (None: no claim)."""
    wanted = {name for name, _ in objective.weights}
    measures = {name: _measured(problem, plan, name, cost) for name in wanted}
    least = {"actions": cost, "makespan": critical or 0.0, "energy": 0.0, **_shortest(problem, plan)}
    return ObjectiveRecord(
        str(objective),
        objective.value(measures),
        objective.unit,
        measures,
        {THESE: min(objective.value(least), objective.value(measures)),
         ANY: objective.value(dict.fromkeys(least, 0.0) | {"actions": least_cost})},
    )  # fmt: skip


def bounded(plan: Plan, bound: float) -> Plan:
    """The plan, which tells as well what no plan of other actions falls below, as long as none of them takes less than
    those that were met."""
    told = plan.statistics.objective
    if not isinstance(told, ObjectiveRecord):
        return plan
    told = msgspec.structs.replace(told, bounds={**told.bounds, ALIKE: min(bound, told.value)})
    return msgspec.structs.replace(plan, statistics=msgspec.structs.replace(plan.statistics, objective=told))


def shares(
    problem: Problem, objective: Objective, plan: Plan, seconds: Sequence[float]
) -> list[tuple[str, float, float]]:
    """By action of a plan in sequence its rule, the `seconds` of its motion, and what the objective adds up over
    actions beside their cost."""
    weights = dict(objective.weights)
    found = []
    for (phase, span), own in zip(spans(plan), seconds, strict=True):
        more = weights.get("duration", 0.0) * own
        if "travel" in weights:
            rows = (np.asarray(t.joints[span], dtype=float) for t in plan.tracks)
            ways = (float(np.linalg.norm(np.diff(r, axis=0), axis=1).sum()) for r in rows if r.size)
            more += weights["travel"] * sum(ways)
        if "energy" in weights:
            more += weights["energy"] * _work(problem, plan, phase, span)
        found.append((phase.rule, own, more))
    return found


def _measured(problem: Problem, plan: Plan, name: str, cost: float) -> float:
    match name:
        case "actions":
            return cost
        case "makespan":
            return plan.times[-1] if plan.phases else 0.0
        case "travel":
            rows = (np.asarray(t.joints, dtype=float) for t in plan.tracks)
            return sum(float(np.linalg.norm(np.diff(r, axis=0), axis=1).sum()) for r in rows if r.size)
        case "duration":
            return sum(_busy(problem, plan, phase, span) for phase, span in spans(plan))
        case "energy":
            return sum(_work(problem, plan, phase, span) for phase, span in spans(plan))
    raise AssertionError(name)


def spans(plan: Plan) -> Iterator[tuple[PhaseRecord, slice]]:
    """Every phase with its samples."""
    times = np.asarray(plan.times)
    cuts = [0, *(np.flatnonzero(np.diff(times) <= 0.0) + 1).tolist(), len(times)]
    for phase, first, last in zip(plan.phases, cuts, cuts[1:], strict=False):
        yield phase, slice(first, last)


def _mode(phase: PhaseRecord) -> frozenset[tuple[str, ...]]:
    return frozenset((literal.predicate, *literal.args) for literal in phase.mode)


def _busy(problem: Problem, plan: Plan, phase: PhaseRecord, span: slice) -> float:
    """Seconds of a phase in which robots move, those of all robots added up."""
    steps = np.diff(np.asarray(plan.times[span]))
    robot = robots(problem, _mode(phase))
    moving: dict[str, Array] = {}
    for track in plan.tracks:
        rows = np.asarray(track.joints[span], dtype=float)
        if rows.size:
            moves = np.abs(np.diff(rows, axis=0)).max(axis=1) > STILL
            first = robot[track.name]
            moving[first] = np.maximum(moving.get(first, np.zeros(len(steps))), moves)
    return float(sum((steps * moves).sum() for moves in moving.values()))


def _work(problem: Problem, plan: Plan, phase: PhaseRecord, span: slice) -> float:
    """Joules that the joints give in a phase."""
    times = np.asarray(plan.times[span])
    count = max(5, len(times))
    even = np.linspace(times[0], times[-1], count)

    def drawn(rows: Array) -> Array:
        return np.column_stack([np.interp(even, times, column) for column in rows.T])

    modules = {
        t.name: drawn(np.hstack([np.asarray(t.poses[span]), np.asarray(t.joints[span]).reshape(len(times), -1)]))
        for t in plan.tracks
    }
    moved = body_rows(plan)
    bodies = {b.name: drawn(np.asarray(moved[b.name][span])) if b.name in moved else np.tile(b.pose, (count, 1))
              for b in plan.bodies}  # fmt: skip
    inertia = problem.options.physics == "dynamics"
    at = poses(problem, modules, bodies, even if inertia else None)
    total = 0.0
    for (name, joint), torque in drives(problem, _mode(phase), at).items():
        steps = np.abs(np.diff(modules[name][:, 7 + joint]))
        total += float((0.5 * (np.abs(torque[1:]) + np.abs(torque[:-1])) * steps).sum())
    return total


def _shortest(problem: Problem, plan: Plan) -> Mapping[str, float]:
    """What travel and duration are at least between the poses from which and to which splines go."""
    travel = 0.0
    duration: dict[tuple[int, int], float] = {}
    for spline in plan.splines:
        away = np.abs(np.asarray(spline.values[-1]) - np.asarray(spline.values[0]))
        joints = problem.world.modules[spline.module].type.joints
        travel += float(np.linalg.norm(away))
        least = max((least_time(j, float(d)) for j, d in zip(joints, away, strict=True)), default=0.0)
        span = spline.first, spline.until
        duration[span] = max(duration.get(span, 0.0), least)
    return {"travel": travel, "duration": sum(duration.values())}
