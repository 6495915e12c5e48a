"""Where everything is at every sample of a plan, by forward kinematics built from the plan's own records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...compiler.ir import JointKind
from ...langs.frozen import dataclass
from ..native import load_pinocchio
from ..plan import JointRecord, ModuleRecord, Plan
from .findings import Findings
from .geometry import Array, Frames, HeldFrames, Indices, frames, frames_each
from .structure import Samples, phase_ranges, samples_of

REPEATED = 25
"""Every so many samples Pinocchio repeats the kinematics."""
AGREEMENT = 1e-9
"""How far the two may be apart: rounding."""


class Kinematics:
    """Forward kinematics of one module on a free-flying base, of all samples at once."""

    def __init__(self, module: ModuleRecord) -> None:
        self.module = module
        self._joints = [_Joint.of(joint) for joint in module.joints]

    def joint_frames(self, poses: Array, joints: Array) -> dict[int, Frames]:
        """The moving frame of every joint, and -1 for the module frame, for poses `(T, 7)`, joints `(T, n)`."""
        found = {-1: frames(poses)}
        for index, (record, joint) in enumerate(zip(self.module.joints, self._joints, strict=True)):
            found[index] = found[record.parent].compose(joint.moved(joints[:, index]))
        return found

    def effector(self, name: str, joints: Mapping[int, Frames]) -> Frames:
        """The frame of an effector, given those of the joints."""
        record = next(e for e in self.module.effectors if e.name == name)
        return joints[record.joint].compose(frames(record.placement))

    def disagreement(self, poses: Array, joints: Array, found: Mapping[int, Frames]) -> float:
        """How far entries of the frames `found`, positions in metres or those of rotation matrices, are from what
        Pinocchio computes, at most. Raises MissingLibrary."""
        peer, worst = _Peer(self.module), 0.0
        for t, row in enumerate(np.hstack([_unit(poses), joints])):
            for index, matrix in peer.placed(row).items():
                worst = max(worst, float(np.abs(matrix[:3, :3] - found[index].rotation[t]).max()))
                worst = max(worst, float(np.abs(matrix[:3, 3] - found[index].position[t]).max()))
        return worst


@dataclass(frozen=True, slots=True)
class _Joint:
    """The frame of a joint in that of its parent: `rest`, turned by the joint's value about its axis (formula of
    Rodrigues: `sine` and `versine` `(3, 3)` times those of the value), or moved by it along `slide` `(3,)`."""

    rest: Frames
    sine: Array
    versine: Array
    slide: Array | None

    @classmethod
    def of(cls, joint: JointRecord) -> _Joint:
        rest = frames(joint.placement)
        x, y, z = axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turned = rest.rotation[0] @ across
        slide = rest.rotation[0] @ axis if joint.kind == JointKind.PRISMATIC else None
        return cls(rest, turned, turned @ across, slide)

    def moved(self, values: Array) -> Frames:
        """The frames `(T,)` at the values `(T,)` of the joint, radians or metres."""
        if self.slide is not None:
            shape = (len(values), 3, 3)
            position = self.rest.position + values[:, None] * self.slide
            return Frames(position, np.broadcast_to(self.rest.rotation, shape))
        sine, versine = np.sin(values)[:, None, None], 1.0 - np.cos(values)[:, None, None]
        return Frames(self.rest.position, self.rest.rotation + sine * self.sine + versine * self.versine)


class _Peer:
    """The same module as a Pinocchio model."""

    def __init__(self, module: ModuleRecord) -> None:
        pinocchio = load_pinocchio()
        self._forward = pinocchio.forwardKinematics
        self._model = pinocchio.Model()
        base = self._model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "base")
        self._ids = [base]
        for joint in module.joints:
            axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
            kinds: dict[str, Any] = {
                JointKind.REVOLUTE: pinocchio.JointModelRevoluteUnaligned,
                JointKind.PRISMATIC: pinocchio.JointModelPrismaticUnaligned,
            }
            placement = pinocchio.XYZQUATToSE3(_unit(joint.placement))
            parent = self._ids[joint.parent + 1]
            self._ids.append(self._model.addJoint(parent, kinds[joint.kind](axis), placement, joint.name))
        self._data = self._model.createData()

    def placed(self, row: Array) -> dict[int, Array]:
        """Homogeneous matrices `(4, 4)` of all joints and, as -1, of the module, for pose and joint values."""
        self._forward(self._model, self._data, row)
        placements: Any = self._data.oMi
        return {k - 1: placements[index].homogeneous for k, index in enumerate(self._ids)}


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
    frames: dict[str, Frames | HeldFrames]
    joint_frames: dict[str, dict[int, Frames]]
    moving: frozenset[str]
    """Bodies that have a track, and all modules."""
    changes: dict[str, Indices]
    """Of every body that has a track: how often its pose has changed by each sample `(T,)`."""

    def frame(self, name: str) -> Frames | HeldFrames:
        """The frames `(T,)` of an object."""
        return self.frames[name]

    def parts(self, name: str) -> Mapping[int, Frames] | None:
        """The frames `(T,)` of a module by joint; None of what is no module."""
        return self.joint_frames.get(name)

    def rests(self, name: str, first: int, last: int) -> bool:
        """Whether an object is a body that has the very same pose at samples `first` … `last`."""
        changes = self.changes.get(name)
        if changes is None:
            return name in self.poses and name not in self.moving
        return bool(changes[first] == changes[last])


def motion_of(plan: Plan, kinematics: Mapping[str, Kinematics], samples: Samples | None = None) -> Motion:
    """The samples as stored. The plan must be well formed."""
    samples = samples_of(plan) if samples is None else samples
    moving = frozenset(samples.poses)
    poses = {t.name: samples.poses[t.name] for t in plan.tracks}
    at_rest = np.array([b.pose for b in plan.bodies], dtype=float).reshape(-1, 1, 7)
    for body, rows in zip(plan.bodies, np.broadcast_to(at_rest, (len(at_rest), len(plan.times), 7)), strict=True):
        poses[body.name] = samples.poses.get(body.name, rows)
    return place(np.asarray(plan.times), phase_ranges(plan.times), poses, samples.joints, moving, kinematics)


def place(
    times: Array,
    ranges: Sequence[tuple[int, int]],
    poses: dict[str, Array],
    joints: dict[str, Array],
    moving: frozenset[str],
    kinematics: Mapping[str, Kinematics],
) -> Motion:
    """Motion with the frames of everything, from poses and joints."""
    inner: dict[str, dict[int, Frames]] = {}
    changes: dict[str, Indices] = {}
    resting = {name: rows[0] for name, rows in poses.items() if name not in kinematics and name not in moving}
    found: dict[str, Frames | HeldFrames] = {**frames_each(resting, len(times))}
    for name, rows in poses.items():
        if name in kinematics:
            module = kinematics[name]
            inner[name] = module.joint_frames(rows, joints[name])
            found[name] = inner[name][-1]
            for effector in module.module.effectors:
                found[f"{name}.{effector.name}"] = module.effector(effector.name, inner[name])
        elif name in moving:
            changed = (rows[1:] != rows[:-1]).any(axis=1)
            changes[name] = np.concatenate([[0], np.cumsum(changed)])
            distinct = frames(rows[np.concatenate([[True], changed])])
            found[name] = HeldFrames(distinct, changes[name])
    return Motion(times, tuple(ranges), poses, joints, found, inner, moving, changes)


def check_kinematics(motion: Motion, kinematics: Mapping[str, Kinematics], findings: Findings) -> None:
    """Whether Pinocchio finds the same frames at every switch, and at every `REPEATED`-th sample between. Raises
    MissingLibrary."""
    some = np.array(sorted({*range(0, len(motion.times), REPEATED), *(end for _, end in motion.ranges)}))
    for name, module in kinematics.items():
        findings.check_time()
        found = {index: frame[some] for index, frame in motion.joint_frames[name].items()}
        off = module.disagreement(motion.poses[name][some], motion.joints[name][some], found)
        if not off <= AGREEMENT:
            findings.fail("kinematics", f"Pinocchio puts {name} elsewhere", amount=off, unit="m", between=[name])
