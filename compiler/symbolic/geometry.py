"""Lengths of the scene at the start: distance, stride, reach, radius. Metres.

Shapes that are a box along the world's axes grown by a radius (boxes, spheres, upright or level capsules) are the
usual case: their distances are plain arithmetic, a whole row of them at a time. Other pairs go through coal, lazily.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...langs.frozen import dataclass
from ..extents import box_sides
from ..hulls import Array, convex_geometry
from ..ir import Chain, Effector, ModuleType, Pose, Problem, Shape, ShapeKind, Value
from ..physics.scene_loads import SceneLoads
from ..poses import Quaternion, compose, joint_frames, make, orientation, part_pose, position, rotate
from ..remembering import remembered
from .lengths import longest_chain, path_length, shape_radius
from .settings import SYMBOLIC

Indices = NDArray[np.int64]
STRAIGHT = 1e-9
THIN = 1e-4
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Placed:
    """A shape with its pose in the world."""

    shape: Shape
    pose: Pose


@remembered(4)
def lengths_of(problem: Problem) -> SceneLengths:
    """The lengths of a scene, which all that ask for them share."""
    return SceneLengths(problem)


class SceneLengths:
    """Static functions on objects, which are named by their index in `names` (an int or an array of them)."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.names = tuple(problem.objects)
        self.index = {name: i for i, name in enumerate(self.names)}
        self._shapes: list[tuple[Placed, ...]] = [self._placed(name) for name in self.names]
        count = len(self.names)
        self._centre = np.zeros((count, 3))
        self._half = np.zeros((count, 3))
        self._round = np.zeros(count)
        self._top = np.zeros((count, 3))
        self._face = np.zeros((count, 2))
        self._radius = np.zeros(count)
        self._plain = np.zeros(count, dtype=bool)
        for i, placed in enumerate(self._shapes):
            self._measure(i, placed)
        self._all_plain = bool(self._plain.all())
        self._pairs: dict[tuple[str, int, int, float], float] = {}
        self._rows: dict[tuple[str, int, float], list[float]] = {}
        self._asked: dict[tuple[str, int, float], int] = {}
        self._tables: dict[tuple[Any, ...], Array] = {}
        self._reaches: dict[tuple[str, str], float] = {}
        self._chain_reaches: dict[Chain, float] = {}
        self._indices: dict[int, tuple[Sequence[Value], Indices]] = {}

    @cached_property
    def loads(self) -> SceneLoads:
        """What things and chains bear."""
        return SceneLoads(self.problem)

    def indices_of(self, names: Sequence[Value]) -> Indices:
        """The indices of objects; those of a list that is met again are kept."""
        known = self._indices.get(id(names))
        if known is None or known[0] is not names:
            known = self._indices[id(names)] = names, np.array([self.index[str(v)] for v in names])
        return known[1]

    def load(self, things: Any, joint: str) -> Any:
        """The worst load over strength, at the start, of one thing or an array of them, given by index; with the name
        of a joint, what its drive gives, in N m or N."""

        def one(thing: int) -> float:
            name = self.names[thing]
            return self.loads.torque(name, joint) if joint else self.loads.of(name)

        if isinstance(things, int):
            return one(things)
        return np.array([one(int(t)) for t in np.ravel(things)]).reshape(np.shape(things))

    def radius(self, i: Any) -> Any:
        """The radius of a round shape, of the sphere around another one, 0 without shape."""
        return self._radius[i]

    def distance(self, i: Any, j: Any) -> Any:
        """Smallest distance between two objects' shapes, 0 when they overlap. Index arrays broadcast."""
        return self._lookup("distance", i, j, 0.0)

    def stride(self, i: Any, j: Any, inset: float) -> Any:
        """Smallest distance between two top faces, each shrunk by `inset` on all sides (to nothing at most)."""
        return self._lookup("stride", i, j, inset)

    def reach(self, start: str, end: str) -> float:
        """An upper bound on the distance of two effectors of one module: the placements along the path between them."""
        key = (start, end)
        if key not in self._reaches:
            module, _ = self._effector(start)
            self._reaches[key] = path_length(module, start.rpartition(".")[2], end.rpartition(".")[2])
        return self._reaches[key]

    def chain_reach(self, chain: Chain) -> float:
        """The modules' reaches from effector to effector, and both radii at every joint between modules."""
        if chain not in self._chain_reaches:
            total = sum(self.reach(enter, leave) for _, enter, leave in chain.modules)
            for (_, _, leave), (_, enter, _) in zip(chain.modules, chain.modules[1:], strict=False):
                total += float(self._radius[self.index[leave]] + self._radius[self.index[enter]])
            self._chain_reaches[chain] = total
        return self._chain_reaches[chain]

    def longest_reach(self, modules: int) -> float:
        """No chain of so many of the scene's modules reaches farther."""
        return longest_chain(self.problem.world.modules.values(), modules)

    def _effector(self, name: str) -> tuple[ModuleType, str]:
        found = self.problem.world.effector(name)
        if found is None:
            raise ValueError(f"{name} is no effector")
        return found[0].type, found[1].name

    def _lookup(self, kind: str, i: Any, j: Any, inset: float) -> Any:
        if isinstance(i, int) and isinstance(j, int):
            return self._single(kind, i, j, inset)
        i, j = np.asarray(i), np.asarray(j)
        if i.ndim < 2 or j.ndim < 2:
            return self._table(kind, i, j, inset)
        key = (kind, inset, i.shape, j.shape, i.tobytes(), j.tobytes())
        if key not in self._tables:
            self._tables[key] = self._table(kind, i, j, inset)
        return self._tables[key]

    def _single(self, kind: str, i: int, j: int, inset: float) -> float:
        """One length; lengths are the same both ways, so the object that is asked for most gets a whole row."""
        if not (self._plain[i] and self._plain[j]):
            return self._exact(kind, i, j, inset)
        for a, b in ((i, j), (j, i)):
            known = self._rows.get((kind, a, inset))
            if known is not None:
                return known[b]
        for a, b in ((i, j), (j, i)):
            self._asked[kind, a, inset] = self._asked.get((kind, a, inset), 0) + 1
            if self._asked[kind, a, inset] > SYMBOLIC.single_lengths:
                everything = np.arange(len(self.names))
                row: list[float] = self._formula(kind, np.array(a), everything, inset).tolist()
                self._rows[kind, a, inset] = row
                return row[b]
        return float(self._formula(kind, np.array(i), np.array(j), inset))

    def _table(self, kind: str, i: Indices, j: Indices, inset: float) -> Array:
        values = self._formula(kind, i, j, inset)
        if not self._all_plain:
            i, j = np.broadcast_arrays(i, j)
            for at in np.argwhere(~(self._plain[i] & self._plain[j])):
                cell = tuple(at)
                values[cell] = self._exact(kind, int(i[cell]), int(j[cell]), inset)
        return values

    def _formula(self, kind: str, i: Indices, j: Indices, inset: float) -> Array:
        stride = kind == "stride"
        places = self._top if stride else self._centre
        total: Any = 0.0
        for axis in range(3):
            apart = np.abs(places[i, axis] - places[j, axis])
            if not stride:
                apart = np.maximum(apart - self._half[i, axis] - self._half[j, axis], 0.0)
            elif axis < 2:
                faces = np.maximum(self._face[i, axis] - inset, 0.0) + np.maximum(self._face[j, axis] - inset, 0.0)
                apart = np.maximum(apart - faces, 0.0)
            total = total + apart * apart
        if stride:
            return np.asarray(np.sqrt(total))
        surface: Array = np.maximum(np.sqrt(total) - self._round[i] - self._round[j], 0.0)
        return surface

    def _exact(self, kind: str, i: int, j: int, inset: float) -> float:
        key = (kind, i, j, inset) if i <= j else (kind, j, i, inset)
        if key not in self._pairs:
            if kind == "stride":
                firsts, seconds = (tuple(top_face(p, inset) for p in self._bearers(k)) for k in (i, j))
            else:
                firsts, seconds = self._shapes[i], self._shapes[j]
            self._pairs[key] = min((shape_distance(a, b) for a in firsts for b in seconds), default=0.0)
        return self._pairs[key]

    def _bearers(self, i: int) -> tuple[Placed, ...]:
        """The shapes of an object that things stand on: of a body or an effector of several parts the first."""
        return self._shapes[i] if self.names[i] in self.problem.world.modules else self._shapes[i][:1]

    def _placed(self, name: str) -> tuple[Placed, ...]:
        """The shapes of an object at the start: a body's, an effector's, or all of a module's links and effectors."""
        world = self.problem.world
        if name in world.bodies:
            body = world.bodies[name]
            return tuple(Placed(p.shape, part_pose(body.pose, p)) for p in body.shape.solids)
        if name in world.modules:
            module = world.modules[name]
            frames = joint_frames(module.type, module.pose, module.joints)
            links = [Placed(link.shape, compose(frames[link.joint], link.placement)) for link in module.type.links]
            ends = [e for e in module.type.effectors if e.shape is not None]
            return (*links, *(p for e in ends for p in _end(e, compose(frames[e.joint], e.placement))))
        found = world.effector(name)
        if found is None:
            return ()
        module, effector = found
        frame = joint_frames(module.type, module.pose, module.joints)[effector.joint]
        return _end(effector, compose(frame, effector.placement))

    def _measure(self, i: int, placed: tuple[Placed, ...]) -> None:
        body, end = self.problem.world.bodies.get(self.names[i]), self.problem.world.effector(self.names[i])
        whole = body.shape if body is not None else end[1].shape if end is not None else None
        if whole is not None and whole.parts:
            self._radius[i] = shape_radius(whole)
        if len(placed) != 1:
            return
        shape, pose = placed[0].shape, placed[0].pose
        self._radius[i] = shape_radius(shape)
        grown = grown_box(shape, pose)
        if grown is None:
            return
        half, radius = grown
        self._plain[i] = True
        self._centre[i] = self._top[i] = position(pose)
        self._half[i], self._round[i] = half, radius
        self._top[i, 2] += half[2] + radius
        self._face[i] = half[:2]


