"""The shapes that rest during a phase."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .....compiler.ir import Body, Shape, World
from .....compiler.motion.collision import bounding_radius, pose_matrix, shape_distance, shape_reach
from .....compiler.remembering import remembered
from .....langs.frozen import dataclass
from ....skeleton import Array, BodyPoses, Configuration, fixed_poses

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A shape that rests during the phase; `owner` is its body or module, `tag` the object that contacts name."""

    shape: Shape
    pose: Array
    owner: str
    tag: str | None


@remembered(4)
def places(world: World) -> Mapping[str, int]:
    """The places of modules and bodies in the order of the scene: modules come first."""
    return {name: place for place, name in enumerate([*world.modules, *world.bodies])}


class AtRest:
    """The names of what rests in a phase: bodies that never move, and `others`."""

    __slots__ = ("_bodies", "others")

    def __init__(self, world: World, others: set[str]) -> None:
        self._bodies, self.others = world.bodies, others

    def __contains__(self, name: object) -> bool:
        body = self._bodies.get(name) if isinstance(name, str) else None
        return (body is not None and not body.movable) or name in self.others


def _reached(shapes: Sequence[tuple[int, Obstacle]], reaches: Mapping[Point, float]) -> list[tuple[int, Obstacle]]:
    """Those shapes, each with the place of its owner in the scene, that come as near to one of the points as it
    reaches."""
    middles = np.array([o.pose[:3, 3] for _, o in shapes]).reshape(-1, 3)
    close = _close(middles, np.array([bounding_radius(o.shape) for _, o in shapes]), reaches)
    return [
        (place, o) for place, o in (shapes[k] for k in np.flatnonzero(close).tolist())
        if any(shape_distance(o.shape, o.pose, np.array(at)) <= reach for at, reach in reaches.items())
    ]  # fmt: skip


@remembered(4)
def _fixed(world: World) -> tuple[list[Body], Array, Array]:
    """The solid bodies that never move, and spheres around them, where they are at time 0: their middles `(B, 3)` and
    radii `(B,)`."""
    bodies = [b for b in world.solids if not b.movable]
    middles = np.array([b.pose[:3] for b in bodies], dtype=float).reshape(-1, 3)
    return bodies, middles, np.array([shape_reach(b.shape) for b in bodies])


@remembered(4)
def _movable(world: World) -> list[Body]:
    """The solid bodies that may move."""
    return [b for b in world.solids if b.movable]


def _parts(world: World, body: Body, at: Array) -> list[tuple[int, Obstacle]]:
    place, pose = places(world)[body.name], pose_matrix(at)
    return [
        (place, Obstacle(p.shape, pose @ pose_matrix(p.placement), body.name, body.name)) for p in body.shape.solids
    ]


class Surroundings:
    """What rests in a phase that begins at `start`, modules by the `frames` `(4, 4)` of their joints."""

    def __init__(
        self, world: World, rest: AtRest, start: Configuration, frames: Mapping[str, Mapping[int, Array]]
    ) -> None:
        self._world, self._rest, self._start, self._frames = world, rest, start, frames

    def near(self, reaches: Mapping[Point, float]) -> list[Obstacle]:
        """The shapes that come as near to one of some points as it reaches, in the order of the scene: bodies, then
        modules."""
        world, bodies = self._world, self._start.bodies
        shared = isinstance(bodies, BodyPoses) and bodies.shared is fixed_poses(world)
        near: list[Body] = []
        if shared:
            fixed, middles, radii = _fixed(world)
            near += [fixed[k] for k in np.flatnonzero(_close(middles, radii, reaches)).tolist()]
        loose = [b for b in (_movable(world) if shared else world.solids) if b.name in self._rest]
        at = np.array([bodies[b.name][:3] for b in loose]).reshape(-1, 3)
        near += [loose[k] for k in np.flatnonzero(_close(at, np.array([shape_reach(b.shape) for b in loose]), reaches))]
        found = _reached([item for b in near for item in _parts(world, b, bodies[b.name])], reaches)
        found.sort(key=lambda item: item[0])
        return [obstacle for _, obstacle in [*found, *_reached(self._modules(), reaches)]]

    def _modules(self) -> list[tuple[int, Obstacle]]:
        found: list[tuple[int, Obstacle]] = []
        for place, module in enumerate(self._world.modules.values()):
            if module.name not in self._rest:
                continue
            own = self._frames[module.name]
            for e in module.type.effectors:
                if e.shape is not None:
                    pose, tag = own[e.joint] @ pose_matrix(e.placement), f"{module.name}.{e.name}"
                    found += [
                        (place, Obstacle(part.shape, pose @ pose_matrix(part.placement), module.name, tag))
                        for part in e.shape.solids
                    ]
            for link in module.type.links:
                pose = own[link.joint] @ pose_matrix(link.placement)
                found.append((place, Obstacle(link.shape, pose, module.name, None)))
        return found


def _close(middles: Array, radii: Array, reaches: Mapping[Point, float]) -> NDArray[np.bool_]:
    """Which spheres, of `middles` `(O, 3)` and `radii` `(O,)`, come as near to one of the points as it reaches."""
    found = np.zeros(len(middles), dtype=bool)
    for at, reach in reaches.items():
        found |= np.linalg.norm(middles - at, axis=1) - radii <= reach
    return found
