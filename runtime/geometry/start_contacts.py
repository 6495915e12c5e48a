"""What is so near at the start of a scene that no margin can be asked for at once: things that lie side by side, or a
robot in mid-run that has just let go."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...compiler.motion.collision import Pair, bounding_radius, pair
from ...compiler.poses import compose, joint_frames, part_pose
from ...compiler.remembering import remembered
from ...compiler.scenes.check_start import TOLERANCE, penetration, volumes
from ...compiler.symbolic.geometry import Placed, shape_distance

TOUCHING = 0.02
"""Metres: what is nearer when a phase starts may be so, and is not asked for the margin of paths at once."""


ROUNDING = 1e-5
"""Metres by which what touches may seem to overlap."""


def touching(world: ir.World, within: float = TOUCHING) -> frozenset[Pair]:
    """Pairs of effectors and bodies, of different robots' modules or of a module and a body or of two bodies one of
    which can be moved, that are less than `within` metres apart."""
    found: set[Pair] = set()
    movers = _movers(world)
    still = [(b.name, placed) for b in world.solids if not b.movable for placed in _placed(b)]
    centres = np.array([placed.pose[:3] for _, placed in still]).reshape(-1, 3)
    radii = np.array([bounding_radius(placed.shape) for _, placed in still])
    for index, (name, placed) in enumerate(movers):
        far = np.linalg.norm(centres - np.array(placed.pose[:3]), axis=1) - radii
        near = np.flatnonzero(far < bounding_radius(placed.shape) + within)
        others = [still[i] for i in near.tolist()] + movers[index + 1 :]
        for other, shape in others:
            if world.owner(name) != world.owner(other) and _near(placed, shape, within):
                found.add(pair(name, other))
    return frozenset(found)


@remembered(4)
def pressed_in(world: ir.World) -> Mapping[Pair, float]:
    """How deep, metres, parts of modules overlap with bodies at the start: what `check` lets pass, no switch may
    refuse. A link goes by the name of its module."""
    found: dict[Pair, float] = {}
    solid = {body.name for body in world.solids}
    known = volumes(world)
    others = [v for v in known if v.owner in solid]
    edges = np.array([v.bounds for v in others]).reshape(-1, 6)
    for part in known:
        if part.owner not in world.modules:
            continue
        low, high = part.bounds[:3], part.bounds[3:]
        for index in np.flatnonzero(((edges[:, :3] < high) & (edges[:, 3:] > low)).all(axis=1)).tolist():
            depth, name = penetration(part, others[index]), pair(part.name, others[index].name)
            if ROUNDING < depth <= TOLERANCE:
                found[name] = max(depth + ROUNDING, found.get(name, 0.0))
    return found


def _movers(world: ir.World) -> list[tuple[str, Placed]]:
    """Effectors with a shape, then movable bodies, where they are."""
    found = []
    for module in world.modules.values():
        frames = joint_frames(module.type, module.pose, module.joints)
        for effector in module.type.effectors:
            if effector.shape is not None:
                pose = compose(frames[effector.joint], effector.placement)
                for part in effector.shape.solids:
                    found.append((f"{module.name}.{effector.name}", Placed(part.shape, part_pose(pose, part))))
    return found + [(b.name, placed) for b in world.solids if b.movable for placed in _placed(b)]


def _placed(body: ir.Body) -> list[Placed]:
    return [Placed(part.shape, part_pose(body.pose, part)) for part in body.shape.solids]


def _near(first: Placed, second: Placed, within: float) -> bool:
    apart = float(np.linalg.norm(np.subtract(first.pose[:3], second.pose[:3])))
    if apart >= bounding_radius(first.shape) + bounding_radius(second.shape) + within:
        return False
    return shape_distance(first, second) < within
