"""The report's own forward kinematics against Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio

from tamplang.runtime.geometry.transforms import compose
from tamplang.runtime.plan import JointRecord, ModuleRecord
from tamplang.runtime.report.kinematics import joint_frames, pose_rows

from .sample import crawler


def peer_frames(module: ModuleRecord, base: list[float], joints: list[float]) -> list[list[float]]:
    model = pinocchio.Model()
    ids = [0]
    for joint in module.joints:
        revolute = joint.kind == "revolute"
        kind = pinocchio.JointModelRevoluteUnaligned if revolute else pinocchio.JointModelPrismaticUnaligned
        placement = pinocchio.XYZQUATToSE3(np.array(joint.placement))
        if joint.parent < 0:
            placement = pinocchio.XYZQUATToSE3(np.array(base)) * placement
        ids.append(model.addJoint(ids[joint.parent + 1], kind(np.array(joint.axis)), placement, joint.name))
    data = model.createData()
    pinocchio.forwardKinematics(model, data, np.array(joints))
    return [pinocchio.SE3ToXYZQUAT(data.oMi[i]).tolist() for i in ids[1:]]


def same_pose(left: np.ndarray, right: list[float]) -> bool:
    other = np.array(right)
    other[3:] *= np.sign(other[3:] @ left[3:])
    return bool(np.allclose(left, other, atol=1e-12))


def test_agrees_with_pinocchio() -> None:
    random = np.random.default_rng(1)
    turn = [0.1, -0.2, 0.3, 0.9]
    slide = JointRecord("slide", "prismatic", 2, [0.1, 0.2, 0.3, *pose_rows([[0, 0, 0, *turn]])[0, 3:]],
                        [0.6, 0.0, 0.8], -1.0, 1.0, 1.0)  # fmt: skip
    plain = crawler("c", [0.0] * 7)
    module = ModuleRecord("c", "c", [*plain.joints, slide], [], [], [0.0] * 7, [0.0] * 8)
    base = pose_rows([[0.4, -0.3, 0.2, *random.normal(size=4)] for _ in range(5)])
    joints = random.normal(size=(5, 8))
    frames = joint_frames(module, base, joints)
    for row in range(5):
        expected = peer_frames(module, base[row].tolist(), joints[row].tolist())
        assert all(same_pose(f[row], e) for f, e in zip(frames[1:], expected, strict=True))


def test_compose_broadcasts() -> None:
    poses = pose_rows([[1, 2, 3, 0, 0, 1, 1]] * 4)
    assert compose(poses[:1], poses).shape == (4, 7)
    assert compose(poses, poses[:1]).shape == (4, 7)
