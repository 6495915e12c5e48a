"""Where everything is at every sample of a plan: Pinocchio models built from the plan's own records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..native import load_pinocchio
from ..plan import ModuleRecord, Plan
from .geometry import Array, Frames, frames
from .structure import phase_ranges


class Kinematics:
    """Forward kinematics of one module on a free-flying base, by Pinocchio. Raises MissingLibrary."""

    def __init__(self, module: ModuleRecord) -> None:
        pinocchio = load_pinocchio()
        self.module = module
        self._forward = pinocchio.forwardKinematics
        self._model = pinocchio.Model()
        base = self._model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "base")
        self._ids = [base]
        for joint in module.joints:
            axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
            kinds = {
                "revolute": pinocchio.JointModelRevoluteUnaligned,
                "prismatic": pinocchio.JointModelPrismaticUnaligned,
            }
            placement = pinocchio.XYZQUATToSE3(_unit(joint.placement))
            parent = self._ids[joint.parent + 1]
            self._ids.append(self._model.addJoint(parent, kinds[joint.kind](axis), placement, joint.name))
        self._data = self._model.createData()

    def joint_frames(self, poses: Array, joints: Array) -> dict[int, Frames]:
        """The moving frame of every joint, and -1 for the module frame, for poses `(T, 7)`, joints `(T, n)`."""
        rows = np.hstack([_unit(poses), joints])
        count = len(self._ids)
        found = np.empty((count, len(rows), 4, 4))
        placements: Any = self._data.oMi
        for t, row in enumerate(rows):
            self._forward(self._model, self._data, row)
            for k, index in enumerate(self._ids):
                found[k, t] = placements[index].homogeneous
        return {k - 1: Frames(m[:, :3, 3].copy(), m[:, :3, :3].copy()) for k, m in enumerate(found)}

    def effector(self, name: str, joints: Mapping[int, Frames]) -> Frames:
        """The frame of an effector, given those of the joints."""
        record = next(e for e in self.module.effectors if e.name == name)
        return joints[record.joint].compose(frames(record.placement))


def _unit(poses: Any) -> Array:
    rows = np.array(poses, dtype=float)
    rows[..., 3:7] /= np.linalg.norm(rows[..., 3:7], axis=-1, keepdims=True)
    return rows


@dataclass(frozen=True, slots=True)
class Motion:
    """All samples of a plan.

    `times` `(T,)`; `ranges` first and last sample of each phase; `poses` `(T, 7)` of modules and of all bodies;
    `joints` `(T, n)` of modules; `frames` of every object: modules, effectors and bodies.
    """

    times: Array
    ranges: tuple[tuple[int, int], ...]
    poses: dict[str, Array]
    joints: dict[str, Array]
    frames: dict[str, Frames]
    joint_frames: dict[str, dict[int, Frames]]
    moving: frozenset[str]
    """Bodies that have a track, and all modules."""


def motion_of(plan: Plan, kinematics: Mapping[str, Kinematics]) -> Motion:
    """The samples as stored. The plan must be well formed."""
    poses = {t.name: np.asarray(t.poses) for t in plan.tracks}
    joints = {
        t.name: np.asarray(t.joints, dtype=float).reshape(len(plan.times), len(kinematics[t.name].module.joints))
        for t in plan.tracks
    }
    body_poses = {t.name: np.asarray(t.poses) for t in plan.body_tracks}
    moving = frozenset(poses) | frozenset(body_poses)
    for body in plan.bodies:
        resting = np.broadcast_to(np.asarray(body.pose), (len(plan.times), 7))
        poses[body.name] = body_poses.get(body.name, resting)
    return place(np.asarray(plan.times), phase_ranges(plan.times), poses, joints, moving, kinematics)


def place(
    times: Array,
    ranges: Sequence[tuple[int, int]],
    poses: dict[str, Array],
    joints: dict[str, Array],
    moving: frozenset[str],
    kinematics: Mapping[str, Kinematics],
) -> Motion:
    """Motion with the frames of everything, from poses and joints."""
    found: dict[str, Frames] = {}
    inner: dict[str, dict[int, Frames]] = {}
    for name, rows in poses.items():
        if name in kinematics:
            module = kinematics[name]
            inner[name] = module.joint_frames(rows, joints[name])
            found[name] = inner[name][-1]
            for effector in module.module.effectors:
                found[f"{name}.{effector.name}"] = module.effector(effector.name, inner[name])
        elif name in moving:
            found[name] = frames(rows)
        else:
            one = frames(rows[:1])
            found[name] = Frames(
                np.broadcast_to(one.position, (len(times), 3)),
                np.broadcast_to(one.rotation, (len(times), 3, 3)),
            )
    return Motion(times, tuple(ranges), poses, joints, found, inner, moving)
