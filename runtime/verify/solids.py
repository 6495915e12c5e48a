"""The shapes of a plan that can collide: which belong to what, how large they are, and which pairs are looked at."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Callable, Sequence, Set
from functools import lru_cache
from typing import Any

import numpy as np

from ...compiler.ir import ShapeKind
from ...langs.frozen import dataclass
from ..plan import ModuleRecord, Plan, ShapeRecord
from .geometry import Array, Frames, frames
from .kinematics import Kinematics
from .sampler import IDENTITY, Placement
from .shapes import Ruler, bounding_radius, corners, geometry, transform


@dataclass(frozen=True, slots=True)
class Solid:
    """A shape fixed to joint `joint` of module `thing`, or (joint None) a body.

    The shape lies within the convex hull of `points` `(M, 3)` (in its own frame) grown by `ball` metres, and within
    `reach` metres of the origin of what carries it.
    """

    name: str
    thing: str
    joint: int | None
    placement: Frames
    kind: str
    size: tuple[float, ...]
    radius: float
    points: Array
    ball: float
    reach: float
    solid: Any

    @property
    def node(self) -> tuple[str, int]:
        """What carries the shape: a thing and its joint, or -1."""
        return self.thing, -1 if self.joint is None else self.joint

    @property
    def offset(self) -> float:
        """How far the centre of the shape is from the origin of what carries it, metres."""
        return math.hypot(*self.placement.position[0].tolist())

    def frames(self, placement: Placement) -> Frames:
        """The frames of the shape, at all times of the placement; one of what rests."""
        carrier = placement.thing(self.thing)[self.node[1]]
        return carrier.compose(self.placement) if self.joint is not None or self.offset > 0.0 else carrier


def solids(plan: Plan) -> list[Solid]:
    """All shapes of a plan that collide: effectors and links of modules, then bodies. Raises MissingLibrary."""
    found = []
    for module in plan.modules:
        for effector in module.effectors:
            if effector.shape is not None:
                name, at = f"{module.name}.{effector.name}", frames(effector.placement)
                for part in effector.shape.solids:
                    inner = at.compose(frames([*part.at, *IDENTITY[3:]]))
                    where = [*inner.position[0].tolist(), *effector.placement[3:]]
                    found.append(_solid(name, module.name, effector.joint, where, part.shape))
        for number, link in enumerate(module.links):
            name = f"{module.name} link {number + 1}"
            found.append(_solid(name, module.name, link.joint, link.placement, link.shape))
    for body in plan.bodies:
        parts = body.shape.solids if body.collides else []
        found += [_solid(body.name, body.name, None, [*part.at, *IDENTITY[3:]], part.shape) for part in parts]
    return found


def _solid(name: str, thing: str, joint: int | None, at: Sequence[float], shape: ShapeRecord) -> Solid:
    size = tuple(shape.size)
    placement, points, ball, reach = _measured(shape.kind, size, tuple(at))
    return Solid(
        name, thing, joint, placement, shape.kind, size,
        bounding_radius(shape.kind, size), points, ball, reach, geometry(shape.kind, size),
    )  # fmt: skip


@lru_cache(maxsize=1024)
def _measured(kind: str, size: tuple[float, ...], at: tuple[float, ...]) -> tuple[Frames, Array, float, float]:
    """Where a shape is in what carries it, the corners of its hull with the ball around them, and its reach."""
    points, ball = _hull(kind, size)
    placement = frames(at)
    carried = points @ placement.rotation[0].T + placement.position
    return placement, points, ball, float(np.linalg.norm(carried, axis=1).max()) + ball


def _hull(kind: str, size: tuple[float, ...]) -> tuple[Array, float]:
    match kind:
        case ShapeKind.SPHERE:
            return np.zeros((1, 3)), size[0]
        case ShapeKind.CAPSULE:
            return np.array([[0.0, 0.0, -size[1] / 2], [0.0, 0.0, size[1] / 2]]), size[0]
        case ShapeKind.CONVEX:
            return corners(size), 0.0
        case ShapeKind.CYLINDER:
            half = [size[0], size[0], size[1] / 2]
        case _:
            half = [s / 2 for s in size]
    return np.array(list(itertools.product(*((-h, h) for h in half)))), 0.0


def moved(plan: Plan, own: Set[str] = frozenset()) -> frozenset[str]:
    """The modules, and the bodies that are moved, other than those, `own`, which move by themselves."""
    return frozenset({m.name for m in plan.modules} | {t.name for t in plan.body_tracks} - own)


def pairs(
    plan: Plan, found: Sequence[Solid], own: Set[str] = frozenset(), check_time: Callable[[], None] | None = None
) -> list[tuple[int, int]]:  # fmt: skip
    """Indices of all pairs of solids that could come to touch and may not: at least one of them is moved, other than
    the bodies `own`, which move by themselves; and they are not neighbouring parts of one module. `check_time` is asked
    before each solid."""
    moving = moved(plan, own)
    modules = {m.name: m for m in plan.modules}
    neighbours = {name: _Neighbours(module, found) for name, module in modules.items()}
    movers = [k for k, solid in enumerate(found) if solid.thing in moving]
    result = []
    for i, a in enumerate(found):
        if check_time is not None:
            check_time()
        partners = range(i + 1, len(found)) if a.thing in moving else movers[bisect_right(movers, i) :]
        for k in partners:
            b = found[k]
            if a.thing == b.thing and (a.joint is None or neighbours[a.thing].include(a, b)):
                continue
            result.append((i, k))
    return result


class _Neighbours:
    """Parts of one module that may touch for ever: next to each other along its joints, or built into each other,
    which shows when all joints are at zero (or at the limit nearest to it)."""

    def __init__(self, module: ModuleRecord, found: Sequence[Solid]) -> None:
        self._module = module
        self._bearing = {s.joint for s in found if s.thing == module.name}
        joints = np.array([[min(max(0.0, j.lower), j.upper) for j in module.joints]])
        self._neutral = Kinematics(module).joint_frames(np.array([IDENTITY]), joints.reshape(1, -1))
        self._ruler = Ruler()

    def include(self, a: Solid, b: Solid) -> bool:
        """Whether two parts of the module are neighbours."""
        lines = [self._line(s.joint) for s in (a, b)]
        common = next(j for j in lines[0] if j in lines[1])
        inner = (set(lines[0]) ^ set(lines[1]) | {common}) - {a.joint, b.joint}
        if a.joint == b.joint or not inner & self._bearing:
            return True
        sides = []
        for solid, line in zip((a, b), lines, strict=True):
            frame = self._neutral[line[0]].compose(solid.placement)
            sides += [solid.solid, transform(frame.position[0], frame.rotation[0])]
        return self._ruler.distance(*sides) <= 0.0

    def _line(self, joint: int | None) -> list[int]:
        """The joints from this one up to the module frame, which is -1."""
        line = [-1 if joint is None else joint]
        while line[-1] >= 0:
            line.append(self._module.joints[line[-1]].parent)
        return line
