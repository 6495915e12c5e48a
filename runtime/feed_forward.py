"""What a plan tells of forces: its weights, and the torques that its drives give along its motion."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from ..compiler import ir
from ..compiler.physics.frames import Poses, Weight, module_weights, node_weights, poses
from ..compiler.physics.outlines import foot_radius
from ..compiler.physics.records import CONTACTS
from ..compiler.physics.safety import safety_of
from ..compiler.physics.statics import drives_of, met, wrenches
from ..compiler.physics.structure import structure
from .geometry.splines import ClampedSpline
from .plan import NO_LIMIT, STATICS, Plan
from .plan_forces import DriveRecord, HoldRecord, StaticsRecord, TorqueRecord, WeightRecord, WrenchRecord
from .skeleton import Array

TOLD = 24
"""Equal parts of a phase at whose ends a plan tells torques: between them they are straight within a hundredth."""
GROUP = 3
"""So many instants for each of them where what moves has inertia, `STEP` apart: accelerations come from differences."""
STEP = 1e-3
"""Seconds. With 96 instants spread over a phase instead, torques where accelerations bend were off by 0.07 of the
greatest, as drives with noise followed a plan, and by 0.02 in the plan."""
DIGITS = 6
"""Decimals in the file: a millionth of a newton or a newton metre."""


def with_statics(problem: ir.Problem, plan: Plan) -> Plan:
    """A plan with its weights, torques and loads, where its task asks for physics; else as it is."""
    if problem.options.physics in (None, "none") or not plan.phases:
        return plan
    torques, wrenches = list[TorqueRecord](), list[WrenchRecord]()
    for number in range(len(plan.phases) + 1):
        found = _forces(problem, plan, number)
        torques += found[0]
        wrenches += found[1]
    safety = safety_of(problem.options)
    told = StaticsRecord(_weights(problem), _drives(problem), torques, _holds(problem), wrenches, safety)
    return msgspec.structs.replace(plan, statics=told, needs=[*(n for n in plan.needs if n != STATICS), STATICS])


def _weights(problem: ir.Problem) -> list[WeightRecord]:
    found = [
        _weight(name, joint, weight)
        for name, module in problem.world.modules.items()
        for joint, weight in sorted(module_weights(module.type).items())
    ]
    movable = [(name, -1) for name, body in problem.world.bodies.items() if body.movable]
    return found + [_weight(*node, weight) for node, weight in node_weights(problem, movable).items()]


def _weight(name: str, joint: int, weight: Weight) -> WeightRecord:
    upper = weight.inertia[np.triu_indices(3)]
    return WeightRecord(name, joint, weight.mass, weight.centre.tolist(), upper.tolist())


def _drives(problem: ir.Problem) -> list[DriveRecord]:
    return [
        DriveRecord(name, joint.name, min(joint.torque, NO_LIMIT), min(joint.bearing, NO_LIMIT), joint.rotor,
                    joint.brake)
        for name, module in problem.world.modules.items()
        for joint in module.type.joints
    ]


def _holds(problem: ir.Problem) -> list[HoldRecord]:
    ends = {f"{m.name}.{e.name}": e.holds for m in problem.world.modules.values() for e in m.type.effectors}
    owners = ends | {name: body.holds for name, body in problem.world.bodies.items()}
    return [
        HoldRecord(name, h.manner, *(min(v, NO_LIMIT) for v in (h.force, h.shear, h.moment, h.twist, h.friction)))
        for name, holds in owners.items() for h in holds
    ]  # fmt: skip


def _forces(problem: ir.Problem, plan: Plan, number: int) -> tuple[list[TorqueRecord], list[WrenchRecord]]:
    """The torques of the drives in a phase, and what pairs bear; of the state after the last phase at rest."""
    last = number == len(plan.phases)
    record = plan.phases[-1 if last else number]
    held = plan.final_mode if last else record.mode
    built = structure(problem, frozenset((m.predicate, *m.args) for m in held))
    moving = problem.options.physics == "dynamics" and not last
    times = np.array([record.end]) if last else np.linspace(record.start, record.end, TOLD + 1)
    at, middle = placed(problem, plan, number, times, moving=moving)
    borne = wrenches(problem, built, at, safety_of(problem.options))
    given = {joint: rows[middle] for joint, rows in drives_of(problem, built, at, borne).items()}
    torques, pairs = [], []
    for name, module in problem.world.modules.items():
        own = [given.get((name, index), np.zeros(len(times))) for index in range(len(module.type.joints))]
        rows = _rows(own)
        if np.isfinite(rows).all() and any((name, index) in given for index in range(len(own))):
            torques.append(TorqueRecord(name, number, rows.tolist()))
    for edge, (force, moment) in zip(built.all, borne, strict=True):
        if edge.is_joint:
            continue
        rows = _rows(np.hstack(met(problem, edge, at, force, moment))[middle].T)
        if np.isfinite(rows).all():
            kept = rows[:1] if (rows == rows[0]).all() else rows
            stands = edge.manner in CONTACTS and edge.place not in problem.world.modules
            radius = foot_radius(problem, edge.place) if stands else 0.0
            first, second = edge.names
            pairs.append(WrenchRecord([second, first], edge.manner, edge.place, radius, number, kept.tolist()))
    return torques, pairs


def _around(times: Array, start: float, end: float) -> Array:
    """Groups of instants around those given; at the ends of a phase, where all rests, just inside."""
    step = min(STEP, (end - start) / (2 * GROUP))
    inner = np.clip(times, start + step, end - step)
    return np.asarray((inner[:, None] + step * (np.arange(GROUP) - GROUP // 2)).ravel())


def _rows(columns: Sequence[Array] | Array) -> Array:
    return np.round(np.stack(list(columns), axis=1), DIGITS) + 0.0 if len(columns) else np.zeros((0, 0))


def torques_at(plan: Plan, number: int) -> tuple[Array, dict[tuple[str, int], Array]] | None:
    """The times and the torques, by module and joint, that a plan tells of a phase; None where it tells none."""
    if isinstance(plan.statics, msgspec.UnsetType):
        return None
    rows = {t.module: np.asarray(t.values) for t in plan.statics.torques if t.phase == number}
    if not rows:
        return None
    phase, count = plan.phases[min(number, len(plan.phases) - 1)], len(next(iter(rows.values())))
    told = {(name, index): column for name, values in rows.items() for index, column in enumerate(values.T)}
    return np.linspace(phase.end if number == len(plan.phases) else phase.start, phase.end, count), told


def placed(problem: ir.Problem, plan: Plan, number: int, at: Array, *, moving: bool) -> tuple[Poses, slice]:
    """Where everything is at times of a phase, or after the last one, and which samples are at these: joints on their
    splines, poses on the splines through their samples. What is `moving` has inertia: its samples come in groups."""
    record = plan.phases[min(number, len(plan.phases) - 1)]
    start, end = (record.end if number >= len(plan.phases) else record.start), record.end
    group = GROUP if moving and end > start else 1
    times = _around(at, start, end) if group > 1 else at
    own = np.asarray(plan.times)
    inside = (own >= start - 1e-9) & (own <= end + 1e-9)
    first, last = span_of(plan, number)
    inside[:first], inside[last:] = False, False
    stamps, keep = np.unique(own[inside], return_index=True)
    curves = {
        s.module: ClampedSpline(s.knots, s.values)
        for s in plan.splines if s.first <= number <= s.until and s.values and s.values[0]
    }  # fmt: skip
    samples = first + keep
    modules = {}
    for track in plan.tracks:
        rows = np.asarray(track.joints[first], dtype=float)
        joints = curves[track.name](times) if track.name in curves else np.tile(rows, (len(times), 1))
        modules[track.name] = np.hstack([_smooth(stamps, np.asarray(track.poses)[samples], times), joints])
    bodies = {b.name: np.repeat(np.array([b.pose]), len(times), axis=0) for b in plan.bodies}
    for piece in plan.body_tracks:
        if piece.first <= first:
            at = np.clip(samples - piece.first, 0, len(piece.poses) - 1)
            bodies[piece.name] = _smooth(stamps, np.asarray(piece.poses)[at], times)
    found = poses(problem, modules, bodies, *((times, group) if group > 1 else ()))
    return found, slice(group // 2, None, group)


def span_of(plan: Plan, number: int) -> tuple[int, int]:
    """The first sample of a phase, and the one after its last; behind the last phase, the last sample."""
    switches = [i for i in range(1, len(plan.times)) if plan.times[i] == plan.times[i - 1]]
    starts = [0, *switches, len(plan.times)]
    if number >= len(plan.phases):
        return len(plan.times) - 1, len(plan.times)
    return starts[number], starts[number + 1]


def _smooth(stamps: Array, rows: Array, times: Array) -> Array:
    if len(stamps) < 2:
        return np.repeat(rows[:1], len(times), axis=0)
    return ClampedSpline(stamps, rows)(times)