def _end(effector: Effector, pose: Pose) -> tuple[Placed, ...]:
    """The shapes of an effector at a pose; one without is a point."""
    shape = effector.shape or Shape(ShapeKind.SPHERE, (0.0,))
    return tuple(Placed(part.shape, part_pose(pose, part)) for part in shape.solids)


def grown_box(shape: Shape, pose: Pose) -> tuple[tuple[float, float, float], float] | None:
    """Half sizes of a box along the world's axes and the radius by which the shape is larger, or None."""
    return _grown_box(shape, orientation(pose))


@lru_cache(maxsize=1024)
def _grown_box(shape: Shape, turn: Quaternion) -> tuple[tuple[float, float, float], float] | None:
    if shape.kind == ShapeKind.SPHERE:
        return (0.0, 0.0, 0.0), shape.size[0]
    if shape.kind == ShapeKind.BOX:
        local, radius = [s / 2 for s in shape.size], 0.0
    elif shape.kind == ShapeKind.CAPSULE:
        local, radius = [0.0, 0.0, shape.size[1] / 2], shape.size[0]
    else:
        return None
    if turn == UPRIGHT:
        return (local[0], local[1], local[2]), radius
    half = [0.0, 0.0, 0.0]
    for k in range(3):
        axis = rotate(turn, (float(k == 0), float(k == 1), float(k == 2)))
        if local[k] and max(abs(x) for x in axis) < 1 - STRAIGHT:
            return None
        half[max(range(3), key=lambda r: abs(axis[r]))] += local[k]
    return (half[0], half[1], half[2]), radius


