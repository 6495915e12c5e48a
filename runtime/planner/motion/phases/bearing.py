"""Loads at rest of phases that are open chains, over their joint values: what paths give way to where something is too
heavily loaded on the way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .....compiler.distinct import distinct
from .....compiler.ir import Fact, Problem
from .....compiler.physics.frames import Poses, poses
from .....compiler.physics.safety import safety_of
from .....compiler.physics.statics import loads
from ....skeleton import Array, Configuration
from ...statics import kept_at_rest
from ...statics.settings import STATICS
from .batch_kinematics import Indices
from .joint_forest import PhaseTree
from .mounted import placed
from .settings import PHASES


class PhaseLoads:
    """The ratios of load, times the safety, to strength in one phase, whose joint values are `(times, joints)`."""

    def __init__(self, problem: Problem, mode: frozenset[Fact], tree: PhaseTree, before: Configuration) -> None:
        self._problem, self._mode, self._tree, self._before = problem, mode, tree, before
        self._safety = safety_of(problem.options)

    def borne(self, values: Array) -> bool:
        """Whether all strengths are kept at all times."""
        worst = float(self._ratios(values, self._poses(values)).max(initial=0.0))
        return worst <= kept_at_rest(self._problem)

    def missed(self, values: Array) -> tuple[Indices, Array, Array]:
        """Of every row that is beyond its share of a strength: the time, the excess as metres, and how fast joints
        change that `(rows, joints)`."""
        at = self._poses(values)
        ratios = self._ratios(values, at)
        time, row = np.nonzero(ratios > STATICS.room)
        times, joints = distinct(time), values.shape[1]
        if not len(times):
            return time, np.zeros(0), np.zeros((0, joints))
        varied = values[times][:, None] + PHASES.load_difference * np.eye(joints)
        varied = varied.reshape(-1, joints)
        beside = self._ratios(varied, replace(self._poses(varied), moved=at.moved))
        change = beside.reshape(len(times), joints, -1) - ratios[times][:, None]
        slope = change[np.searchsorted(times, time), :, row] / PHASES.load_difference
        excess = ratios[time, row] - STATICS.room
        return time, PHASES.load_scale * excess, PHASES.load_scale * slope

    def _poses(self, values: Array) -> Poses:
        modules, bodies = placed(self._tree, values, self._before, self._problem.world)
        still = {name: np.repeat(pose[None], len(values), axis=0) for name, pose in self._before.bodies.items()}
        return poses(self._problem, modules, still | bodies)

    def _ratios(self, values: Array, at: Poses) -> Array:
        found = [load.ratio for load in loads(self._problem, self._mode, at, self._safety)]
        return np.stack(found, axis=1) if found else np.zeros((len(values), 0))
