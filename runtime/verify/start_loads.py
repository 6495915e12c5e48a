"""Loads that conditions of rules ask about, by the verifier's own reckoning: of things at the start, and of chains in
the worst of all postures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from .gauge import Gauge
from .geometry import Array, Frames, frames
from .inertia import weights
from .shapes import round_radius

GRAVITY = 9.81


class StartScene:
    """Where everything is at the start; frames have one instant."""

    def __init__(self, world: ir.World, joints: Mapping[str, Mapping[int, Frames]]) -> None:
        self._world, self._joints = world, joints

    def frame(self, name: str) -> Frames:
        """The frames `(1,)` of an object."""
        end = self._world.effector(name)
        if end is not None:
            return self._joints[end[0].name][end[1].joint].compose(frames(end[1].placement))
        if name in self._world.modules:
            return self._joints[name][-1]
        return frames(self._world.bodies[name].pose)

    def parts(self, name: str) -> Mapping[int, Frames] | None:
        """The frames `(1,)` of a module by joint; None of what is no module."""
        return self._joints.get(name)


class StartLoads:
    """Loads at the start of a problem."""

    def __init__(self, problem: ir.Problem, scene: StartScene) -> None:
        self._world, self._scene = problem.world, scene
        self._gauge = Gauge(problem, problem.init_motion)
        self._safety = self._gauge.safety

    def load(self, name: str) -> float:
        """The worst ratio of a thing, or of its module."""
        return self._asked(ir.Function("load", (ir.Object(name),)))

    def torque(self, name: str, joint: str) -> float:
        """What the drive of a joint gives."""
        return self._asked(ir.Function("torque", (ir.Object(name), ir.Letter(joint))))

    def _asked(self, function: ir.Function) -> float:
        return float(self._gauge.value(function, {}, self._scene, np.array([0])).values[0, 0])

    def chain(self, chain: ir.Chain) -> float:
        """The worst ratio of a chain held by its first end. Weights and moments are summed from its tip."""
        worst, mass, moment = 0.0, 0.0, 0.0
        for number, (name, enter, leave) in reversed(list(enumerate(chain.modules))):
            first, last = self._end(enter), self._end(leave)
            module = _Held(self._world.modules[name].type, self._safety)
            mass, moment = module.carried(first, last, mass, moment)
            ends = [first, self._end(chain.modules[number - 1][2])] if number else [first]
            for manner in ("dock", "bond") if number else ("pad",):
                held = [h for e in ends for h in e.holds if h.manner == manner]
                if held:
                    force, bending = min(min(h.force, h.shear) for h in held), min(h.moment for h in held)
                    worst = max(worst, self._safety * mass * GRAVITY / force, self._safety * moment / bending)
                    break
            worst = max(worst, module.worst)
            if number:
                moment += mass * GRAVITY * sum(_radius(e.shape) for e in ends)
        return worst

    def _end(self, name: str) -> ir.Effector:
        found = self._world.effector(name)
        assert found is not None
        return found[1]


class _Held:
    """One module that is held by an end, and what it carries at another."""

    def __init__(self, kind: ir.ModuleType, safety: float) -> None:
        self._kind, self._safety = kind, safety
        self.worst = 0.0

    def carried(self, base: ir.Effector, tip: ir.Effector, mass: float, moment: float) -> tuple[float, float]:
        """Kilograms at the end `base`, and their greatest moment about it, where so much hangs on the end `tip`."""
        self._tip, self._more = tip, (mass, moment)
        return self._sum(base.joint, -2, np.asarray(base.placement[:3]))

    def _sum(self, node: int, before: int, point: Array) -> tuple[float, float]:
        mass = moment = 0.0
        own = [w for w in weights(self._kind) if w[0] == node]
        if own:
            total = sum(w[2] for w in own)
            middle = sum((w[2] * np.asarray(w[1][:3]) for w in own), np.zeros(3)) / total
            mass, moment = total, total * GRAVITY * float(np.linalg.norm(middle - point))
        if self._tip.joint == node:
            out = float(np.linalg.norm(np.asarray(self._tip.placement[:3]) - point))
            mass, moment = mass + self._more[0], moment + self._more[1] + self._more[0] * GRAVITY * out
        for index, joint in enumerate(self._kind.joints):
            at = np.asarray(joint.placement[:3])
            if joint.parent == node and index != before:
                sides = index, np.zeros(3), at
            elif index == node and joint.parent != before:
                sides = joint.parent, at, np.zeros(3)
            else:
                continue
            kilograms, bent = self._sum(sides[0], node, sides[1])
            self._judge(joint, kilograms, bent)
            lever = float(np.linalg.norm(sides[2] - point))
            lever += max(abs(joint.lower), abs(joint.upper)) if joint.kind == ir.JointKind.PRISMATIC else 0.0
            mass, moment = mass + kilograms, moment + bent + kilograms * GRAVITY * lever
        return mass, moment

    def _judge(self, joint: ir.Joint, mass: float, moment: float) -> None:
        drive = moment if joint.kind == ir.JointKind.REVOLUTE else mass * GRAVITY
        strength = max(joint.torque, joint.brake)
        self.worst = max(self.worst, self._safety * drive / strength, self._safety * moment / joint.bearing)


def _radius(shape: ir.Shape | None) -> float:
    return 0.0 if shape is None else round_radius(shape.kind, shape.size)
