"""A plan carried out: drives follow its splines with the torques that it expects."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np

from ...compiler import ir
from ...compiler.physics.safety import safety_of
from ...compiler.physics.statics import drives
from ..feed_forward import placed, torques_at
from ..geometry.splines import ClampedSpline
from ..plan import PhaseRecord, Plan
from ..skeleton import Array
from .actor import Actor, DriveCommands, Simulated, fastened
from .conditions import Conditions
from .model import STEP

EXPECTED = 60
"""Instants of a phase for which the torques of drives are computed ahead."""
FAR = 0.02
"""Metres that things may be elsewhere at the end, for the goal to count as reached: what a foot on a step forgives."""
HELD = 0.5
"""Seconds for which the end is held."""
LOST = 10.0
"""Metres: where nothing gave way, a module so far from where it should be has not just fallen."""


def carry_out(
    problem: ir.Problem, plan: Plan, tick: Callable[[], None] = lambda: None, conditions: Conditions | None = None
) -> Simulated:
    """Carry a plan out. `tick` is called before every phase, and may raise. Raises MissingLibrary, NoDisplay."""
    return _Playback(problem, plan, tick, conditions or Conditions()).run()


class _Playback:
    def __init__(self, problem: ir.Problem, plan: Plan, tick: Callable[[], None], conditions: Conditions) -> None:
        self.problem, self.plan, self.tick = problem, plan, tick
        held = [*(p.mode for p in plan.phases), plan.final_mode]
        self.modes = [frozenset((m.predicate, *m.args) for m in mode) for mode in held]
        self.edges = [fastened(problem, mode) for mode in self.modes]
        self.actor = Actor(problem, [pair for edges in self.edges for pair in edges], conditions)
        self.result = self.actor.result

    def run(self) -> Simulated:
        for number, record in enumerate(self.plan.phases):
            self.tick()
            self.actor.switch(self.edges[number])
            if not self._phase(number, record):
                return self.result
        if not self._settle():
            return self.result
        moved = {p.name for p in self.plan.body_tracks}
        off = max((self._off(m, -1) for m in self.problem.world.modules), default=0.0)
        off = max([off, *(self._body_off(name) for name in sorted(moved))])
        goal = self.plan.verdict is not None and self.plan.verdict.goal_reached
        self.result.reached = goal and not self.result.broken and off <= FAR
        return self.result

    def _settle(self) -> bool:
        """Hold what the last action leaves, for a while; whether that made sense."""
        if not self.plan.phases:
            return True
        end, last = self.result.seconds, self.plan.phases[-1]
        still = msgspec.structs.replace(last, start=end, end=end + HELD, mode=self.plan.final_mode)
        self.actor.switch(self.edges[len(self.plan.phases)])
        return self._phase(len(self.plan.phases), still)

    def _phase(self, number: int, record: PhaseRecord) -> bool:
        """Whether the phase was carried out without the simulation breaking down."""
        count = max(1, round((record.end - record.start) / STEP))
        times = np.minimum(record.start + STEP * np.arange(1, count + 1), record.end)
        if self.actor.move(self._told(number, record, times), self.edges[number]) is None:
            return False
        last = int(np.searchsorted(np.asarray(self.plan.times), record.end + 1e-9, side="right")) - 1
        for name in self.problem.world.modules:
            off = self._off(name, last)
            self.result.base = max(self.result.base, off)
            if off > LOST:
                self.result.diverged = None if self.result.broken else record.end
                return False
        return True

    def _off(self, name: str, sample: int) -> float:
        track = next(t for t in self.plan.tracks if t.name == name)
        return self.actor.off((name, -1), np.asarray(track.poses[sample][:3]))

    def _body_off(self, name: str) -> float:
        """How far a body is from where the plan leaves it."""
        last = [p for p in self.plan.body_tracks if p.name == name][-1].poses[-1]
        return self.actor.off((name, -1), np.asarray(last[:3]))

    def _curves(self, number: int) -> dict[str, ClampedSpline]:
        return {
            s.module: ClampedSpline(s.knots, s.values)
            for s in self.plan.splines
            if s.first <= number <= s.until and s.values and s.values[0]
        }

    def _rows(self, name: str, curves: dict[str, ClampedSpline], times: Array, number: int) -> Array:
        """Joint values `(T, n)` of a module in a phase."""
        if name in curves:
            return curves[name](times)
        track = next(t for t in self.plan.tracks if t.name == name)
        first = -1
        if number < len(self.plan.phases):
            begun = self.plan.phases[number].start + 1e-9
            first = int(np.searchsorted(np.asarray(self.plan.times), begun, side="right")) - 1
        return np.tile(np.asarray(track.joints[first]), (len(times), 1))

    def _expected(
        self, number: int, record: PhaseRecord
    ) -> tuple[Array, dict[tuple[str, int], Array]]:
        """The torques that the plan tells, or else those that it needs, at rest and by inertia, at some times of the
        phase."""
        told = torques_at(self.plan, number) if self.problem.options.physics == "dynamics" else None
        if told is not None:
            return told
        times = np.linspace(record.start, record.end, EXPECTED + 1)
        here, middle = placed(self.problem, self.plan, number, times, moving=True)
        given = drives(self.problem, self.modes[number], here, safety_of(self.problem.options))
        return times, {joint: torques[middle] for joint, torques in given.items()}

    def _told(self, number: int, record: PhaseRecord, times: Array) -> DriveCommands:
        """Where the joints should be at each step, how fast, and the torque that the plan expects."""
        curves = self._curves(number)
        ahead, torques = self._expected(number, record)
        values, rates, extra = [np.zeros((len(times), 0))], [np.zeros((len(times), 0))], []
        for name, module in self.problem.world.modules.items():
            own = self._rows(name, curves, times, number)
            values.append(own)
            rates.append(curves[name](times, 1) if name in curves else np.zeros_like(own))
            for index in range(len(module.type.joints)):
                torque = torques.get((name, index))
                extra.append(np.zeros(len(times)) if torque is None else np.interp(times, ahead, torque))
        more = np.stack(extra, axis=1) if extra else np.zeros((len(times), 0))
        return DriveCommands(times, np.hstack(values), np.hstack(rates), more)
