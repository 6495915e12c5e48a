"""Forward kinematics of many phases of one structure at once, with the twists that give Jacobians.

Arrays end in axes `(phases, times)`; vectors come as `(…, 3, phases, times)`. Kinematic constants that are equal in all
phases are plain numbers, so that their zeros and ones cost nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...skeleton import Array
from .balls import Ball
from .tree import Mount, PhaseTree

Weight = float | Array
Indices = NDArray[np.intp]
Frame = tuple[Array, Array, Array, Array]
"""The axes x, y, z and the origin of a frame."""


def _weight(values: Array) -> Weight:
    """A number when all phases agree on it, else `(phases, 1)`."""
    return float(values[0]) if np.ptp(values) < 1e-12 else values[:, None]


def _take(weight: Weight, index: Indices) -> Weight:
    return weight if isinstance(weight, float) else weight[index]


def _mix(frame: Frame, weights: Sequence[Weight], origin: bool) -> Array:
    """A combination of a frame's axes, from its origin when `origin`."""
    total: Array | None = frame[3] if origin else None
    for axis, weight in zip(frame[:3], weights, strict=True):
        if isinstance(weight, float) and weight == 0.0:
            continue
        term = axis if isinstance(weight, float) and weight == 1.0 else weight * axis
        total = term if total is None else total + term
    return np.zeros_like(frame[3]) if total is None else total


def cross(a: Array, b: Array) -> Array:
    """Vector product along the first axis."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


class Kinematics:
    """The joints of phases that share a structure."""

    def __init__(self, trees: Sequence[PhaseTree]) -> None:
        first = trees[0]
        self.parents, self.phases = first.parents, len(trees)
        self.revolute = [kind == "revolute" for kind in first.kinds]
        self.signs = np.array(first.signs)
        before = np.array([t.before for t in trees]).reshape(len(trees), len(first.parents), 4, 4)
        self.bases = {i: before[:, i, :3].transpose(2, 1, 0)[..., None] for i, p in enumerate(self.parents) if p < 0}
        """For joints on the world: axes and origin `(4, 3, phases, 1)` before the joint moves."""
        self.weights = {
            i: [[_weight(before[:, i, row, column]) for row in range(3)] for column in range(4)]
            for i, p in enumerate(self.parents)
            if p >= 0
        }

    def take(self, index: Indices) -> Kinematics:
        """The kinematics of some of the phases."""
        result = object.__new__(Kinematics)
        result.parents, result.revolute, result.signs = self.parents, self.revolute, self.signs
        result.phases = len(index)
        result.bases = {i: base[:, :, index] for i, base in self.bases.items()}
        result.weights = {i: [[_take(w, index) for w in c] for c in columns] for i, columns in self.weights.items()}
        return result

    def frames(self, values: Array) -> tuple[list[Frame], list[Array], list[Array]]:
        """Node frames for joint values `(phases, times, joints)`, and per joint the angular and linear part of its
        unit twist about the world's origin."""
        turned = np.ascontiguousarray(values.transpose(2, 0, 1)) * self.signs[:, None, None]
        cos, sin = np.cos(turned), np.sin(turned)
        frames: list[Frame] = []
        angular, linear = [], []
        for i, parent in enumerate(self.parents):
            if parent < 0:
                x, y, z, p = self.bases[i]
            else:
                x, y, z, p = (_mix(frames[parent], w, k == 3) for k, w in enumerate(self.weights[i]))
            axis = self.signs[i] * z
            if self.revolute[i]:
                angular.append(axis)
                linear.append(cross(p, axis))
                x, y = cos[i] * x + sin[i] * y, cos[i] * y - sin[i] * x
            else:
                angular.append(np.zeros_like(axis))
                linear.append(axis)
                p = p + turned[i] * z
            frames.append((x, y, z, p))
        return frames, angular, linear


class Points:
    """Points fixed to nodes, one list of equal structure per phase."""

    def __init__(self, lists: Sequence[Sequence[Ball]]) -> None:
        self.nodes = np.array([b.node for b in lists[0]], dtype=np.intp)
        self.centres = np.array([[b.centre for b in balls] for balls in lists]).reshape(len(lists), -1, 3)
        self._group()

    def _group(self) -> None:
        """Nodes with their points, and whether these are the same in all phases."""
        self.groups: list[tuple[int, Indices, bool]] = []
        for node in np.unique(self.nodes).tolist():
            mine = np.flatnonzero(self.nodes == node)
            spread = np.abs(self.centres[:, mine] - self.centres[:1, mine]).max(initial=0.0)
            self.groups.append((node, mine, bool(spread < 1e-12)))

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

    def place(self, frames: list[Frame], phases: int, times: int) -> Array:
        """World positions `(points, 3, phases, times)`."""
        result = np.empty((len(self.nodes), 3, phases, times))
        for node, mine, equal in self.groups:
            centres = self.centres[:, mine]
            if node < 0:
                result[mine] = centres.transpose(1, 2, 0)[..., None]
                continue
            axes = np.stack([np.broadcast_to(a, result.shape[1:]) for a in frames[node]])
            if equal:
                turned = (centres[0] @ axes[:3].reshape(3, -1)).reshape(len(mine), *result.shape[1:])
            else:
                turned = np.einsum("bna,aibt->nibt", centres, axes[:3])
            result[mine] = turned + axes[3]
        return result

    def placed(self, frames: Array) -> Array:
        """World positions `(points, 3, phases, times)` by frames `(nodes + 1, 4, 3, phases, times)`, the world's
        last."""
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
    frame = Kinematics([tree]).frames(values[None])[0][node]
    result = np.zeros((len(values), 4, 4))
    for column, axis in enumerate(frame):
        result[:, :3, column] = np.broadcast_to(axis, (3, 1, len(values)))[:, 0].T
    result[:, 3, 3] = 1.0
    return result @ local
