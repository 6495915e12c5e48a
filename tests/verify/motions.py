"""Motions of a crawler made by hand: joint values at knots, poses from the foot that stands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tamplang.compiler.ir import Action, Fact
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.geometry.resampling import resample
from tamplang.runtime.plan import Plan, StatisticsRecord
from tamplang.runtime.planner.plan_assembly import assemble
from tamplang.runtime.skeleton import Phase, PhasePath, Skeleton, start_configuration
from tamplang.runtime.verify.replay import Interpreter

SAMPLES = 20


def bent(angle: float) -> np.ndarray:
    """Joint values of an arch: both ends point down."""
    return np.array([0.0, angle, 0.0, np.pi - 2 * angle, 0.0, angle, 0.0])


def eased(knots: Sequence[np.ndarray], samples: int) -> np.ndarray:
    """Rows through the knots, slow at both ends."""
    rows = np.vstack(knots)
    ease = np.linspace(0.0, 1.0, samples + 1)
    ease = (3 * ease**2 - 2 * ease**3) * (len(rows) - 1)
    return np.column_stack([np.interp(ease, np.arange(len(rows)), column) for column in rows.T])


class Maker:
    """Collects phases of the task of that name."""

    def __init__(self, text: str, name: str) -> None:
        self.problem, _ = compile_text(text, f"{name}.tamp", name)
        self.interpreter = Interpreter(self.problem)
        self.facts, self.mode = self.problem.init, self.problem.init_motion
        self.now = start_configuration(self.problem)
        self.phases: list[Phase] = []
        self.paths: list[PhasePath] = []

    @staticmethod
    def tip(joints: np.ndarray, beyond: float) -> tuple[float, float, float]:
        """A point `beyond` metres past the end of a crawler that stands upright on the slab at the origin."""
        turn, point = np.eye(3), np.array([0.0, 0.0, 0.025 + 0.05])
        for index, value in enumerate(joints):
            c, s = np.cos(value), np.sin(value)
            about_z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
            turn = turn @ (about_y if index % 2 else about_z)
            length = (0.15, 0.175, 0.175, 0.175, 0.175, 0.15, beyond)[index]
            point = point + turn @ [0.0, 0.0, length]
        return tuple(point)

    def phase(
        self,
        rule: str,
        arguments: Sequence[str],
        knots: Sequence[np.ndarray],
        seconds: float = 4.0,
        samples: int = SAMPLES,
    ) -> None:
        """Take the module that the first argument names through joint values `knots`, then carry out the action."""
        mover = arguments[0].partition(".")[0]
        action = self.interpreter.action(self.facts, rule, arguments)
        outcome = self.interpreter.apply(self.facts, self.mode, action)
        carried = {f[2] for f in self.mode if f[0] == "stable" and f[2] in self.problem.world.bodies}
        path = PhasePath({}, {b: np.tile(self.now.bodies[b], (samples + 1, 1)) for b in carried}, seconds)
        for name, row in self.now.modules.items():
            joints = eased([row[7:], *knots], samples) if name == mover else np.tile(row[7:], (samples + 1, 1))
            path.modules[name] = np.hstack([np.tile(row[:7], (samples + 1, 1)), joints])
        dense = resample(self.problem, frozenset(self.mode), path, self.now, 0.0, 1)
        for name, rows in path.modules.items():
            rows[:, :7] = dense.poses[name]
        path.bodies.update(dense.bodies)
        self.phases.append(Phase(action, frozenset(self.mode), outcome.added_motion))
        self.paths.append(path)
        self.now = dense.end(self.now)
        self.facts, self.mode = outcome.facts, outcome.motion

    def skeleton(self) -> Skeleton:
        return Skeleton(self.problem, tuple(self.phases), frozenset[Fact](self.mode))

    def plan(self) -> Plan:
        actions: list[Action] = [p.action for p in self.phases]
        return assemble(self.problem, actions, self.skeleton(), self.paths, StatisticsRecord())
