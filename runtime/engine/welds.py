"""Welds of the engine: switched on where two things are, read, and taken away where they break."""

from __future__ import annotations

import numpy as np

from ...compiler.physics.structure import Node
from ..skeleton import Array
from .model import TORQUE_SCALE, EngineWorld


def fasten(world: EngineWorld, pair: tuple[Node, Node], point: Array) -> None:
    """Weld two bodies as they are now, at a point of the world. A row of the engine holds the point in the second body,
    the same in the first, the orientation of the second in the first, and the scale of its rotation rows."""
    engine, model, data, weld = world.engine, world.model, world.data, world.welds[pair]
    first, second = world.bodies[pair[0]], world.bodies[pair[1]]
    row = model.eq_data[weld]
    for body, at in ((second, 0), (first, 3)):
        row[at : at + 3] = data.xmat[body].reshape(3, 3).T @ (point - data.xpos[body])
    back, turn = np.zeros(4), np.zeros(4)
    engine.mju_negQuat(back, data.xquat[first])
    engine.mju_mulQuat(turn, back, data.xquat[second])
    row[6:10], row[10] = turn, TORQUE_SCALE
    data.eq_active[weld] = True


def loosen(world: EngineWorld, pair: tuple[Node, Node]) -> None:
    world.data.eq_active[world.welds[pair]] = False


def is_on(world: EngineWorld, pair: tuple[Node, Node]) -> bool:
    return bool(world.data.eq_active[world.welds[pair]])


def wrenches(world: EngineWorld) -> dict[int, tuple[Array, Array]]:
    """Force and moment at its point, in the world, that the first body of every weld puts on the second. The rotation
    rows are of half the angle, in the frame of the second."""
    data = world.data
    kind, owner, push = (np.array(v[: data.ne]) for v in (data.efc_type, data.efc_id, data.efc_force))
    chosen = kind == int(world.engine.mjtConstraint.mjCNSTR_EQUALITY)
    rows: dict[int, list[float]] = {}
    for weld, value in zip(owner[chosen].tolist(), push[chosen].tolist(), strict=True):
        rows.setdefault(weld, []).append(value)
    found = {}
    for weld, values in rows.items():
        turn = data.xmat[world.model.eq_obj2id[weld]].reshape(3, 3)
        moment = turn @ np.array(values[3:6]) / 2.0 * world.model.eq_data[weld][10]
        found[weld] = -np.array(values[:3]), -moment
    return found


def anchor(world: EngineWorld, pair: tuple[Node, Node]) -> Array:
    """Where the point of a weld is on its second body, in the world."""
    body, data = world.bodies[pair[1]], world.data
    row = world.model.eq_data[world.welds[pair]]
    return np.asarray(data.xpos[body] + data.xmat[body].reshape(3, 3) @ row[:3])


def drift(world: EngineWorld, pair: tuple[Node, Node]) -> float:
    """By how many metres the point of a weld has come apart."""
    row, data = world.model.eq_data[world.welds[pair]], world.data
    ends = []
    for node, at in ((pair[1], 0), (pair[0], 3)):
        body = world.bodies[node]
        ends.append(data.xpos[body] + data.xmat[body].reshape(3, 3) @ row[at : at + 3])
    return float(np.linalg.norm(ends[0] - ends[1]))
