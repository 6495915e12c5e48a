"""The engine beside a run that plans on the way: what is known of its motions is told bit by bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ...compiler import ir
from ...compiler.physics.frames import Poses, poses
from ...compiler.physics.safety import safety_of
from ...compiler.physics.statics import drives
from ..skeleton import Array, Configuration
from .actor import Actor, DriveCommands, Simulated, fastened
from .conditions import Conditions
from .model import STEP

EXPECTED = 60
"""Instants of a motion for which the torques of drives are computed ahead."""
FAR = 0.02
"""Metres that things may be elsewhere than where the run has them: what a foot on a step forgives."""
HELD = 0.5
"""Seconds for which the end is held."""
Joints = Callable[[Array, int], Mapping[str, Array]]
"""Joint values `(T, n)` of all modules at times since the start of a motion, or their derivatives of an order."""


class LiveEngine:
    """The scene of a problem in the engine. Raises MissingLibrary."""

    def __init__(self, problem: ir.Problem, seed: int) -> None:
        self._problem = problem
        self._actor = Actor(problem, fastened(problem, problem.init_motion), Conditions(seed=seed))

    @property
    def result(self) -> Simulated:
        """What came of it so far."""
        return self._actor.result

    @property
    def joints(self) -> dict[str, Array]:
        """Where the joints are, `(n,)` of each module."""
        values = self._actor.world.data.qpos[self._actor.places]
        return self._by_module(values)

    def _by_module(self, values: Array) -> dict[str, Array]:
        owners = [name for name, _ in self._actor.world.joints]
        return {
            name: values[..., [k for k, owner in enumerate(owners) if owner == name]]
            for name in self._problem.world.modules
        }

    def follow(
        self, mode: frozenset[ir.Fact], begin: float, duration: float, joints: Joints,
        posed: Callable[[Array], Poses],
    ) -> tuple[Array, dict[str, Array]]:  # fmt: skip
        """Carry out a motion while a mode holds. Seconds `(T,)` since its start, and where the joints were at them
        `(T, n)`; up to where the simulation broke down, if it did."""
        edges = fastened(self._problem, mode)
        self._actor.extend(edges)
        self._actor.switch(edges)
        count = max(1, round(duration / STEP))
        since = np.minimum(STEP * np.arange(1, count + 1), duration)
        ahead = np.linspace(0.0, duration, EXPECTED + 1)
        torques = drives(self._problem, mode, posed(ahead), safety_of(self._problem.options))
        extra = np.zeros((count, len(self._actor.world.joints)))
        for k, key in enumerate(self._actor.world.joints):
            if key in torques and np.isfinite(torques[key]).all():
                extra[:, k] = np.interp(since, ahead, torques[key])
        told = DriveCommands(begin + since, self._stacked(joints(since, 0)), self._stacked(joints(since, 1)), extra)
        first = self._actor.world.data.qpos[self._actor.places].copy()
        driven = self._actor.move(told, edges)
        rows = np.vstack([first[None], told.values if driven is None else driven])
        return np.concatenate([[0.0], since]), self._by_module(rows)

    def _stacked(self, values: Mapping[str, Array]) -> Array:
        return np.hstack([values[name] for name in self._problem.world.modules])

    def trouble(self, there: Configuration) -> tuple[str, str] | None:
        """Why a run cannot go on: a code and a sentence, where something gave way, the simulation broke down, or a
        thing is elsewhere than `there`; else notes how far things are off."""
        result = self.result
        if result.diverged is not None:
            return "S0013", f"the simulation broke down at {result.diverged:.2f} s"
        if result.broken:
            time, what, ratio = result.broken[0]
            return "S0016", f"{what} gave way at {time:.2f} s, under {ratio:.2f} times what holds"
        movable = [name for name, body in self._problem.world.bodies.items() if body.movable]
        offs = {name: self._actor.off((name, -1), rows[:3]) for name, rows in there.modules.items()}
        result.base = max([result.base, *offs.values()])
        offs |= {name: self._actor.off((name, -1), there.bodies[name][:3]) for name in movable}
        worst = max(offs, key=lambda name: offs[name])
        if offs[worst] > FAR:
            return "S0016", f"{worst} is {100 * offs[worst]:.1f} cm from where the run has it at {result.seconds:.2f} s"
        return None

    def hold(self, mode: frozenset[ir.Fact], there: Configuration) -> tuple[str, str] | None:
        """Hold what the last action leaves for a while; what is wrong then, as of `trouble`."""
        def joints(times: Array, order: int) -> Mapping[str, Array]:
            rest = {name: np.tile(rows[7:], (len(times), 1)) for name, rows in there.modules.items()}
            return rest if order == 0 else {name: np.zeros_like(rows) for name, rows in rest.items()}

        def posed(times: Array) -> Poses:
            modules = {n: np.tile(rows, (len(times), 1)) for n, rows in there.modules.items()}
            return poses(self._problem, modules, {n: np.tile(r, (len(times), 1)) for n, r in there.bodies.items()})

        self.follow(mode, self.result.seconds, HELD, joints, posed)
        return self.trouble(there)
