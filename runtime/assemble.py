"""From actions, skeleton and phase motions to a self-contained plan file."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from collections.abc import Mapping, Sequence

import numpy as np

from .. import __version__
from ..compiler import ir
from ..compiler.printing_terms import format_formula
from ..langs.source import Span
from . import plan as record
from .resampling import Resampled, resample
from .skeleton import PhasePath, Skeleton, start_configuration
from .verify.findings import place_of
from .verify.formulas import ReplayError
from .verify.replay import Interpreter

FACTOR = 5
"""Samples of the plan file per sample of the planner."""
DIGITS = 10
"""Decimals of metres, radians and seconds in the file."""
PACKAGES = ("numpy", "casadi", "pin", "coal", "scipy")


def assemble(
    problem: ir.Problem,
    actions: Sequence[ir.Action],
    skeleton: Skeleton,
    paths: Sequence[PhasePath],
    statistics: record.StatisticsRecord,
) -> record.Plan:
    """The plan file of a solved skeleton: one path per action. Raises MissingLibrary."""
    motions = _resampled(problem, skeleton, paths)
    phases = _phases(problem, actions, skeleton, motions)
    start = start_configuration(problem)
    moving = [b for b in problem.world.bodies if any(b in m.bodies for m in motions)]
    return record.Plan(
        format=record.FORMAT,
        versions=versions(),
        task=task_record(problem),
        modules=[module_record(m) for m in problem.world.modules.values()],
        bodies=[body_record(b) for b in problem.world.bodies.values()],
        phases=phases,
        final_mode=literal_records(problem, skeleton.final_mode, {}),
        times=rounded_row(np.concatenate([m.times for m in motions])) if motions else [0.0],
        tracks=[_track(m, motions) for m in problem.world.modules.values()],
        body_tracks=[_body_track(b, start.bodies[b], motions) for b in moving],
        splines=_splines(skeleton, paths),
        statistics=statistics,
    )


def versions() -> dict[str, str]:
    """What made the plan: tamplang, Python and the libraries that are installed."""
    found = {"tamplang": __version__, "python": platform.python_version()}
    for package in PACKAGES:
        try:
            found["pinocchio" if package == "pin" else package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


# --- the motion --------------------------------------------------------------------------------------------------


def _resampled(problem: ir.Problem, skeleton: Skeleton, paths: Sequence[PhasePath]) -> list[Resampled]:
    now, begin = start_configuration(problem), 0.0
    result = []
    for phase, path in zip(skeleton.phases, paths, strict=True):
        result.append(resample(problem, phase.mode, path, now, begin, FACTOR))
        now, begin = result[-1].end(now), float(result[-1].times[-1])
    return result


def rounded_row(values: np.typing.NDArray[np.float64]) -> list[float]:
    rounded: list[float] = np.round(values, DIGITS).tolist()
    return rounded


def rounded_rows(values: np.typing.NDArray[np.float64]) -> list[list[float]]:
    rounded: list[list[float]] = np.round(values, DIGITS).tolist()
    return rounded


def _track(module: ir.Module, motions: Sequence[Resampled]) -> record.TrackRecord:
    poses = [m.poses[module.name] for m in motions] or [np.array([module.pose])]
    joints = [m.joints[module.name] for m in motions] or [np.array([module.joints])]
    return record.TrackRecord(module.name, rounded_rows(np.vstack(poses)), rounded_rows(np.vstack(joints)))


def _body_track(
    name: str, pose: np.typing.NDArray[np.float64], motions: Sequence[Resampled]
) -> record.BodyTrackRecord:
    """A body rests, between the phases that move it, where the last of them left it."""
    rows = []
    for motion in motions:
        poses = motion.bodies.get(name)
        if poses is None:
            poses = np.broadcast_to(pose, (len(motion.times), 7))
        rows.append(poses)
        pose = poses[-1]
    return record.BodyTrackRecord(name, rounded_rows(np.vstack(rows)))


def _splines(skeleton: Skeleton, paths: Sequence[PhasePath]) -> list[record.SplineRecord]:
    begin, result = 0.0, []
    for index, path in enumerate(paths):
        for name in skeleton.problem.world.modules:
            values = path.modules[name][:, 7:]
            knots = begin + np.linspace(0.0, path.duration, len(values))
            result.append(record.SplineRecord(name, index, rounded_row(knots), rounded_rows(values)))
        begin += path.duration
    return result


# --- the task ----------------------------------------------------------------------------------------------------


def task_record(problem: ir.Problem) -> record.TaskRecord:
    sources = [
        record.SourceRecord(s.path, s.text, hashlib.sha256(s.text.encode()).hexdigest()) for s in problem.sources
    ]
    return record.TaskRecord(
        problem.task, problem.file, dict(problem.parameters), problem.seed, sources, format_formula(problem.goal)
    )


def _shape(shape: ir.Shape) -> record.ShapeRecord:
    return record.ShapeRecord(shape.kind, list(shape.size))


def _bounded(value: float) -> float:
    return min(max(value, -record.NO_LIMIT), record.NO_LIMIT)


def module_record(module: ir.Module) -> record.ModuleRecord:
    """A module as the plan file holds it."""
    joints = [
        record.JointRecord(
            j.name, j.kind, j.parent, list(j.placement), list(j.axis),
            _bounded(j.lower), _bounded(j.upper), _bounded(j.speed), _bounded(j.acceleration),
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


def body_record(body: ir.Body) -> record.BodyRecord:
    return record.BodyRecord(body.name, body.type, _shape(body.shape), list(body.pose), body.movable)


# --- the phases --------------------------------------------------------------------------------------------------


def _phases(
    problem: ir.Problem, actions: Sequence[ir.Action], skeleton: Skeleton, motions: Sequence[Resampled]
) -> list[record.PhaseRecord]:
    interpreter = Interpreter(problem)
    facts, mode = problem.init, interpreter.canonical(problem.init_motion)
    places: dict[ir.Fact, Span | None] = {}
    previous: ir.Action | None = None
    result = []
    for action, phase, motion in zip(actions, skeleton.phases, motions, strict=True):
        shown = interpreter.fluents(facts)
        before = dict(places)
        try:
            outcome = interpreter.apply(facts, mode, action, previous)
        except (ReplayError, KeyError):
            after = facts
        else:
            after, mode = outcome.facts, outcome.motion
            places.update(outcome.places)
        rule = problem.rules.get(action.rule)
        result.append(
            record.PhaseRecord(
                action=str(action),
                rule=action.rule,
                args=[str(a) for a in action.args],
                place=place_of(rule.span) if rule else None,
                start=round(float(motion.times[0]), DIGITS),
                end=round(float(motion.times[-1]), DIGITS),
                literals=literal_records(problem, shown, before),
                mode=literal_records(problem, phase.mode, before),
                added=literal_records(problem, phase.added, places),
            )
        )
        facts, previous = after, action
    return result


def literal_records(
    problem: ir.Problem, facts: frozenset[ir.Fact], places: Mapping[ir.Fact, Span | None]
) -> list[record.LiteralRecord]:
    """Literals in alphabetical order, each with the effect that added it, or else its declaration, as its place."""
    result = []
    for fact in sorted(facts):
        span = places.get(fact)
        if span is None:
            declared = problem.motions.get(fact[0]) or problem.predicates.get(fact[0])
            span = declared.span if declared is not None else None
        result.append(record.LiteralRecord(fact[0], list(fact[1:]), place_of(span)))
    return result
