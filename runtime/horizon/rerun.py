"""A plan file as the first window of a run, in a world that may not be as the plan has it."""

from __future__ import annotations

import numpy as np

from ...compiler import ir
from ..plan import Plan
from ..skeleton import Array, PhasePath
from .planning import Window, replayed


def window_of(problem: ir.Problem, plan: Plan) -> Window:
    """All phases of a plan of `problem`. Raises ReplayError when the plan does not follow the rules."""
    skeleton = replayed(problem, plan.phases, lambda interpreter, facts, p: interpreter.action(facts, p.rule, p.args))
    paths = [_path(plan, index) for index in range(len(plan.phases))]
    return Window(problem, tuple(p.action for p in skeleton.phases), skeleton, paths, frozenset())


def _path(plan: Plan, index: int) -> PhasePath:
    phase = plan.phases[index]
    modules: dict[str, Array] = {}
    for spline in plan.splines:
        if spline.phase == index:
            poses = _at(plan, next(t.poses for t in plan.tracks if t.name == spline.module), spline.knots)
            modules[spline.module] = np.hstack([poses, np.asarray(spline.values).reshape(len(poses), -1)])
    knots = next(s.knots for s in plan.splines if s.phase == index)
    bodies = {track.name: _at(plan, track.poses, knots) for track in plan.body_tracks}
    return PhasePath(modules, bodies, phase.end - phase.start)


def _at(plan: Plan, poses: list[list[float]], knots: list[float]) -> Array:
    """Poses `(S + 1, 7)` of a track at some times."""
    rows = np.asarray(poses)
    near = np.searchsorted(np.asarray(plan.times), np.asarray(knots) - 1e-9)
    return np.asarray(rows[np.clip(near, 0, len(rows) - 1)])
