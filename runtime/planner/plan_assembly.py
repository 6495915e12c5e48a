"""From actions, skeleton and phase motions to a self-contained plan file."""

from __future__ import annotations

import hashlib
import math
import platform
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Protocol

import numpy as np
from msgspec import structs

from ... import __version__
from ...compiler import ir
from ...compiler.printing_terms import format_formula
from ...langs.source import Span
from .. import plan as record
from ..feed_forward import with_statics
from ..geometry.resampling import Resampled, resample_all
from ..native import MissingLibrary, load_native, load_part
from ..skeleton import Array, Phase, PhasePath, Skeleton, start_configuration
from .motion.settings import ACCEPTANCE
from .search.stepper import Stepper

DIGITS = 10
"""Decimals of metres, radians and seconds in the file."""
ROUNDING = 1e-9
"""A body whose pose changes by less than this rests."""
Places = Mapping[ir.Fact, Span | None]
"""Where literals are written."""
LIBRARIES = {"numpy": "numpy", "casadi": "casadi", "pinocchio": "pin", "coal": "coal"}
"""Compiled libraries, and the Python packages that bring them; besides SciPy, of which only parts are loaded."""


class SampledMotion(Protocol):
    """One phase as it moves: `times` `(T,)` since the start, per module poses `(T, 7)` and joints `(T, n)`, per moving
    body poses `(T, 7)`."""

    @property
    def times(self) -> Array: ...
    @property
    def poses(self) -> dict[str, Array]: ...
    @property
    def joints(self) -> dict[str, Array]: ...
    @property
    def bodies(self) -> dict[str, Array]: ...


def assemble(
    problem: ir.Problem,
    actions: Sequence[ir.Action],
    skeleton: Skeleton,
    paths: Sequence[PhasePath],
    statistics: record.StatisticsRecord,
) -> record.Plan:
    """The plan file of a solved skeleton: one path per action. Raises MissingLibrary."""
    motions = _resampled(problem, skeleton, paths)
    phases = phase_records(problem, actions, skeleton, motions)
    final_mode = literal_records(problem, skeleton.final_mode, {})
    return plan_of(problem, motions, splines_of(problem.world, motions, paths), phases, final_mode, statistics)


def plan_of(
    problem: ir.Problem, motions: Sequence[SampledMotion], splines: list[record.SplineRecord],
    phases: list[record.PhaseRecord], final_mode: list[record.LiteralRecord], statistics: record.StatisticsRecord,
) -> record.Plan:  # fmt: skip
    """The plan file of phases with their motions, one after the other, and their splines."""
    world = problem.world
    moved = set[str]().union(*(m.bodies for m in motions))
    plain = record.Plan(
        format=record.FORMAT,
        versions=_versions(),
        task=_task_record(problem),
        modules=[module_record(m) for m in world.modules.values()],
        bodies=[_body_record(b) for b in world.bodies.values()],
        phases=phases,
        final_mode=final_mode,
        times=_rounded_row(np.concatenate([m.times for m in motions])) if motions else [0.0],
        tracks=[_track(m, motions) for m in world.modules.values()],
        body_tracks=[piece for b in world.bodies.values() if b.name in moved for piece in _body_tracks(b, motions)],
        splines=splines,
        statistics=statistics,
        needs=_needs(world),
    )
    return with_statics(problem, plain)


def scene_at_rest(
    problem: ir.Problem, statistics: record.StatisticsRecord, timing: record.TimingRecord
) -> record.Plan:
    """What can be drawn of a solve that found nothing: the scene at the start, and what the search did. It claims
    nothing, and no verifier was asked."""
    mode = literal_records(problem, problem.init_motion, {})
    plan = plan_of(problem, [], [], [], mode, statistics)
    return structs.replace(plan, complete=False, timing=timing)