def top_face(placed: Placed, inset: float) -> Placed:
    """The upper face of a box, or of the box around a convex shape, shrunk, as a very thin box; the highest point of
    any other shape."""
    shape, pose = placed.shape, placed.pose
    if shape.kind == ShapeKind.CONVEX:
        return top_face(Placed(Shape(ShapeKind.BOX, box_sides(shape)), pose), inset)
    if shape.kind != ShapeKind.BOX:
        up = (0.0, 0.0, shape.size[0] + _rise(shape, pose))
        return Placed(Shape(ShapeKind.SPHERE, (0.0,)), (pose[0], pose[1], pose[2] + up[2], 0.0, 0.0, 0.0, 1.0))
    heights = [rotate(orientation(pose), (float(k == 0), float(k == 1), float(k == 2)))[2] for k in range(3)]
    k = max(range(3), key=lambda axis: abs(heights[axis]))
    size = [max(s - 2 * inset, 0.0) for s in shape.size]
    offset = [0.0, 0.0, 0.0]
    offset[k] = math.copysign(shape.size[k] / 2, heights[k])
    size[k] = 0.0
    centre = make((offset[0], offset[1], offset[2]), (0.0, 0.0, 0.0, 1.0))
    return Placed(Shape(ShapeKind.BOX, tuple(size)), compose(pose, centre))


