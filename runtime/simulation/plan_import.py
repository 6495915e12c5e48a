"""A plan file as the first window of a run, in a world that may not be as the plan has it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...compiler import ir
from ..geometry.splines import ClampedSpline
from ..plan import PhaseRecord, Plan, SplineRecord
from ..skeleton import Array, PhasePath
from ..tracks import body_rows
from .planning import Window, replayed
from .settings import SIMULATION


def window_of(problem: ir.Problem, plan: Plan) -> Window:
    """All phases of a plan of `problem`. Raises Inapplicable when the plan does not follow the rules."""
    skeleton = replayed(problem, plan.phases, lambda stepper, facts, p: stepper.action(facts, p.rule, p.args))
    paths = [_path(plan, index) for index in range(len(plan.phases))]
    return Window(problem, tuple(p.action for p in skeleton.phases), skeleton, paths, frozenset())


def _path(plan: Plan, index: int) -> PhasePath:
    phase = plan.phases[index]
    splines = {s.module: s for s in plan.splines if s.first <= index <= s.until}
    count = max((_pieces(s, phase) for s in splines.values()), default=SIMULATION.rest_pieces)
    knots = np.linspace(phase.start, phase.end, count + 1)
    modules: dict[str, Array] = {}
    for track in plan.tracks:
        poses = _at(plan, track.poses, knots)
        spline = splines.get(track.name)
        if spline is None:
            joints = np.tile(_at(plan, track.joints, knots[:1]), (len(knots), 1))
        else:
            joints = ClampedSpline(np.asarray(spline.knots), np.asarray(spline.values))(knots)
        modules[track.name] = np.hstack([poses, joints.reshape(len(poses), -1)])
    bodies = {name: _at(plan, rows, knots) for name, rows in body_rows(plan).items()}
    return PhasePath(modules, bodies, phase.end - phase.start)


def _pieces(spline: SplineRecord, phase: PhaseRecord) -> int:
    """How many of its pieces a spline has in a phase."""
    share = (phase.end - phase.start) / (spline.knots[-1] - spline.knots[0])
    return max(1, round(share * (len(spline.knots) - 1)))


def _at(plan: Plan, rows: Sequence[Sequence[float]], knots: Array) -> Array:
    """Rows of a track at some times."""
    table = np.asarray(rows)
    near = np.searchsorted(np.asarray(plan.times), knots - 1e-9)
    return np.asarray(table[np.clip(near, 0, len(table) - 1)])
