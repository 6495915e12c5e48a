"""CasADi kinematics against Pinocchio, on random trees of revolute and prismatic joints."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pinocchio as pin
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.compiler.ir import Effector, Joint, ModuleType
from tamplang.compiler.motion.kinematics import effector_frame, joint_frames

numbers = st.floats(-1.5, 1.5, allow_nan=False).map(lambda x: round(x, 3))


def unit(values: list[float], fallback: int) -> tuple[float, ...]:
    vector = np.array(values)
    if np.linalg.norm(vector) < 0.1:
        vector = np.eye(len(values))[fallback]
    return tuple(float(v) for v in vector / np.linalg.norm(vector))


@st.composite
def modules(draw: st.DrawFn) -> ModuleType:
    joints = []
    for i in range(draw(st.integers(1, 6))):
        placement = [draw(numbers) for _ in range(3)], unit([draw(numbers) for _ in range(4)], 3)
        axis = unit([draw(numbers) for _ in range(3)], 2)
        kind = draw(st.sampled_from(["revolute", "prismatic"]))
        parent = draw(st.integers(-1, i - 1))
        joints.append(Joint(f"j{i}", kind, parent, (*placement[0], *placement[1]), axis, -3.0, 3.0, 0.0, 1.0))
    tip = ([draw(numbers) for _ in range(3)], unit([draw(numbers) for _ in range(4)], 3))
    carrier = draw(st.integers(-1, len(joints) - 1))
    return ModuleType("tree", tuple(joints), (Effector("E", "effector", carrier, (*tip[0], *tip[1]), None),), ())


def placement_of(pose: tuple[float, ...]) -> pin.SE3:
    return pin.XYZQUATToSE3(np.array(pose))


def pinocchio_frames(kind: ModuleType, slot: np.ndarray) -> list[pin.SE3]:
    model = pin.Model()
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    numbers_of = [root]
    for joint in kind.joints:
        axis = np.array(joint.axis)
        revolute = joint.kind == "revolute"
        made = pin.JointModelRevoluteUnaligned(axis) if revolute else pin.JointModelPrismaticUnaligned(axis)
        parent = numbers_of[joint.parent + 1]
        numbers_of.append(model.addJoint(parent, made, placement_of(joint.placement), joint.name))
    data = model.createData()
    configuration = np.zeros(model.nq)
    configuration[:7] = slot[:7]
    configuration[3:7] /= np.linalg.norm(slot[3:7])
    for number, value in zip(numbers_of[1:], slot[7:], strict=True):
        configuration[model.joints[number].idx_q] = value
    pin.forwardKinematics(model, data, configuration)
    return [data.oMi[number] for number in numbers_of]


@settings(max_examples=40, deadline=None)
@given(modules(), st.integers(0, 1000))
def test_frames_agree_with_pinocchio(kind: ModuleType, seed: int) -> None:
    random = np.random.default_rng(seed)
    slot = np.concatenate([random.normal(size=7), random.uniform(-2, 2, len(kind.joints))])
    symbol = ca.SX.sym("x", len(slot))
    frames = [*joint_frames(kind, symbol), effector_frame(kind, "E", symbol)]
    flat = ca.vertcat(*[ca.vertcat(f.position, f.quaternion) for f in frames])
    values = np.array(ca.Function("f", [symbol], [flat])(slot)).reshape(-1, 7)
    expected = pinocchio_frames(kind, slot)
    effector = kind.effectors[0]
    expected.append(expected[effector.joint + 1] * placement_of(effector.placement))
    for found, wanted in zip(values, expected, strict=True):
        assert np.allclose(placement_of(found).homogeneous, wanted.homogeneous, atol=1e-10)
