"""Weights, frames and wrenches of rigid nodes over many samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...langs.frozen import dataclass
from ..ir import Joint, JointKind, ModuleType, Pose, Problem, Shape, ShapeKind
from ..poses import part_pose
from .masses import GRAVITY as GRAVITY
from .masses import body_mass, part_mass, solid_masses
from .moments import shape_moments
from .outlines import driven_away
from .records import CONTACTS
from .structure import WORLD, Edge, Node, driven

Array = NDArray[np.float64]
STILL = 1e-6
"""Radians or metres by which a joint may change that does not move."""


@dataclass(frozen=True, slots=True)
class Weight:
    """What is fixed to one node: kilograms, the centre (3,) in its frame, and the inertia (3, 3) about the centre."""

    mass: float
    centre: Array
    inertia: Array


@dataclass(frozen=True, slots=True)
class Poses:
    """Rotations `(T, 3, 3)` and positions `(T, 3)` of all nodes, over T samples."""

    turns: Mapping[Node, Array]
    places: Mapping[Node, Array]
    times: Array | None = None
    """Seconds of the samples where what moves has inertia, equidistant in each group."""
    moved: frozenset[Node] = frozenset()
    """Joints, each as its moving frame, that move over the samples: brakes bear nothing there."""
    group: int | None = None
    """So many samples that follow each other belong together; None: all."""


@lru_cache(maxsize=64)
def module_weights(kind: ModuleType) -> Mapping[int, Weight]:
    """What each moving frame of a module carries, by joint (-1: the module frame)."""
    parts: dict[int, list[Weight]] = {}

    def add(joint: int, mass: float, placement: Sequence[float], inertia: Array) -> None:
        turn = rotation(np.asarray(placement[3:]))
        parts.setdefault(joint, []).append(Weight(mass, np.asarray(placement[:3]), turn @ inertia @ turn.T))

    solids: list[tuple[int, Pose, Shape | None, float | None]] = []
    solids += [(e.joint, e.placement, e.shape, e.mass) for e in kind.effectors]
    solids += [(k.joint, k.placement, k.shape, k.mass) for k in kind.links]
    for joint, placement, shape, stated in solids:
        for part, mass in solid_masses(shape, part_mass(shape, stated)) if shape is not None else ():
            add(joint, mass, part_pose(placement, part), shape_moments(part.shape, mass))
    for drive in kind.joints:
        if drive.mass:
            add(drive.parent, drive.mass, drive.placement, np.zeros((3, 3)))
    for given in kind.inertials:
        xx, xy, xz, yy, yz, zz = given.inertia
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        add(given.joint, given.mass, (*given.centre, 0.0, 0.0, 0.0, 1.0), matrix)
    return {joint: _joined(found) for joint, found in parts.items()}


def _joined(parts: Sequence[Weight]) -> Weight:
    mass = sum(p.mass for p in parts)
    if mass == 0.0:
        return Weight(0.0, np.zeros(3), np.zeros((3, 3)))
    centre = np.sum([p.mass * p.centre for p in parts], axis=0) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        d = part.centre - centre
        inertia += part.inertia + part.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Weight(mass, centre, inertia)


def rotation(quaternion: Array) -> Array:
    """Rotation matrices `(…, 3, 3)` of unit quaternions `(…, 4)`."""
    x, y, z, w = (quaternion[..., k] for k in range(4))
    made = np.empty((*quaternion.shape[:-1], 3, 3))
    made[..., 0, 0], made[..., 1, 1] = 1 - 2 * (y * y + z * z), 1 - 2 * (x * x + z * z)
    made[..., 2, 2] = 1 - 2 * (x * x + y * y)
    made[..., 0, 1], made[..., 1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
    made[..., 0, 2], made[..., 2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
    made[..., 1, 2], made[..., 2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
    return made


def crossed(first: Array, second: Array) -> Array:
    """Cross products `(…, 3)` of like shapes: `np.cross` takes three times as long."""
    made = np.empty_like(first)
    (a, b, c), (x, y, z) = ((v[..., 0], v[..., 1], v[..., 2]) for v in (first, second))
    made[..., 0], made[..., 1], made[..., 2] = b * z - c * y, c * x - a * z, a * y - b * x
    return made


@lru_cache(maxsize=512)
def _joint_constants(joint: Joint) -> tuple[Array, Array, Array, Array, Array]:
    """Where a joint is on what carries it, its axis there, and the matrices of which 1, the sine and 1 - cosine of
    its angle make its turn."""
    axis, turn = np.asarray(joint.axis) / np.linalg.norm(joint.axis), rotation(np.asarray(joint.placement[3:]))
    spin = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.asarray(joint.placement[:3]), turn @ axis, turn, turn @ spin, turn @ spin @ spin


def poses(
    problem: Problem, modules: Mapping[str, Array], bodies: Mapping[str, Array], times: Array | None = None,
    group: int | None = None,
) -> Poses:  # fmt: skip
    """Where all nodes are: `modules` by name `(T, 7 + n)`, `bodies` `(T, 7)`; `times` where what moves has inertia,
    equidistant in each `group` of samples."""
    count = max((len(rows) for rows in (*modules.values(), *bodies.values())), default=1)
    turns: dict[Node, Array] = {WORLD: np.broadcast_to(np.eye(3), (count, 3, 3))}
    places: dict[Node, Array] = {WORLD: np.zeros((count, 3))}
    for name, rows in modules.items():
        turns[name, -1], places[name, -1] = rotation(_unit(rows[:, 3:7])), rows[:, :3]
        for index, joint in enumerate(problem.world.modules[name].type.joints):
            base, at = turns[name, joint.parent], places[name, joint.parent]
            offset, axis, turn, sine, cosine = _joint_constants(joint)
            value = rows[:, 7 + index]
            at = at + base @ offset
            if joint.kind == JointKind.REVOLUTE:
                own = np.sin(value)[:, None, None] * sine + (1.0 - np.cos(value))[:, None, None] * cosine
                base = base @ (own + turn)
            else:
                at = at + value[:, None] * (base @ axis)
                base = base @ turn
            turns[name, index], places[name, index] = base, at
    for name, rows in bodies.items():
        turns[name, -1], places[name, -1] = rotation(_unit(rows[:, 3:7])), rows[:, :3]
    change = {name: np.ptp(rows[:, 7:], axis=0) > STILL for name, rows in modules.items()}
    moved = frozenset((name, k) for name, far in change.items() for k in np.flatnonzero(far).tolist())
    return Poses(turns, places, times, moved, group)


def _unit(quaternions: Array) -> Array:
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True))


def node_weights(problem: Problem, nodes: Sequence[Node]) -> dict[Node, Weight]:
    found: dict[Node, Weight] = {}
    for node in nodes:
        name, joint = node
        if name in problem.world.modules:
            weight = module_weights(problem.world.modules[name].type).get(joint)
            if weight is not None:
                found[node] = weight
        elif name in problem.world.bodies:
            body = problem.world.bodies[name]
            mass = body_mass(body)
            found[node] = Weight(mass, np.zeros(3), shape_moments(body.shape, mass))
    return found


def node_wrench(
    weight: Weight, turn: Array, place: Array, times: Array | None, group: int | None = None
) -> tuple[Array, Array]:
    """Force and moment about the origin that a node puts on what bears it."""
    centre = place + turn @ weight.centre
    force = np.zeros_like(centre)
    force[:, 2] = -weight.mass * GRAVITY
    moment = crossed(centre, force)
    if times is not None:
        step = float(times[1] - times[0])
        inertia = turn @ weight.inertia @ np.swapaxes(turn, 1, 2)
        apart = (len(turn) // group, group) if group else (1, len(turn))
        push = -weight.mass * _second(centre.reshape(*apart, 3), step).reshape(-1, 3)
        force = force + push
        momentum = np.einsum("tij,tj->ti", inertia, _spin(turn, step, apart))
        turned = np.gradient(momentum.reshape(*apart, 3), step, axis=1, edge_order=2).reshape(-1, 3)
        moment = moment + crossed(centre, push) - turned
    return force, moment


def _second(values: Array, step: float) -> Array:
    """Second derivatives `(G, T, 3)` at all samples; those at the ends as beside them."""
    inner = (values[:, 2:] - 2.0 * values[:, 1:-1] + values[:, :-2]) / step**2
    return np.concatenate([inner[:, :1], inner, inner[:, -1:]], axis=1)


def _spin(turn: Array, step: float, apart: tuple[int, int]) -> Array:
    """Angular velocities `(T, 3)` in the world."""
    change = np.gradient(turn.reshape(*apart, 3, 3), step, axis=1, edge_order=2).reshape(-1, 3, 3)
    rate = change @ np.swapaxes(turn, 1, 2)
    return (
        np.stack([rate[:, 2, 1] - rate[:, 1, 2], rate[:, 0, 2] - rate[:, 2, 0], rate[:, 1, 0] - rate[:, 0, 1]], 1) / 2
    )


# --- where pairs meet ------------------------------------------------------------------------------------------


def meeting(problem: Problem, edge: Edge, at: Poses) -> tuple[Array, Array]:
    """Where a kept pair meets `(T, 3)`, and its axes `(T, 3, 3)` as columns; the third one is the normal."""
    name = edge.place
    found = problem.world.effector(name)
    if found is not None:
        module, end = found
        node = (module.name, end.joint)
        turn = at.turns[node] @ rotation(np.asarray(end.placement[3:]))
        place = at.places[node] + at.turns[node] @ np.asarray(end.placement[:3])
        shape = end.shape
    else:
        body = problem.world.bodies.get(name)
        node = (name, -1)
        shape = None if body is None else body.shape
        turn, place = at.turns[node], at.places[node]
    upright = np.broadcast_to(np.eye(3), turn.shape)
    if edge.manner in CONTACTS:
        if found is not None:
            under = at.places[found[0].name, driven(found[0].type, found[1].joint)]
            place = np.concatenate([under[:, :2], place[:, 2:]], axis=1) if driven_away(found) else place
        return place - upright[:, :, 2] * _low(shape, turn)[:, None], upright
    far = shape.size[0] if shape is not None and shape.kind == ShapeKind.SPHERE and found is not None else 0.0
    return place + far * turn[:, :, 2], turn


def _low(shape: Shape | None, turn: Array) -> Array:
    """How far the lowest point of a shape is below its middle."""
    down = turn[:, 2, :]
    if shape is None:
        return np.zeros(len(turn))
    if shape.kind == ShapeKind.BOX:
        return np.asarray(np.abs(down) @ (np.asarray(shape.size) / 2.0))
    if shape.kind == ShapeKind.CONVEX:
        return np.asarray(-(down @ np.asarray(shape.size).reshape(-1, 3).T).min(axis=1))
    if shape.kind == ShapeKind.SPHERE:
        return np.full(len(turn), shape.size[0])
    along, radius = np.abs(down[:, 2]) * shape.size[1] / 2.0, shape.size[0]
    round_end = shape.kind == ShapeKind.CAPSULE
    return along + (radius if round_end else radius * np.sqrt(np.maximum(0.0, 1.0 - down[:, 2] ** 2)))
