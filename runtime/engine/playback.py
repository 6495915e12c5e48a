"""A plan carried out: drives follow its splines with the torques that it expects, clamped at what they give; kept pairs
are welds that break beyond their strength."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import msgspec
import numpy as np

from ...compiler import ir
from ...compiler.physics.frames import STILL, Poses, meeting, poses
from ...compiler.physics.safety import safety_of
from ...compiler.physics.statics import drives, loads_of
from ...compiler.physics.structure import WORLD, Edge, Node, structure
from ..feed_forward import placed, torques_at
from ..geometry.splines import ClampedSpline
from ..plan import PhaseRecord, Plan
from ..seeds import Seed
from ..skeleton import Array
from . import contacts, welds
from .conditions import Conditions, Watch
from .model import STEP, EngineWorld, build

EXPECTED = 60
"""Instants of a phase for which the torques of drives are computed ahead."""
FAR = 0.02
"""Metres that things may be elsewhere at the end, for the goal to count as reached: what a foot on a step forgives."""
SETTLED = 0.05
"""Seconds after a switch in which the blow of fastening does not count against a weld."""
LOOKED = 5
"""Every so many steps the welds are looked at."""
HELD = 0.5
"""Seconds for which the end is held."""
LOST = 10.0
"""Metres: a module that is so far from where it should be has not just fallen."""


@dataclass(slots=True)
class Simulated:
    """What came of a plan: `tracking` rad or m and `base` m, the worst of joints and of module frames; `droop` m, by
    how much welds gave; `peaks` the greatest torque of each drive and its strength; `broken` what broke, when, and by
    which ratio; `diverged` when the simulation stopped making sense."""

    seconds: float = 0.0
    tracking: float = 0.0
    base: float = 0.0
    droop: float = 0.0
    peaks: dict[tuple[str, str], tuple[float, float]] = field(default_factory=dict)
    loads: dict[tuple[str, str], float] = field(default_factory=dict)
    broken: list[tuple[float, str, float]] = field(default_factory=list)
    diverged: float | None = None
    reached: bool = False


def carry_out(
    problem: ir.Problem, plan: Plan, tick: Callable[[], None] = lambda: None, conditions: Conditions | None = None
) -> Simulated:
    """Carry a plan out. `tick` is called before every phase, and may raise. Raises MissingLibrary, NoDisplay."""
    return _Playback(problem, plan, tick, conditions or Conditions()).run()


class _Playback:
    def __init__(self, problem: ir.Problem, plan: Plan, tick: Callable[[], None], conditions: Conditions) -> None:
        self.problem, self.plan, self.tick, self.conditions = problem, plan, tick, conditions
        held = [*(p.mode for p in plan.phases), plan.final_mode]
        self.modes = [frozenset((m.predicate, *m.args) for m in mode) for mode in held]
        self.edges = [self._fastened(mode) for mode in self.modes]
        pairs = [pair for edges in self.edges for pair in edges]
        self.world: EngineWorld = build(problem, pairs, conditions.noise, Seed(conditions.seed))
        self.standing: dict[tuple[Node, Node], contacts.Foothold] = {}
        self.watch = Watch(self.world) if conditions.view else None
        self.result = Simulated()
        self.dead: set[tuple[Node, Node]] = set()
        rows = np.array(list(self.world.joints.values()), dtype=np.intp).reshape(-1, 3)
        self.places, self.rates, self.drives = rows.T
        self.gains = self.world.model.actuator_gainprm[self.drives, 0]
        self.damping = -self.world.model.actuator_biasprm[self.drives, 2]
        self.bad = int(self.world.engine.mjtWarning.mjWARN_BADQACC)

    def _fastened(self, mode: frozenset[ir.Fact]) -> dict[tuple[Node, Node], Edge | None]:
        """The welds of a mode; what nothing holds stays where it is by one to the world."""
        built = structure(self.problem, mode)
        found: dict[tuple[Node, Node], Edge | None] = {}
        reached = {WORLD} | {e.child for e in built.edges}
        for edge in built.all:
            if not edge.is_joint:
                found[edge.parent, edge.child] = edge
        movable = [n for n, b in self.problem.world.bodies.items() if b.movable]
        for name in (*self.problem.world.modules, *movable):
            if (name, -1) not in reached:
                found[WORLD, (name, -1)] = None
        return found

    def run(self) -> Simulated:
        for number, record in enumerate(self.plan.phases):
            self.tick()
            self._switch(number)
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
        self._switch(len(self.plan.phases))
        return self._phase(len(self.plan.phases), still)

    def _here(self) -> Poses:
        """Where everything is in the engine."""
        data = self.world.data
        turns = {n: data.xmat[b].reshape(1, 3, 3).copy() for n, b in self.world.bodies.items()}
        places = {n: data.xpos[b][None].copy() for n, b in self.world.bodies.items()}
        for name, body in self.problem.world.bodies.items():
            if not body.movable:
                still = poses(self.problem, {}, {name: np.array([body.pose])})
                turns[name, -1], places[name, -1] = still.turns[name, -1], still.places[name, -1]
        return Poses(turns, places)

    def _switch(self, number: int) -> None:
        wanted, here = self.edges[number], self._here()
        for pair in self.world.welds:
            on = welds.is_on(self.world, pair)
            if on and pair not in wanted:
                welds.loosen(self.world, pair)
            if pair in self.standing and pair not in wanted:
                contacts.lift(self.world, self.standing.pop(pair))
            elif not on and pair in wanted and pair not in self.dead and pair not in self.standing:
                edge = wanted[pair]
                if self.conditions.contact and edge is not None and contacts.stands(self.problem, edge):
                    self.standing[pair] = contacts.place(self.world, self.problem, edge, here)
                    continue
                point = here.places[pair[1]][0] if edge is None else meeting(self.problem, edge, here)[0][0]
                welds.fasten(self.world, pair, point)

    def _phase(self, number: int, record: PhaseRecord) -> bool:
        """Whether the phase was carried out without the simulation breaking down."""
        count = max(1, round((record.end - record.start) / STEP))
        times = np.minimum(record.start + STEP * np.arange(1, count + 1), record.end)
        values, targets = self._targets(number, record, times)
        limits = self._clamped(values)
        data, step_on = self.world.data, self.world.engine.mj_step
        tracking, peaks = 0.0, np.zeros(len(self.drives))
        for step in range(count):
            data.ctrl[self.drives] = targets[step]
            if self.standing:
                contacts.pull(self.world, list(self.standing.values()))
            step_on(self.world.model, data)
            at = data.qpos[self.places]
            if not np.isfinite(at).all() or data.warning[self.bad].number:
                self.result.diverged = float(times[step])
                return False
            tracking = max(tracking, float(np.abs(at - values[step]).max(initial=0.0)))
            # The law of the drives at the state after the step; what the engine reports is that before it.
            torque = self.gains * (targets[step] - at) - self.damping * data.qvel[self.rates]
            np.maximum(peaks, np.abs(torque), out=peaks)
            if self.watch is not None:
                self.watch.show()
            if step * STEP > SETTLED and step % LOOKED == 0:
                self._strain(number, float(times[step]))
        self._record(tracking, peaks, limits)
        self.result.seconds = record.end
        last = int(np.searchsorted(np.asarray(self.plan.times), record.end + 1e-9, side="right")) - 1
        for name in self.problem.world.modules:
            off = self._off(name, last)
            self.result.base = max(self.result.base, off)
            if off > LOST:
                self.result.diverged = record.end
                return False
        for pair in self.edges[number]:
            if welds.is_on(self.world, pair):
                self.result.droop = max(self.result.droop, welds.drift(self.world, pair))
        return True

    def _off(self, name: str, sample: int) -> float:
        track = next(t for t in self.plan.tracks if t.name == name)
        here = self.world.data.xpos[self.world.bodies[name, -1]]
        return float(np.linalg.norm(here - np.asarray(track.poses[sample][:3])))

    def _body_off(self, name: str) -> float:
        """How far a body is from where the plan leaves it."""
        last = [p for p in self.plan.body_tracks if p.name == name][-1].poses[-1]
        return float(np.linalg.norm(self.world.data.xpos[self.world.bodies[name, -1]] - np.asarray(last[:3])))

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
        here = placed(self.problem, self.plan, number, times, moving=True)
        return times, drives(self.problem, self.modes[number], here, safety_of(self.problem.options))

    def _targets(self, number: int, record: PhaseRecord, times: Array) -> tuple[Array, Array]:
        """Where the joints should be at each step `(T, n)`, and what their drives are told: that, how fast, and the
        torque that the plan expects."""
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
        wanted, speed = np.hstack(values), np.hstack(rates)
        more = np.stack(extra, axis=1) if extra else np.zeros((len(times), 0))
        return wanted, wanted + (self.damping * speed + more) / self.gains

    def _clamped(self, values: Array) -> Array:
        """Clamp drives at what they give in a phase, and where their joints do not move at what brakes bear."""
        still = np.ptp(values, axis=0) <= STILL
        limits = np.array([
            self.problem.world.modules[name].type.joints[index].strength(still=bool(still[k]))
            for k, (name, index) in enumerate(self.world.joints)
        ])  # fmt: skip
        limited = np.isfinite(limits)
        self.world.model.actuator_forcerange[self.drives[limited]] = np.outer(limits[limited], [-1.0, 1.0])
        return limits

    def _record(self, tracking: float, peaks: Array, limits: Array) -> None:
        self.result.tracking = max(self.result.tracking, tracking)
        for number, (name, index) in enumerate(self.world.joints):
            joint = self.problem.world.modules[name].type.joints[index]
            limit = float(limits[number])
            now, before = (min(float(peaks[number]), limit), limit), self.result.peaks.get((name, joint.name))
            if before is None or (now[0] / now[1], now[0]) > (before[0] / before[1], before[0]):
                self.result.peaks[name, joint.name] = now

    def _strain(self, number: int, now: float) -> None:
        """Break the welds that bear more than they can, and tell what no longer stands."""
        for pair, one in list(self.standing.items()):
            lost = contacts.gone(self.world, one)
            if lost is not None and pair not in self.dead:
                self.dead.add(pair)
                self.result.broken.append((now, f"{one.edge.names[0]} and {one.edge.names[1]} {lost[0]}", lost[1]))
        found = welds.wrenches(self.world)
        pairs = {weld: pair for pair, weld in self.world.welds.items()}
        here: Poses | None = None
        for weld, (force, moment) in found.items():
            edge = self.edges[number].get(pairs[weld])
            if edge is None or edge.hold is None:
                continue
            here = here or self._here()
            about = moment[None] + np.cross(welds.anchor(self.world, pairs[weld])[None], force[None])
            borne = loads_of(self.problem, edge, here, -force[None], -about, 1.0)
            ratio = max((float(load.ratio[0]) for load in borne), default=0.0)
            names = edge.names
            self.result.loads[names] = max(self.result.loads.get(names, 0.0), ratio)
            if ratio > 1.0 and math.isfinite(ratio):
                welds.loosen(self.world, pairs[weld])
                self.dead.add(pairs[weld])
                self.result.broken.append((now, f"{names[0]} and {names[1]}", ratio))
