"""Numeric guards of rules, measured on the scene at the start: distance, stride, reach, radius, load, torque."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from ...compiler import ir
from ...langs.frozen import dataclass
from .geometry import Frames, frames
from .shapes import Ruler, corners, geometry, heights, round_radius, transform
from .start_loads import StartLoads, StartScene

POINT = 1e-9
FACE = 1e-9
"""Radius that stands for a point and thickness that stands for a face, metres."""


@dataclass(frozen=True, slots=True)
class _Placed:
    """A shape in the scene; `frame` has one instant."""

    shape: ir.Shape
    frame: Frames


_Side = tuple[list[int], list[int], ir.Effector]


class Guards:
    """The start scene of a problem, measured at will; every figure is computed once."""

    def __init__(self, problem: ir.Problem) -> None:
        self._problem, self._world = problem, problem.world
        self._ruler = Ruler()
        self._known: dict[tuple[str, ...], float] = {}
        self._placed: dict[str, list[_Placed]] = {}
        self._joints: dict[str, dict[int, Frames]] = {}

    def distance(self, first: str, second: str) -> float:
        """Smallest distance between two things at the start, 0 when they overlap."""
        key = ("distance", *sorted((first, second)))
        if key not in self._known:
            pairs = ((a, b) for a in self._shapes(first) for b in self._shapes(second))
            self._known[key] = max(0.0, min((self._between(a, b) for a, b in pairs), default=math.inf))
        return self._known[key]

    def stride(self, first: str, second: str, inset: float) -> float:
        """Smallest distance between the top faces of two things, each shrunk by `inset` on every side."""
        key = ("stride", *sorted((first, second)), repr(inset))
        if key not in self._known:
            self._known[key] = max(0.0, self._between(self._face(first, inset), self._face(second, inset)))
        return self._known[key]

    def radius(self, name: str) -> float:
        """Radius of a round shape, or of the sphere around a box; 0 for what does not have one shape."""
        body = self._world.bodies.get(name)
        shapes = [placed.shape for placed in self._shapes(name)] if body is None else [body.shape]
        if len(shapes) != 1 or shapes[0].size == (POINT,):
            return 0.0
        return round_radius(shapes[0].kind, shapes[0].size)

    def reach(self, first: str, second: str) -> float:
        """Upper bound of the distance between two effectors of one module: the lengths between them, summed."""
        one, other = self._world.effector(first), self._world.effector(second)
        if one is None or other is None or one[0].name != other[0].name:
            return math.inf
        kind = one[0].type
        above, below = (list(_joints_above(kind, e.joint)) for e in (one[1], other[1]))
        total, ends = 0.0, []
        sides: tuple[_Side, _Side] = ((above, below, one[1]), (below, above, other[1]))
        for line, others, effector in sides:
            point = effector.placement[:3]
            for joint in line:
                if joint in others:
                    break
                total += math.hypot(*point) + _travel(kind.joints[joint])
                point = kind.joints[joint].placement[:3]
            ends.append(point)
        return total + math.dist(*ends)

    def chain_reach(self, chain: ir.Chain) -> float:
        """Upper bound of the distance between the ends of a chain of docked modules."""
        inner = sum(self.reach(entry, leave) for _, entry, leave in chain.modules)
        docks = zip(chain.modules, chain.modules[1:], strict=False)
        return inner + sum(self.radius(a[2]) + self.radius(b[1]) for a, b in docks)

    def load(self, thing: str | ir.Chain) -> float:
        """The worst ratio of load to strength: of a thing at the start, of a chain in the worst of all postures."""
        return self._loads.chain(thing) if isinstance(thing, ir.Chain) else self._loads.load(thing)

    def torque(self, name: str, joint: str) -> float:
        """What the drive of a joint gives at the start; 0 where there is no such joint."""
        return self._loads.torque(name, joint)

    @cached_property
    def _loads(self) -> StartLoads:
        scene = StartScene(self._world, {n: joint_frames(m) for n, m in self._world.modules.items()})
        return StartLoads(self._problem, scene)

    def _between(self, first: _Placed, second: _Placed) -> float:
        sides = []
        for placed in (first, second):
            sides += [_solid(placed.shape), transform(placed.frame.position[0], placed.frame.rotation[0])]
        return self._ruler.distance(*sides)

    def _shapes(self, name: str) -> list[_Placed]:
        if name not in self._placed:
            self._placed[name] = list(self._find_shapes(name))
        return self._placed[name]

    def _find_shapes(self, name: str) -> Iterator[_Placed]:
        body, end = self._world.bodies.get(name), self._world.effector(name)
        if body is not None:
            yield from _parts(body.shape, frames(body.pose))
            return
        module = end[0] if end is not None else self._world.modules[name]
        if module.name not in self._joints:
            self._joints[module.name] = joint_frames(module)
        joints = self._joints[module.name]
        if end is not None:
            shape = end[1].shape or ir.Shape(ir.ShapeKind.SPHERE, (POINT,))
            yield from _parts(shape, joints[end[1].joint].compose(frames(end[1].placement)))
            return
        for effector in module.type.effectors:
            if effector.shape is not None:
                yield from _parts(effector.shape, joints[effector.joint].compose(frames(effector.placement)))
        for link in module.type.links:
            yield _Placed(link.shape, joints[link.joint].compose(frames(link.placement)))

    def _face(self, name: str, inset: float) -> _Placed:
        placed = self._shapes(name)[0]
        shape, at = placed.shape, placed.frame
        if shape.kind == ir.ShapeKind.CONVEX:
            shape = ir.Shape(ir.ShapeKind.BOX, tuple(np.ptp(corners(shape.size), axis=0)))
        if shape.kind != ir.ShapeKind.BOX:
            height = float(heights(shape.kind, shape.size, at.rotation)[0])
            highest = at.position + np.array([0.0, 0.0, height])
            return _Placed(ir.Shape(ir.ShapeKind.SPHERE, (POINT,)), Frames(highest, at.rotation))
        upright = int(np.argmax(np.abs(at.rotation[0, 2])))
        half = 0.5 * shape.size[upright] * np.sign(at.rotation[0, 2, upright])
        sides = [max(s - 2 * inset, FACE) for s in shape.size]
        sides[upright] = FACE
        top = Frames(at.position + half * at.rotation[:, :, upright], at.rotation)
        return _Placed(ir.Shape(ir.ShapeKind.BOX, tuple(sides)), top)


def _parts(shape: ir.Shape, at: Frames) -> Iterator[_Placed]:
    """The convex shapes of a shape at a frame."""
    for part in shape.solids:
        yield _Placed(part.shape, at.compose(frames(part.placement)))


def _solid(shape: ir.Shape) -> Any:
    return geometry(shape.kind, shape.size)


def joint_frames(module: ir.Module) -> dict[int, Frames]:
    """The frame of every joint at the start, by the plain definition; -1 is the module frame."""
    found = {-1: frames(module.pose)}
    for index, (joint, value) in enumerate(zip(module.type.joints, module.joints, strict=True)):
        axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
        if joint.kind == ir.JointKind.PRISMATIC:
            motion = [*(axis * value), 0.0, 0.0, 0.0, 1.0]
        else:
            motion = [0.0, 0.0, 0.0, *(axis * math.sin(value / 2)), math.cos(value / 2)]
        found[index] = found[joint.parent].compose(frames(joint.placement)).compose(frames(motion))
    return found


def _joints_above(kind: ir.ModuleType, joint: int) -> Iterator[int]:
    while joint >= 0:
        yield joint
        joint = kind.joints[joint].parent


def _travel(joint: ir.Joint) -> float:
    return max(abs(joint.lower), abs(joint.upper)) if joint.kind == ir.JointKind.PRISMATIC else 0.0
