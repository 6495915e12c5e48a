"""Straight ways out of narrow places: the outermost moving frames of a phase pushed along one direction each, turning
as little as the joints let them.

Trees of samples rarely hit upon them, and whatever lies in a box, on a peg or in a slot comes out so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from .....compiler.distinct import distinct
from ....skeleton import Array
from .batch_kinematics import Indices
from .exact_check import near_entries
from .phase_batch import Batch
from .settings import PHASES

Advance = Callable[[Array, Array], tuple[Array, NDArray[np.bool_]]]
"""How far straight edges are free, and whether to their ends."""


def withdrawals(batch: Batch, root: Array, advance: Advance) -> list[Array]:
    """Ways `(poses, joints)` from a pose `(joints,)` of a batch of one phase, the pose itself left out; `advance` tells
    how far an edge is free."""
    geometry = batch.coarse
    frames = geometry.kinematics.frames(root[None, None])
    ways = [(node, line) for node in _tips(batch) for line in _directions(batch, frames, node)]
    if not ways:
        return []
    nodes, lines = np.array([n for n, _ in ways]), np.array([line for _, line in ways])
    found: list[list[Array]] = [[] for _ in ways]
    here, going = np.repeat(root[None], len(ways), axis=0), np.arange(len(ways))
    for _ in range(PHASES.withdrawal_steps):
        if not len(going):
            break
        step, follows = _step(batch, here[going], nodes[going], lines[going])
        going, step = going[follows], step[follows]
        reached, _ = advance(here[going], here[going] + step) if len(going) else (here[going], follows)
        moved = np.abs(reached - here[going]).max(axis=1) > PHASES.made
        going, reached = going[moved], reached[moved]
        here[going] = reached
        for way, pose in zip(going.tolist(), reached, strict=True):
            found[way].append(pose)
    return [np.array(poses) for poses in found if poses]


def _tips(batch: Batch) -> list[int]:
    """The nodes with parts that carry no others."""
    bearing = set(batch.exact.nodes[batch.exact.nodes >= 0].tolist())
    parents = batch.coarse.kinematics.parents
    inner: set[int] = set()
    for node in bearing:
        above = parents[node]
        while above >= 0:
            inner.add(above)
            above = parents[above]
    return sorted(bearing - inner)


def _above(parents: Sequence[int]) -> NDArray[np.bool_]:
    """`(nodes, joints)` which joints move a node."""
    result = np.eye(len(parents), dtype=bool)
    for node, parent in enumerate(parents):
        if parent >= 0:
            result[node] |= result[parent]
    return result


def _directions(batch: Batch, frames: Array, node: int) -> list[Array]:
    """The axes, both ways, of the world, of a node, and of what rests near its parts, each once."""
    axes = [np.eye(3), frames[node, :3, :, 0, 0], *_axes_near(batch, frames, node)]
    found: list[Array] = []
    for line in np.concatenate([*axes, *(-a for a in axes)]):
        if all(line @ other < PHASES.withdrawal_alike for other in found):
            found.append(line)
    return found[: PHASES.most_withdrawals]


def _axes_near(batch: Batch, frames: Array, node: int) -> list[Array]:
    geometry = batch.exact
    room = np.full((len(geometry.nodes), 1, 1), PHASES.withdrawal_near)
    found = []
    for entries in near_entries(geometry, frames, room):
        if not entries.among:
            mine = geometry.nodes[entries.first] == node
            found += [geometry.at[0, o, :3, :3].T for o in distinct(entries.second[mine])]
    return found


def _step(batch: Batch, here: Array, nodes: Indices, lines: Array) -> tuple[Array, NDArray[np.bool_]]:
    """By what joints `(ways, joints)` change for a stride along the lines, and which ways follow their line."""
    kinematics, count = batch.coarse.kinematics, len(here)
    frames = kinematics.frames(here[None])
    time, phase = np.arange(count), np.zeros(count, np.intp)
    at, axes = frames[nodes, 3, :, phase, time], frames[nodes, :3, :, phase, time]
    points = np.concatenate([at[:, None], at[:, None] + PHASES.withdrawal_arm * axes], axis=1)
    rows = np.empty((count, points.shape[1], 3, here.shape[1]))
    above = _above(kinematics.parents)[nodes]
    for p in range(points.shape[1]):
        for axis in range(3):
            normals = np.broadcast_to(np.eye(3)[axis], (count, 3))
            slopes = kinematics.slopes(frames, points[:, p], normals, phase, time) * above
            rows[:, p, axis] = kinematics.by_variables(slopes)
    matrix = rows.reshape(count, -1, here.shape[1])
    wanted = np.tile(lines, (1, points.shape[1])) * PHASES.withdrawal_stride
    square = matrix.transpose(0, 2, 1) @ matrix + PHASES.withdrawal_damping * np.eye(here.shape[1])
    step = np.asarray(np.linalg.solve(square, (matrix.transpose(0, 2, 1) @ wanted[..., None]))[..., 0])
    missed = np.abs((matrix @ step[..., None])[..., 0] - wanted).max(axis=1)
    return step, np.asarray(missed < PHASES.withdrawal_stride * PHASES.withdrawal_miss)