def _needs(world: ir.World) -> list[str]:
    """The optional parts of the format that the plan makes use of."""
    joints = [j for m in world.modules.values() for j in m.type.joints]
    follows, passive = any(j.follows is not None for j in joints), any(j.passive for j in joints)
    jerk, places = any(math.isfinite(j.jerk) for j in joints), any(not b.collides for b in world.bodies.values())
    told = [(record.COUPLINGS, follows), (record.PASSIVE, passive), (record.JERK, jerk), (record.PLACES, places)]
    ends = [e.shape for m in world.modules.values() for e in m.type.effectors if e.shape is not None]
    told.append((record.PARTS, any(s.parts for s in (*ends, *(b.shape for b in world.bodies.values())))))
    return [need for need, has in told if has]


def _versions() -> dict[str, str]:
    """What made the plan: tamplang, Python and the libraries that can be loaded."""
    found = {"tamplang": __version__, "python": platform.python_version()}
    for name, package in LIBRARIES.items():
        with suppress(MissingLibrary):
            found[name] = load_native(name, package).__version__
    with suppress(MissingLibrary):
        part = load_part("scipy", "version")
        found["scipy"] = load_native("scipy", "scipy").__version__ if part is None else part.version
    return found


# --- the motion --------------------------------------------------------------------------------------------------


def _resampled(problem: ir.Problem, skeleton: Skeleton, paths: Sequence[PhasePath]) -> list[Resampled]:
    modes, start = [phase.mode for phase in skeleton.phases], start_configuration(problem)
    return resample_all(problem, modes, paths, start, ACCEPTANCE.stored_density)


def _rounded_row(values: np.typing.NDArray[np.float64]) -> list[float]:
    rounded: list[float] = np.round(values, DIGITS).tolist()
    return rounded


def _rounded_rows(values: np.typing.NDArray[np.float64]) -> list[list[float]]:
    rounded: list[list[float]] = np.round(values, DIGITS).tolist()
    return rounded


def _track(module: ir.Module, motions: Sequence[SampledMotion]) -> record.TrackRecord:
    poses = [m.poses[module.name] for m in motions] or [np.array([module.pose])]
    joints = [m.joints[module.name] for m in motions] or [np.array([module.joints])]
    return record.TrackRecord(module.name, _rounded_rows(np.vstack(poses)), _rounded_rows(np.vstack(joints)))


def _body_tracks(body: ir.Body, motions: Sequence[SampledMotion]) -> list[record.BodyTrackRecord]:
    """One piece for every row of phases in which the body moves."""
    pieces: list[record.BodyTrackRecord] = []
    sample, last = 0, list(body.pose)
    for motion in motions:
        rows = _rounded_rows(motion.bodies[body.name]) if body.name in motion.bodies else []
        if any(not np.allclose(row, last, rtol=0.0, atol=ROUNDING) for row in rows):
            if pieces and pieces[-1].first + len(pieces[-1].poses) == sample:
                pieces[-1].poses.extend(rows)
            else:
                pieces.append(record.BodyTrackRecord(body.name, sample, rows))
            last = rows[-1]
        sample += len(motion.times)
    return pieces


def splines_of(
    world: ir.World, motions: Sequence[SampledMotion], paths: Sequence[PhasePath]
) -> list[record.SplineRecord]:
    """A spline for every phase in which joints of a module move."""
    result = []
    for index, (motion, path) in enumerate(zip(motions, paths, strict=True)):
        for name in world.modules:
            values = _rounded_rows(path.modules[name][:, 7:])
            if any(row != values[0] for row in values):
                knots = np.linspace(motion.times[0], motion.times[-1], len(values))
                result.append(record.SplineRecord(name, index, index, _rounded_row(knots), values))
    return result


# --- the task ----------------------------------------------------------------------------------------------------


def _task_record(problem: ir.Problem) -> record.TaskRecord:
    sources = [
        record.SourceRecord(problem.called(s.path), s.text, hashlib.sha256(s.text.encode()).hexdigest())
        for s in problem.sources
    ]
    files = [
        record.FileRecord(path, data, hashlib.sha256(data).hexdigest())
        for path, data in sorted((problem.called(path), data) for path, data in problem.files.items())
    ]
    return record.TaskRecord(
        problem.task, problem.called(problem.file), dict(problem.parameters), problem.seed, sources,
        format_formula(problem.goal), files,
    )  # fmt: skip