def _rise(shape: Shape, pose: Pose) -> float:
    if shape.kind != ShapeKind.CAPSULE:
        return shape.size[1] / 2 if shape.kind == ShapeKind.CYLINDER else 0.0
    return abs(rotate(orientation(pose), (0.0, 0.0, shape.size[1] / 2))[2])


def shape_distance(a: Placed, b: Placed) -> float:
    """Smallest distance in metres, 0 when the shapes overlap."""
    for first, second in ((a, b), (b, a)):
        if first.shape.kind == ShapeKind.SPHERE and second.shape.kind not in (ShapeKind.CYLINDER, ShapeKind.CONVEX):
            return max(_point_distance(position(first.pose), second) - first.shape.size[0], 0.0)
    return _coal_distance(a, b)


def _point_distance(point: tuple[float, float, float], placed: Placed) -> float:
    """From a point to the surface of a sphere, capsule or box; 0 inside."""
    x, y, z, w = orientation(placed.pose)
    offset = (point[0] - placed.pose[0], point[1] - placed.pose[1], point[2] - placed.pose[2])
    local = rotate((-x, -y, -z, w), offset)
    size = placed.shape.size
    if placed.shape.kind == ShapeKind.BOX:
        return math.hypot(*(max(abs(c) - s / 2, 0.0) for c, s in zip(local, size, strict=True)))
    half = size[1] / 2 if placed.shape.kind == ShapeKind.CAPSULE else 0.0
    return max(math.hypot(local[0], local[1], max(abs(local[2]) - half, 0.0)) - size[0], 0.0)


def _coal_distance(a: Placed, b: Placed) -> float:
    import coal

    result = coal.distance(*_coal(a), *_coal(b), coal.DistanceRequest(), coal.DistanceResult())
    return max(float(result), 0.0)


def _coal(placed: Placed) -> tuple[Any, Any]:
    import coal

    x, y, z, w = orientation(placed.pose)
    turn = coal.Quaternion(w, x, y, z) if hasattr(coal, "Quaternion") else _matrix(placed.pose)
    place = coal.Transform3s(turn, np.array(position(placed.pose)))
    if placed.shape.kind == ShapeKind.CONVEX:
        return convex_geometry(placed.shape), place
    size = [max(s, THIN) for s in placed.shape.size]
    makers = {ShapeKind.BOX: coal.Box, ShapeKind.SPHERE: coal.Sphere,
              ShapeKind.CAPSULE: coal.Capsule, ShapeKind.CYLINDER: coal.Cylinder}  # fmt: skip
    return makers[placed.shape.kind](*size), place


def _matrix(pose: Pose) -> Array:
    columns = [rotate(orientation(pose), (float(k == 0), float(k == 1), float(k == 2))) for k in range(3)]
    return np.array(columns).T
