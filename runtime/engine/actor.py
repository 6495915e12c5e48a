"""What acts in the engine: drives that follow what they are told, clamped at what they give, and kept pairs as welds or
contacts that give way beyond their strength."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ...compiler import ir
from ...compiler.physics.frames import STILL, Poses, meeting, poses
from ...compiler.physics.statics import loads_of
from ...compiler.physics.structure import WORLD, Edge, Node, structure
from ..seeds import Seed
from ..skeleton import Array
from . import contacts, welds
from .conditions import Conditions, Watch
from .model import STEP, UNLIMITED, EngineWorld, build

SETTLED = 0.1
"""Seconds after a switch in which the blow of fastening does not count against a weld: so long a thing of 2 kg that an
arm takes swings on the springs of its drives by 0.04 N, a tenth of the weakest grips that hold one."""
LOOKED = 5
"""Every so many steps the welds are looked at."""
Edges = dict[tuple[Node, Node], Edge | None]


@dataclass(slots=True)
class Simulated:
    """What came of a plan: `tracking` rad or m and `base` m, the worst of joints and of module frames; `droop` m, by
    how much welds gave; `peaks` the greatest torque, N m, of each drive and its strength, or the force, N, of `sliding`
    ones; `broken` what broke, when, and by which ratio; `diverged` when the simulation stopped making sense."""

    seconds: float = 0.0
    tracking: float = 0.0
    base: float = 0.0
    droop: float = 0.0
    peaks: dict[tuple[str, str], tuple[float, float]] = field(default_factory=dict)
    sliding: set[tuple[str, str]] = field(default_factory=set)
    loads: dict[tuple[str, str], float] = field(default_factory=dict)
    broken: list[tuple[float, str, float]] = field(default_factory=list)
    diverged: float | None = None
    reached: bool = False


@dataclass(frozen=True, slots=True)
class DriveCommands:
    """What drives are told at each of the steps of the engine `(T, n)`: where joints should be, how fast, and the
    torques that they are expected to need. `times` are seconds."""

    times: Array
    values: Array
    rates: Array
    torques: Array


def fastened(problem: ir.Problem, mode: frozenset[ir.Fact]) -> Edges:
    """The welds of a mode; what nothing holds stays where it is by one to the world."""
    built = structure(problem, mode)
    found: Edges = {}
    reached = {WORLD} | {e.child for e in built.edges}
    for edge in built.all:
        if not edge.is_joint:
            found[edge.parent, edge.child] = edge
    movable = [n for n, b in problem.world.bodies.items() if b.movable]
    for name in (*problem.world.modules, *movable):
        if (name, -1) not in reached:
            found[WORLD, (name, -1)] = None
    return found


class Actor:
    """The scene of a problem in the engine, with welds for `pairs`. `joints` are in the order of `world.joints`."""

    def __init__(self, problem: ir.Problem, pairs: Iterable[tuple[Node, Node]], conditions: Conditions) -> None:
        self.problem, self.conditions = problem, conditions
        self.standing: dict[tuple[Node, Node], contacts.Foothold] = {}
        self.result = Simulated()
        self.dead: set[tuple[Node, Node]] = set()
        self._load(build(problem, pairs, conditions.noise, Seed(conditions.seed)))
        self.watch = Watch(self.world) if conditions.view else None

    def _load(self, world: EngineWorld) -> None:
        self.world = world
        rows = np.array(list(world.joints.values()), dtype=np.intp).reshape(-1, 3)
        self.places, self.rates, self.drives = rows.T
        self.gains = world.model.actuator_gainprm[self.drives, 0]
        self.damping = -world.model.actuator_biasprm[self.drives, 2]
        self.bad = int(world.engine.mjtWarning.mjWARN_BADQACC)

    def extend(self, pairs: Iterable[tuple[Node, Node]]) -> None:
        """Have welds for these pairs, too: the scene is built anew, and goes on from where it is."""
        old = self.world
        more = [p for p in pairs if p not in old.welds]
        if not more:
            return
        self._load(build(self.problem, [*old.welds, *more], self.conditions.noise, Seed(self.conditions.seed)))
        new = self.world
        for name in ("qpos", "qvel", "ctrl", "qacc_warmstart"):
            getattr(new.data, name)[:] = getattr(old.data, name)
        for pair, weld in old.welds.items():
            new.model.eq_data[new.welds[pair]] = old.model.eq_data[weld]
            new.data.eq_active[new.welds[pair]] = old.data.eq_active[weld]
        new.engine.mj_forward(new.model, new.data)

    def here(self) -> Poses:
        """Where everything is in the engine."""
        data = self.world.data
        turns = {n: data.xmat[b].reshape(1, 3, 3).copy() for n, b in self.world.bodies.items()}
        places = {n: data.xpos[b][None].copy() for n, b in self.world.bodies.items()}
        for name, body in self.problem.world.bodies.items():
            if not body.movable:
                still = poses(self.problem, {}, {name: np.array([body.pose])})
                turns[name, -1], places[name, -1] = still.turns[name, -1], still.places[name, -1]
        return Poses(turns, places)

    def switch(self, wanted: Edges) -> None:
        """Let go what is not `wanted`, and fasten what is and did not break, as things are."""
        here = self.here()
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

    def move(self, told: DriveCommands, edges: Edges) -> Array | None:
        """Let drives follow what they are told while `edges` are kept. Where joints came to `(T, n)`; None where the
        simulation broke down."""
        limits = self._clamped(told.values)
        data, step_on = self.world.data, self.world.engine.mj_step
        driven, peaks = np.empty_like(told.values), np.zeros(len(self.drives))
        targets = told.values + (self.damping * told.rates + told.torques) / self.gains
        for step, time in enumerate(told.times):
            data.ctrl[self.drives] = targets[step]
            if self.standing:
                contacts.pull(self.world, list(self.standing.values()))
            step_on(self.world.model, data)
            at = driven[step] = data.qpos[self.places]
            if not np.isfinite(at).all() or data.warning[self.bad].number:
                self.result.diverged = float(time)
                return None
            # The law of the drives at the state after the step; what the engine reports is that before it.
            torque = self.gains * (targets[step] - at) - self.damping * data.qvel[self.rates]
            np.maximum(peaks, np.abs(torque), out=peaks)
            if self.watch is not None:
                self.watch.show()
            if step * STEP > SETTLED and step % LOOKED == 0:
                self._strain(edges, float(time))
        tracking = float(np.abs(driven - told.values).max(initial=0.0))
        self.result.tracking = max(self.result.tracking, tracking)
        self._peaked(peaks, limits)
        self.result.seconds = float(told.times[-1])
        for pair in edges:
            if welds.is_on(self.world, pair):
                self.result.droop = max(self.result.droop, welds.drift(self.world, pair))
        return driven

    def off(self, node: Node, place: Array) -> float:
        """How many metres something is from a place."""
        return float(np.linalg.norm(self.world.data.xpos[self.world.bodies[node]] - place))

    def _clamped(self, values: Array) -> Array:
        """Clamp drives at what they give in a phase, and where their joints do not move at what brakes bear. A joint
        without a drive rests where it is, or gives way to what moves it."""
        still = np.ptp(values, axis=0) <= STILL
        joints = [self.problem.world.modules[name].type.joints[index] for name, index in self.world.joints]
        limits = np.array([j.strength(still=bool(s)) for j, s in zip(joints, still, strict=True)])
        limits[[j.passive and not s for j, s in zip(joints, still, strict=True)]] = 0.0
        self.world.model.actuator_forcerange[self.drives] = np.outer(np.minimum(limits, UNLIMITED), [-1.0, 1.0])
        return limits

    def _peaked(self, peaks: Array, limits: Array) -> None:
        for number, (name, index) in enumerate(self.world.joints):
            joint = self.problem.world.modules[name].type.joints[index]
            if joint.passive:
                continue
            limit = float(limits[number])
            now, before = (min(float(peaks[number]), limit), limit), self.result.peaks.get((name, joint.name))
            if before is None or (now[0] / now[1], now[0]) > (before[0] / before[1], before[0]):
                self.result.peaks[name, joint.name] = now
                if joint.kind == ir.JointKind.PRISMATIC:
                    self.result.sliding.add((name, joint.name))

    def _strain(self, edges: Edges, now: float) -> None:
        """Break the welds that bear more than they can, and tell what no longer stands."""
        for pair, one in list(self.standing.items()):
            lost = contacts.gone(self.world, one)
            if lost is not None and contacts.off(self.world, one, lost):
                one.adhesion = 0.0
            if lost is not None and pair not in self.dead:
                self.dead.add(pair)
                self.result.broken.append((now, f"{one.edge.names[0]} and {one.edge.names[1]} {lost[0]}", lost[1]))
        found = welds.wrenches(self.world)
        pairs = {weld: pair for pair, weld in self.world.welds.items()}
        here: Poses | None = None
        for weld, (force, moment) in found.items():
            edge = edges.get(pairs[weld])
            if edge is None or edge.hold is None:
                continue
            here = here or self.here()
            about = moment[None] + np.cross(welds.anchor(self.world, pairs[weld])[None], force[None])
            borne = loads_of(self.problem, edge, here, -force[None], -about, 1.0)
            ratio = max((float(load.ratio[0]) for load in borne), default=0.0)
            names = edge.names
            self.result.loads[names] = max(self.result.loads.get(names, 0.0), ratio)
            if ratio > 1.0 and math.isfinite(ratio):
                welds.loosen(self.world, pairs[weld])
                self.dead.add(pairs[weld])
                self.result.broken.append((now, f"{names[0]} and {names[1]}", ratio))
