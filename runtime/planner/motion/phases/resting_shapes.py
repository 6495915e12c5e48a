"""The shapes that rest during a phase."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Set as AbstractSet

from .....compiler.ir import Body, Shape, World
from .....compiler.motion.collision import pose_matrix
from .....compiler.remembering import remembered
from .....langs.frozen import dataclass
from ....skeleton import Array, BodyPoses, Configuration, fixed_poses


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A shape that rests during the phase; `owner` is its body or module, `tag` the object that contacts name."""

    shape: Shape
    pose: Array
    owner: str
    tag: str | None


@remembered(4)
def _resting(world: World) -> dict[str, list[Obstacle]]:
    """The parts of solid bodies that never move, where they are at time 0."""
    poses = fixed_poses(world)
    return {b.name: _parts(b, pose_matrix(poses[b.name])) for b in world.solids if not b.movable}


def _parts(body: Body, pose: Array) -> list[Obstacle]:
    return [Obstacle(p.shape, pose @ pose_matrix(p.placement), body.name, body.name) for p in body.shape.solids]


def obstacles(
    world: World, rest: AbstractSet[str], start: Configuration, frames: Mapping[str, Mapping[int, Array]]
) -> list[Obstacle]:
    """The shapes of what rests in a phase that begins at `start`, modules by the `frames` `(4, 4)` of their joints."""
    bodies = start.bodies
    known = _resting(world) if isinstance(bodies, BodyPoses) and bodies.shared is fixed_poses(world) else {}
    found: list[Obstacle] = []
    for body in world.solids:
        if body.name in known:
            found += known[body.name]
        elif body.name in rest:
            found += _parts(body, pose_matrix(bodies[body.name]))
    for module in world.modules.values():
        if module.name not in rest:
            continue
        own = frames[module.name]
        for e in module.type.effectors:
            if e.shape is not None:
                pose = own[e.joint] @ pose_matrix(e.placement)
                found.append(Obstacle(e.shape, pose, module.name, f"{module.name}.{e.name}"))
        for link in module.type.links:
            found.append(Obstacle(link.shape, own[link.joint] @ pose_matrix(link.placement), module.name, None))
    return found
