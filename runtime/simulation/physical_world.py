"""A world in which drives must carry what they move: joints go where a physics engine lets them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...compiler.physics.frames import Poses, poses
from ...langs.diagnostics import Diagnostic
from ..engine.actor import Simulated
from ..engine.live import LiveEngine
from ..geometry.transforms import coupled
from ..skeleton import Array, PhasePath
from .actuators import EXACT
from .world import Executed, Interval, SimulatedWorld, carried, sampled, spline_values


class GaveWay(Exception):
    """A run cannot go on, as something in the engine gave way; `diagnostic` says so."""

    def __init__(self, code: str, message: str) -> None:
        self.diagnostic = Diagnostic(code, message)
        super().__init__(message)


class PhysicalWorld(SimulatedWorld):
    """The simulated world whose drives miss what they are told by what the engine finds. Raises MissingLibrary."""

    def __init__(self, problem: ir.Problem, seed: int) -> None:
        super().__init__(problem, EXACT, seed)
        self._engine = LiveEngine(problem, seed)
        self._mode = problem.init_motion

    @property
    def result(self) -> Simulated:
        """What the engine found."""
        return self._engine.result

    def carry_out(self, interval: Interval, samples: int) -> Executed:
        """Let an interval take place. Raises GaveWay."""
        self._mode = interval.mode
        executed = super().carry_out(interval, samples)
        self._examine(self._engine.trouble(self.reached.configuration))
        return executed

    def rest(self) -> None:
        """Hold the end for a while. Raises GaveWay."""
        self._examine(self._engine.hold(self.reached.mode, self.reached.configuration))

    def _examine(self, trouble: tuple[str, str] | None) -> None:
        if trouble is not None:
            raise GaveWay(*trouble)

    def _errors(self, path: PhasePath, times: Array) -> dict[str, Array]:
        """How far joints are from where `path` has them at `times`, `(T, n)`, by what the engine does."""

        def joints(since: Array, order: int) -> Mapping[str, Array]:
            return {n: spline_values(rows[:, 7:], path.duration, since, order) for n, rows in path.modules.items()}

        def posed(since: Array) -> Poses:
            values = sampled(path, since)
            found = carried(self.problem, self._mode, values, self.reached.configuration, {}, path)
            modules = {n: np.hstack([_filled(found[n], len(since)), values[n]]) for n in self.problem.world.modules}
            bodies = {n: _filled(found[n], len(since)) for n in self.problem.world.bodies}
            return poses(self.problem, modules, bodies, since if path.duration > 0.0 else None)

        since, driven = self._engine.follow(self._mode, self.time, path.duration, joints, posed)
        wanted = sampled(path, times)
        errors = {}
        for name, rows in driven.items():
            own = [np.interp(times, since, column) for column in rows.T]
            off = np.stack(own, axis=1) - wanted[name] if own else np.zeros_like(wanted[name])
            first = path.modules[name][0, 7:]
            # A run puts right at switches what drives miss, the engine does not: what is left then fades.
            share = np.linspace(0.0, 1.0, len(times))[:, None]
            kept = self.reached.configuration.modules[name][7:] - first - off[0]
            off = off + (1.0 - 3.0 * share**2 + 2.0 * share**3) * kept
            errors[name] = coupled(self.problem.world.modules[name].type.joints, first + off) - first
        return errors


def _filled(rows: Array, count: int) -> Array:
    return rows if len(rows) == count else np.repeat(rows[:1], count, axis=0)
