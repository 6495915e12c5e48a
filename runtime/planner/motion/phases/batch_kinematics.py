"""Forward kinematics of many phases of one structure at once, and how fast joints carry points.

Frames are arrays `(nodes + 1, 4, 3, phases, times)`: the axes x, y, z and the origin of every node, last those of the
world, as node -1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .....compiler.distinct import distinct
from .....compiler.ir import JointKind
from ....skeleton import Array
from .collision_spheres import Ball
from .joint_forest import Mount, PhaseTree

Indices = NDArray[np.intp]
SAME = 1e-12
"""Kinematic constants of several phases that differ by less are one."""


class BatchKinematics:
    """The joints of phases that share a structure."""

    def __init__(self, trees: Sequence[PhaseTree]) -> None:
        first = trees[0]
        self.parents = first.parents
        self.revolute = np.array([kind == JointKind.REVOLUTE for kind in first.kinds], dtype=bool)
        self.signs = np.array(first.signs)
        self.columns = np.array(first.columns, dtype=np.intp)
        plain = np.array_equal(self.columns, np.arange(len(first.variables)))
        self.count = None if plain else len(first.variables)
        """How many variables there are where some move several joints."""
        before = np.array([t.before for t in trees]).reshape(len(trees), len(first.parents), 4, 4)
        self.before = np.ascontiguousarray(before.transpose(1, 0, 3, 2))
        """Columns of what comes before each joint: `(joints, phases, 4, 4)`."""
        self.shared = [bool(np.ptp(b, axis=0).max() < SAME) for b in self.before]

    def take(self, index: Indices) -> BatchKinematics:
        """The kinematics of some of the phases."""
        result = object.__new__(BatchKinematics)
        result.parents, result.revolute, result.signs = self.parents, self.revolute, self.signs
        result.columns, result.count = self.columns, self.count
        result.before, result.shared = self.before[:, index], self.shared
        return result

    def frames(self, values: Array) -> Array:
        """Frames for joint values `(phases, times, variables)`."""
        columns = values.transpose(2, 0, 1)
        moved = np.ascontiguousarray(columns) if self.count is None else columns[self.columns]
        turned = moved * self.signs[:, None, None]
        cos, sin = np.cos(turned), np.sin(turned)
        result = np.empty((len(self.parents) + 1, 4, 3, *values.shape[:2]))
        result[-1] = np.eye(4, 3)[:, :, None, None]
        for i, parent in enumerate(self.parents):
            own = result[i]
            if parent < 0:
                own[...] = self.before[i, :, :, :3].transpose(1, 2, 0)[..., None]
            elif self.shared[i]:
                np.matmul(self.before[i, 0], result[parent].reshape(4, -1), out=own.reshape(4, -1))
            else:
                np.einsum("bcr,rxbt->cxbt", self.before[i], result[parent], out=own)
            if self.revolute[i]:
                x = cos[i] * own[0] + sin[i] * own[1]
                own[1] = cos[i] * own[1] - sin[i] * own[0]
                own[0] = x
            else:
                own[3] += turned[i] * own[2]
        return result

    def slopes(self, frames: Array, points: Array, normals: Array, phase: Indices, time: Indices) -> Array:
        """How fast each joint carries points `(m, 3)` along normals `(m, 3)`, as if it moved them all: `(m, joints)`,
        at some phases and times `(m,)`."""
        axes, origins = (frames[:-1, row][:, :, phase, time] for row in (2, 3))
        along = normals.T
        x, y, z = (points.T - origins).transpose(1, 0, 2)
        moment = np.empty(axes.shape)
        moment[:, 0], moment[:, 1] = y * along[2] - z * along[1], z * along[0] - x * along[2]
        moment[:, 2] = x * along[1] - y * along[0]
        moment[~self.revolute] = along
        return np.asarray(np.einsum("jim,jim->mj", axes, moment) * self.signs)


    def by_variables(self, slopes: Array) -> Array:
        """How fast each variable carries points, by how fast each joint does: `(m, variables)` for `(m, joints)`."""
        if self.count is None:
            return slopes
        result = np.zeros((len(slopes), self.count))
        np.add.at(result.T, self.columns, slopes.T)
        return result


class Points:
    """Points fixed to nodes, one list of equal structure per phase."""

    def __init__(self, lists: Sequence[Sequence[Ball]]) -> None:
        self.nodes = np.array([b.node for b in lists[0]], dtype=np.intp)
        self.centres = np.array([[b.centre for b in balls] for balls in lists]).reshape(len(lists), -1, 3)
        self._group()

    def _group(self) -> None:
        """Nodes with their points, and whether these are the same in all phases."""
        self.groups: list[tuple[int, Indices, bool]] = []
        for node in distinct(self.nodes).tolist():
            mine = np.flatnonzero(self.nodes == node)
            spread = np.abs(self.centres[:, mine] - self.centres[:1, mine]).max(initial=0.0)
            self.groups.append((node, mine, bool(spread < SAME)))

    def some(self, points: Indices) -> Points:
        """Some of the points."""
        result = object.__new__(Points)
        result.nodes, result.centres = self.nodes[points], self.centres[:, points]
        result._group()
        return result

    def take(self, index: Indices) -> Points:
        """The points of some of the phases."""
        result = object.__new__(Points)
        result.nodes, result.centres, result.groups = self.nodes, self.centres[index], self.groups
        return result

    def placed(self, frames: Array) -> Array:
        """World positions `(points, 3, phases, times)` by the frames."""
        result = np.empty((len(self.nodes), *frames.shape[2:]))
        for node, mine, equal in self.groups:
            axes = frames[node]
            if equal:
                turned = (self.centres[0, mine] @ axes[:3].reshape(3, -1)).reshape(len(mine), *result.shape[1:])
            else:
                turned = np.einsum("bna,aibt->nibt", self.centres[:, mine], axes[:3])
            result[mine] = turned + axes[3]
        return result


def mounted_poses(tree: PhaseTree, mount: Mount, values: Array) -> Array:
    """World poses `(times, 4, 4)` of a mounted frame for joint values `(times, joints)` of one phase."""
    node, local = mount
    if node < 0:
        return np.broadcast_to(local, (len(values), 4, 4)).copy()
    result = np.zeros((len(values), 4, 4))
    result[:, :3] = BatchKinematics([tree]).frames(values[None])[node, :, :, 0].transpose(2, 1, 0)
    result[:, 3, 3] = 1.0
    return result @ local
