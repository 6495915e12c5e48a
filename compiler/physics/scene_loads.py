"""Loads that conditions of rules ask about: of things at the start, and of chains in the worst of all postures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ..ir import Chain, Hold, JointKind, Module, Problem, Shape, ShapeKind
from .frames import GRAVITY, Array, Poses, module_weights, poses
from .records import weaker
from .safety import safety_of
from .statics import drives, loads

KINDS = ("dock", "bond")
"""How modules of a chain hold each other."""
Point = Array


class SceneLoads:
    """Answers about one problem, each found once."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._safety = safety_of(problem.options)
        self._chains: dict[Chain, float] = {}

    @cached_property
    def _start(self) -> Poses:
        world = self._problem.world
        modules = {n: np.array([[*m.pose, *m.joints]]) for n, m in world.modules.items()}
        return poses(self._problem, modules, {n: np.array([b.pose]) for n, b in world.bodies.items()})

    @cached_property
    def _ratios(self) -> dict[str, float]:
        worst: dict[str, float] = {}
        for load in loads(self._problem, self._problem.init_motion, self._start, self._safety):
            for name in {load.edge.parent[0], load.edge.child[0]}:
                worst[name] = max(worst.get(name, 0.0), float(load.ratio[0]))
        return worst

    @cached_property
    def _drives(self) -> dict[tuple[str, int], Array]:
        return drives(self._problem, self._problem.init_motion, self._start)

    def of(self, name: str) -> float:
        """The worst ratio of a thing, or of the module that it is part of, at the start."""
        return self._ratios.get(self._problem.world.owner(name), 0.0)

    def torque(self, name: str, joint: str) -> float:
        """What a drive gives at the start, N m or N; 0 where the module has no such joint."""
        owner = self._problem.world.owner(name)
        module = self._problem.world.modules.get(owner)
        index = next((k for k, j in enumerate(module.type.joints) if j.name == joint), -1) if module else -1
        found = self._drives.get((owner, index))
        return 0.0 if found is None else float(found[0])

    def chain(self, chain: Chain) -> float:
        """The worst ratio of drives, bearings and docks of a chain that is held by its first end, with every weight as
        far away from them as it can be at all."""
        if chain not in self._chains:
            self._chains[chain] = max(self._ratios_of(chain), default=0.0)
        return self._chains[chain]

    def _ratios_of(self, chain: Chain) -> Iterator[float]:
        for number, (_, enter, _) in enumerate(chain.modules):
            module, end, point = self._end(enter)
            mass, moment = self._total(chain, number, end, None, point)
            hold = self._held(chain, number)
            if hold is not None:
                yield from self._over(mass * GRAVITY, moment, min(hold.force, hold.shear), hold.moment)
            waiting: list[tuple[int, int | None]] = [(end, None)]
            while waiting:
                node, before = waiting.pop()
                for other, joint, at in _neighbours(module, node):
                    if other == before:
                        continue
                    waiting.append((other, node))
                    mass, moment = self._total(chain, number, other, node, at)
                    drive = module.type.joints[joint]
                    turning = drive.kind == JointKind.REVOLUTE
                    along = drive.strength(still=True)
                    strength = (math.inf, along) if turning else (along, math.inf)
                    yield from self._over(mass * GRAVITY, moment, *strength)
                    yield from self._over(0.0, moment, math.inf, drive.bearing)

    def _over(self, force: float, moment: float, most: float, bending: float) -> Iterator[float]:
        yield self._safety * force / most
        yield self._safety * moment / bending

    def _held(self, chain: Chain, number: int) -> Hold | None:
        """How the end by which a module is entered holds."""
        ends = [chain.modules[number][1]] if number == 0 else [chain.modules[number - 1][2], chain.modules[number][1]]
        for manner in ("pad",) if number == 0 else KINDS:
            holds = [
                next((h for h in found[1].holds if h.manner == manner), None)
                for found in (self._problem.world.effector(e) for e in ends) if found is not None
            ]  # fmt: skip
            held = weaker(holds[0], holds[-1], manner)
            if held is not None:
                return held
        return None

    def _end(self, name: str) -> tuple[Module, int, Point]:
        found = self._problem.world.effector(name)
        if found is None:
            raise ValueError(f"{name} is no effector")
        return found[0], found[1].joint, np.asarray(found[1].placement[:3])

    def _total(self, chain: Chain, number: int, node: int, before: int | None, point: Point) -> tuple[float, float]:
        """Kilograms beyond a point, and the greatest moment about it, N m, that they can have."""
        mass = moment = 0.0
        for kilograms, distance in self._beyond(chain, number, node, before, point, 0.0):
            mass, moment = mass + kilograms, moment + kilograms * GRAVITY * distance
        return mass, moment

    def _beyond(
        self, chain: Chain, number: int, node: int, before: int | None, point: Point, far: float
    ) -> Iterator[tuple[float, float]]:
        """Every weight beyond a point of a node, with how far away it can be at most."""
        name, _, leave = chain.modules[number]
        module = self._problem.world.modules[name]
        weight = module_weights(module.type).get(node)
        if weight is not None:
            yield weight.mass, far + float(np.linalg.norm(weight.centre - point))
        _, end, way_out = self._end(leave)
        if end == node and number + 1 < len(chain.modules):
            _, entry, way_in = self._end(chain.modules[number + 1][1])
            gap = self._radius(leave) + self._radius(chain.modules[number + 1][1])
            step = far + float(np.linalg.norm(way_out - point)) + gap
            yield from self._beyond(chain, number + 1, entry, None, way_in, step)
        for other, joint, at in _neighbours(module, node):
            if other != before:
                drive = module.type.joints[joint]
                leaving = np.asarray(drive.placement[:3]) if other > node else np.zeros(3)
                step = far + float(np.linalg.norm(leaving - point)) + drive.slide
                yield from self._beyond(chain, number, other, node, at, step)

    def _radius(self, name: str) -> float:
        found = self._problem.world.effector(name)
        shape: Shape | None = None if found is None else found[1].shape
        if shape is None:
            return 0.0
        return math.hypot(*shape.size) / 2.0 if shape.kind == ShapeKind.BOX else shape.size[0]


def _neighbours(module: Module, node: int) -> list[tuple[int, int, Point]]:
    """The nodes beside one: each with the joint between them, and where that is in the other's frame."""
    joints = module.type.joints
    found = [(k, k, np.zeros(3)) for k, joint in enumerate(joints) if joint.parent == node]
    if node >= 0:
        found.append((joints[node].parent, node, np.asarray(joints[node].placement[:3])))
    return found
