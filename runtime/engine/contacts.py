"""Feet and things that stand on real contact: a flat pad that presses and rubs on what bears it, pulled on by its
adhesion. Wheels, and pads whose adhesion is without limit, stay welds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...compiler import ir
from ...compiler.physics.frames import Poses, meeting
from ...compiler.physics.outlines import driven_away, foot_radius
from ...compiler.physics.records import CONTACTS
from ...compiler.physics.structure import Edge
from ..skeleton import Array
from .model import SUPPORT, EngineWorld

THICK = 0.002
"""Half of how thick a pad is, metres."""
SLIPPED, TIPPED = 5e-3, 0.1
"""Metres and radians by which what stands has moved against what bears it when it counts as slipped or tipped."""
UNSTATED = 1.0
"""Friction of a contact that states none: the engine diverges where it is 10."""
FOOT = 2
"""The bit of what stands."""


@dataclass(slots=True)
class Foothold:
    """A pair on contact: the geom of what stands, its adhesion, N, and where it stood on what bears it at first."""

    edge: Edge
    geom: int
    adhesion: float
    at: Array
    up: Array


def stands(problem: ir.Problem, edge: Edge | None) -> bool:
    """Whether a pair is carried out as a contact."""
    if edge is None or edge.hold is None or edge.manner not in CONTACTS or edge.turned:
        return False
    found = problem.world.effector(edge.place)
    if found is not None and driven_away(found):
        return False
    return edge.manner == "rest" or math.isfinite(edge.hold.force)


def place(world: EngineWorld, problem: ir.Problem, edge: Edge, here: Poses) -> Foothold:
    """Let a pair stand from now on: the pad of an end is laid where it meets what bears it."""
    model, data, hold = world.model, world.data, edge.hold
    assert hold is not None
    geom = world.pads[edge.child]
    body = world.bodies[edge.child]
    point = meeting(problem, edge, here)[0][0]
    if problem.world.effector(edge.place) is not None:
        radius = foot_radius(problem, edge.place)
        if math.isfinite(hold.moment) and edge.manner == "pad":
            radius = hold.moment / hold.force
        turn = data.xmat[body].reshape(3, 3)
        model.geom_pos[geom] = turn.T @ (point + np.array([0.0, 0.0, THICK]) - data.xpos[body])
        world.engine.mju_negQuat(model.geom_quat[geom], data.xquat[body])
        model.geom_size[geom] = [radius, THICK, 0.0]
        model.geom_sameframe[geom] = 0
        model.geom_rbound[geom] = math.hypot(radius, THICK)
        model.geom_aabb[geom] = [0.0, 0.0, 0.0, radius, radius, THICK]
    friction = hold.friction if math.isfinite(hold.friction) else UNSTATED
    model.geom_friction[geom] = [friction * world.rubbing, 0.01 * friction, 1e-4]
    model.geom_contype[geom] |= FOOT
    model.geom_conaffinity[geom] |= SUPPORT
    # The engine looks at bodies first, by flags that it gathered from their geoms at the start.
    model.body_contype[body] |= FOOT
    model.body_conaffinity[body] |= SUPPORT
    adhesion = hold.force if edge.manner == "pad" else 0.0
    return Foothold(edge, geom, adhesion, _relative(world, edge), _up(world, edge))


def lift(world: EngineWorld, standing: Foothold) -> None:
    """Let a pair go, with all adhesion: what still stands is pulled anew at the next step."""
    world.data.xfrc_applied[:] = 0.0
    world.model.geom_contype[standing.geom] &= ~FOOT
    world.model.geom_conaffinity[standing.geom] &= ~SUPPORT


def pull(world: EngineWorld, standing: list[Foothold]) -> None:
    """Apply the adhesion of all pads for the next step."""
    world.data.xfrc_applied[:] = 0.0
    for one in standing:
        if one.adhesion > 0.0:
            point = _point(world, one.edge)
            for node, force in ((one.edge.child, -one.adhesion), (one.edge.parent, one.adhesion)):
                body = world.bodies[node]
                lever = point - world.data.xipos[body]
                push = np.array([0.0, 0.0, force])
                world.data.xfrc_applied[body] += np.concatenate([push, np.cross(lever, push)])


def gone(world: EngineWorld, one: Foothold) -> tuple[str, float] | None:
    """What became of a pair that no longer stands as it did: slipped or tipped, and how many times the bound."""
    slip = float(np.linalg.norm(_relative(world, one.edge) - one.at)) / SLIPPED
    tip = float(np.arccos(np.clip(_up(world, one.edge) @ one.up, -1.0, 1.0))) / TIPPED
    if max(slip, tip) <= 1.0:
        return None
    return ("tipped", tip) if tip > 1.0 else ("slipped", slip)


def off(world: EngineWorld, one: Foothold, lost: tuple[str, float]) -> bool:
    """Whether a pad that tipped or slipped no longer sticks: it peels off where it tips, and slides off when it comes
    farther than its radius."""
    what, times = lost
    return what == "tipped" or times * SLIPPED > float(world.model.geom_size[one.geom][0])


def _point(world: EngineWorld, edge: Edge) -> Array:
    """Where the pad is, also before the engine knows that it was laid elsewhere."""
    body, geom, data = world.bodies[edge.child], world.pads[edge.child], world.data
    return np.asarray(data.xpos[body] + data.xmat[body].reshape(3, 3) @ world.model.geom_pos[geom])


def _relative(world: EngineWorld, edge: Edge) -> Array:
    parent, data = world.bodies[edge.parent], world.data
    point = _point(world, edge)
    return np.asarray(data.xmat[parent].reshape(3, 3).T @ (point - data.xpos[parent]))


def _up(world: EngineWorld, edge: Edge) -> Array:
    return np.array(world.data.xmat[world.bodies[edge.child]].reshape(3, 3)[2])