def _shape(shape: ir.Shape) -> record.ShapeRecord:
    parts = [record.PartRecord(list(part.at), _shape(part.shape)) for part in shape.parts]
    return record.ShapeRecord(shape.kind, list(shape.size), parts)


def _bounded(value: float) -> float:
    return min(max(value, -record.NO_LIMIT), record.NO_LIMIT)


def module_record(module: ir.Module) -> record.ModuleRecord:
    """A module as the plan file holds it."""
    joints = [
        record.JointRecord(
            j.name, j.kind, j.parent, list(j.placement), list(j.axis),
            _bounded(j.lower), _bounded(j.upper), _bounded(j.speed), _bounded(j.acceleration),
            None if j.follows is None else record.CouplingRecord(j.follows.leader, j.follows.factor, j.follows.offset),
            j.passive, _bounded(j.jerk),
        )
        for j in module.type.joints
    ]  # fmt: skip
    effectors = [
        record.EffectorRecord(e.name, e.joint, list(e.placement), None if e.shape is None else _shape(e.shape))
        for e in module.type.effectors
    ]
    links = [record.LinkRecord(k.joint, list(k.placement), _shape(k.shape)) for k in module.type.links]
    return record.ModuleRecord(
        module.name, module.type.name, joints, effectors, links, list(module.pose), list(module.joints)
    )


def _body_record(body: ir.Body) -> record.BodyRecord:
    return record.BodyRecord(body.name, body.type, _shape(body.shape), list(body.pose), body.movable, body.collides)


def placed(problem: ir.Problem, span: Span | None) -> record.PlaceRecord | None:
    """The record of a place in a source of the problem."""
    return None if span is None else record.PlaceRecord(problem.called(span.file), span.line, span.column)


# --- the phases --------------------------------------------------------------------------------------------------


def phase_records(
    problem: ir.Problem, actions: Sequence[ir.Action], skeleton: Skeleton, motions: Sequence[Resampled]
) -> list[record.PhaseRecord]:
    """The phases of actions with their motions, from the start on."""
    stepper = Stepper(problem)
    facts, mode = problem.init, problem.init_motion
    places: dict[ir.Fact, Span | None] = {}
    result = []
    for action, phase, motion in zip(actions, skeleton.phases, motions, strict=True):
        step = stepper.effects(facts, mode, action)
        after = {**places, **step.places}
        result.append(phase_record(problem, phase, motion, stepper.fluents(facts), places, after))
        facts, mode, places = step.facts, step.motion, after
    return result


def phase_record(
    problem: ir.Problem, phase: Phase, motion: SampledMotion, facts: frozenset[ir.Fact], before: Places, after: Places,
    completed: bool = True,
) -> record.PhaseRecord:  # fmt: skip
    """A phase as the plan file holds it. `before` and `after` tell where the literals that hold during it and those
    that it adds are written."""
    action = phase.action
    rule = problem.rules.get(action.rule)
    return record.PhaseRecord(
        action=str(action),
        rule=action.rule,
        args=[str(a) for a in action.args],
        place=placed(problem, rule.span) if rule else None,
        start=round(float(motion.times[0]), DIGITS),
        end=round(float(motion.times[-1]), DIGITS),
        literals=literal_records(problem, facts, before),
        mode=literal_records(problem, phase.mode, before),
        added=literal_records(problem, phase.added, after),
        completed=completed,
    )


def literal_records(
    problem: ir.Problem, facts: frozenset[ir.Fact], places: Places
) -> list[record.LiteralRecord]:
    """Literals in alphabetical order, each with the effect that added it, or else its declaration, as its place."""
    result = []
    for fact in sorted(facts):
        span = places.get(fact)
        if span is None:
            declared = problem.motions.get(fact[0]) or problem.predicates.get(fact[0])
            span = declared.span if declared is not None else None
        result.append(record.LiteralRecord(fact[0], list(fact[1:]), placed(problem, span)))
    return result
