"""A module as a Pinocchio model with its weights, whose recursion repeats joint torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...compiler import ir
from ..native import load_pinocchio
from .geometry import Array, Frames, crossed
from .inertia import weights
from .strengths import WORLD, Joined

GRAVITY = 9.81


class RigidModel:
    """The joints and weights of a module type on a free-flying base."""

    def __init__(self, kind: ir.ModuleType) -> None:
        pin = load_pinocchio()
        self._pin, self._model = pin, pin.Model()
        self._model.gravity = pin.Motion(np.array([0.0, 0.0, -GRAVITY]), np.zeros(3))
        self._ids = [self._model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base")]
        for joint in kind.joints:
            axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
            turning = joint.kind == ir.JointKind.REVOLUTE
            made = pin.JointModelRevoluteUnaligned(axis) if turning else pin.JointModelPrismaticUnaligned(axis)
            placement = pin.XYZQUATToSE3(np.asarray(joint.placement))
            self._ids.append(self._model.addJoint(self._ids[joint.parent + 1], made, placement, joint.name))
        self.mass = 0.0
        for joint_index, pose, mass, inertia in weights(kind):
            self.mass += mass
            place = pin.XYZQUATToSE3(np.asarray(pose))
            self._model.appendBodyToJoint(
                self._ids[joint_index + 1], pin.Inertia(mass, np.zeros(3), inertia), place
            )
        self._data: Any = self._model.createData()

    @staticmethod
    def of(kind: ir.ModuleType) -> RigidModel:
        """The model of a module type."""
        return _made(kind)

    def disagreement(
        self, name: str, nodes: Mapping[tuple[str, int], Frames],
        wrenches: Mapping[Joined, tuple[Array, Array]], ends: Sequence[Joined],
    ) -> float | None:  # fmt: skip
        """By how much Pinocchio's joint torques, or what is left at a base that the world does not bear, differ at the
        last instant from those of `wrenches`, where the `ends` of the module bear theirs; None where a joint of the
        module has no wrench."""
        pin = self._pin
        placed = {joint: _last(frame) for (owner, joint), frame in nodes.items() if owner == name}
        outside = pin.StdVec_Force()
        for _ in range(self._model.njoints):
            outside.append(pin.Force.Zero())
        for edge in ends:
            force, moment = (w[-1] for w in wrenches[edge])
            for node, sign in ((edge.near, 1.0), (edge.far, -1.0)):
                if node[0] == name:
                    rotation, position = placed[node[1]]
                    local = np.hstack([rotation.T @ force, rotation.T @ (moment - crossed(position, force))])
                    outside[self._ids[node[1] + 1]] += pin.Force(sign * local)
        values = [self._value(joint, placed) for joint in range(len(self._ids) - 1)]
        base = placed[-1]
        quaternion = pin.SE3ToXYZQUAT(pin.SE3(base[0], base[1]))
        q, rest = np.concatenate([quaternion, values]), np.zeros(self._model.nv)
        torques = np.asarray(pin.rnea(self._model, self._data, q, rest, rest, outside))
        mine = self._torques(name, placed, wrenches)
        if mine is None:
            return None
        bolted = any(edge.joint_of == name and edge.near == WORLD for edge in wrenches)
        left = 0.0 if bolted else float(np.abs(torques[:6]).max())
        return max(left, float(np.abs(np.abs(torques[6:]) - mine).max(initial=0.0)))

    def _value(self, joint: int, placed: Mapping[int, tuple[Array, Array]]) -> float:
        """The value of a joint, from the frames that it joins."""
        model = self._model.joints[self._ids[joint + 1]]
        parent = self._ids.index(self._model.parents[self._ids[joint + 1]]) - 1
        base = self._pin.SE3(*placed[parent]) * self._model.jointPlacements[self._ids[joint + 1]]
        moved = base.actInv(self._pin.SE3(*placed[joint]))
        axis = np.asarray(self._axes[joint])
        if "Prismatic" in model.shortname():
            return float(moved.translation @ axis)
        return float(self._pin.log3(moved.rotation) @ axis)

    @property
    def _axes(self) -> list[Array]:
        found = []
        for index in self._ids[1:]:
            subspace = self._model.joints[index].createData()
            self._model.joints[index].calc(subspace, np.zeros(self._model.nq))
            column = np.asarray(subspace.S).ravel()
            found.append(column[:3] if np.any(column[:3]) else column[3:])
        return found

    def _torques(
        self, name: str, placed: Mapping[int, tuple[Array, Array]], wrenches: Mapping[Joined, tuple[Array, Array]]
    ) -> Array | None:
        """The amounts of the joint torques that the wrenches mean."""
        known = {e.far[1]: w for e, w in wrenches.items() if e.joint_of == name}
        if len(known) < len(self._ids) - 1:
            return None
        found = []
        for joint, axis in enumerate(self._axes):
            rotation, position = placed[joint]
            force, moment = (w[-1] for w in known[joint])
            turning = "Revolute" in self._model.joints[self._ids[joint + 1]].shortname()
            acting = moment - crossed(position, force) if turning else force
            found.append(abs(float(acting @ (rotation @ axis))))
        return np.array(found)


def _last(frame: Frames) -> tuple[Array, Array]:
    return np.array(frame.rotation[-1]), np.array(frame.position[-1])


@lru_cache(maxsize=16)
def _made(kind: ir.ModuleType) -> RigidModel:
    return RigidModel(kind)


