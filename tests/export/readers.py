"""What others' tools make of exported files, in the terms of the plan."""

from __future__ import annotations

import csv
from itertools import pairwise
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from numpy.typing import ArrayLike, NDArray

from tamplang.runtime.export import write
from tamplang.runtime.export.motion import module_of, moved, poses, times, trajectory
from tamplang.runtime.plan import Plan

Array = NDArray[np.float64]


def placed(pose: ArrayLike) -> pinocchio.SE3:
    return pinocchio.XYZQUATToSE3(np.asarray(pose, dtype=float))


def apart(one: pinocchio.SE3, other: pinocchio.SE3) -> float:
    """The largest difference of two poses, metres or entries of rotation matrices."""
    return float(np.abs(one.homogeneous - other.homogeneous).max())


def check_tables(plan: Plan, folder: Path) -> None:
    """CSV by the csv module and NPZ by NumPy: the samples of the plan."""
    write(plan, "csv", folder / "a.csv")
    write(plan, "npz", folder / "a.npz")
    with (folder / "a.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    kept = np.concatenate([[True], np.diff(plan.times) > 0])
    with np.load(folder / "a.npz") as arrays:
        assert np.array_equal(arrays["time"], np.array(plan.times)[kept])
        for track in plan.tracks:
            names = [j.name for j in module_of(plan, track.name).joints]
            stored = np.array(track.joints).reshape(len(kept), len(names))[kept]
            assert np.abs(arrays[f"{track.name}/q"] - stored).max(initial=0.0) < 1e-6
            for found, wanted in zip(arrays[f"{track.name}/poses"], np.array(track.poses)[kept], strict=True):
                assert apart(placed(found), placed(wanted)) < 1e-9
            told = [[float(r[f"{track.name}.{n}"]) for n in names] for r in rows]
            table = np.array(told).reshape(len(rows), len(names))
            assert np.array_equal(table, arrays[f"{track.name}/q"])


def check_rates(plan: Plan) -> None:
    """Rates and accelerations are the derivatives of the values."""
    step = 1e-5
    for module in plan.modules:
        for spline in (s for s in plan.splines if s.module == module.name):
            at = np.linspace(spline.knots[0] + 0.01, spline.knots[-1] - 0.01, 7)
            before, here, after = (trajectory(plan, module.name, at + d) for d in (-step, 0.0, step))
            assert np.allclose((after.q - before.q) / (2 * step), here.dq, atol=1e-5)
            assert np.allclose((after.dq - before.dq) / (2 * step), here.ddq, atol=2e-3, rtol=1e-3)


def check_ros2(plan: Plan, folder: Path) -> None:
    """What the joint trajectory controller asks of its messages, and that they are the motion."""
    write(plan, "ros2", folder / "a.yaml", rate=50.0)
    messages = list(yaml.safe_load_all((folder / "a.yaml").read_text()))
    assert len({(m["phase"], m["module"]) for m in messages}) == len(messages)
    for message in messages:
        points, names = message["trajectory"]["points"], message["trajectory"]["joint_names"]
        stamps = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in points]
        assert stamps[0] > 0 and all(b > a for a, b in pairwise(stamps))
        assert names == [f"{message['module']}.{j.name}" for j in module_of(plan, message["module"]).joints]
        assert not any(points[-1]["velocities"])
        motion = trajectory(plan, message["module"], np.array(stamps) + message["start"])
        assert np.abs(motion.q - [p["positions"] for p in points]).max() < 1e-6
        assert abs(stamps[-1] - (plan.phases[message["phase"]].end - message["start"])) < 1e-8


def check_bag(plan: Plan, folder: Path) -> None:
    """A bag as the reader of MCAP decodes it by the definitions in it, and poses as YAML: both are the motion."""
    write(plan, "mcap", folder / "a.mcap", rate=20.0)
    write(plan, "multidof", folder / "a.poses.yaml", rate=20.0)
    documents = list(yaml.safe_load_all((folder / "a.poses.yaml").read_text()))
    assert [d["phase"] for d in documents] == list(range(len(plan.phases)))
    told: dict[str, int] = {}
    first = {f"{m.name}.{m.joints[0].name}": m.name for m in plan.modules if m.joints}
    with (folder / "a.mcap").open("rb") as stream:
        found = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
        for schema, channel, message, decoded in found:
            start = message.log_time * 1e-9
            stamps = np.array([p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in decoded.points])
            assert stamps[0] > 0 and (np.diff(stamps) > 0).all()
            if schema.name == "trajectory_msgs/msg/JointTrajectory":
                module = first[decoded.joint_names[0]]
                motion = trajectory(plan, module, stamps + start)
                assert np.abs(motion.q - [p.positions for p in decoded.points]).max() < 1e-6
                assert not any(decoded.points[-1].velocities)
                continue
            assert schema.name == "trajectory_msgs/msg/MultiDOFJointTrajectory" and decoded.header.frame_id == "world"
            document = documents[told.get(channel.topic, 0)]["trajectory"]
            assert list(decoded.joint_names) == document["joint_names"]
            for k, name in enumerate(decoded.joint_names):
                wanted = poses(plan, name, stamps + start)
                for point, written, pose in zip(decoded.points, document["points"], wanted, strict=True):
                    t, r = point.transforms[k].translation, point.transforms[k].rotation
                    assert apart(placed([t.x, t.y, t.z, r.x, r.y, r.z, r.w]), placed(pose)) < 1e-6
                    t, r = written["transforms"][k]["translation"], written["transforms"][k]["rotation"]
                    assert [*t.values(), *r.values()] == pytest.approx(pose.tolist(), abs=1e-6)
            told[channel.topic] = told.get(channel.topic, 0) + 1
    assert told == {"/poses": len(plan.phases)}


def check_urdf(plan: Plan, folder: Path, phase: int) -> int:
    """Pinocchio's frames of the exported robot against the poses of the plan; how many modules the robot has."""
    first = plan.modules[0].name
    write(plan, "urdf", folder / "a.urdf", module=first, phase=phase)
    model = pinocchio.buildModelFromUrdf(str(folder / "a.urdf"))
    data = model.createData()
    names = {f.name for f in model.frames if f.type == pinocchio.FrameType.BODY}
    inside = [m for m in plan.modules if m.name in names]
    stamps = times(plan)
    if phase < len(plan.phases):
        stamps = stamps[(stamps >= plan.phases[phase].start) & (stamps <= plan.phases[phase].end)]
    for time in (stamps[0], stamps[len(stamps) // 2], stamps[-1]) if phase < len(plan.phases) else stamps[-1:]:
        at = np.array([time])
        values = pinocchio.neutral(model)
        for module in inside:
            motion = trajectory(plan, module.name, at)
            for joint, value in zip(motion.joints, motion.q[0], strict=True):
                values[model.joints[model.getJointId(f"{module.name}.{joint}")].idx_q] = value
        pinocchio.framesForwardKinematics(model, data, values)
        base = placed(poses(plan, first, at)[0])
        known = [*(m.name for m in inside), *(f"{m.name}.{e.name}" for m in inside for e in m.effectors)]
        for name in known:
            found = base * data.oMf[model.getFrameId(name, pinocchio.FrameType.BODY)]
            assert apart(found, placed(poses(plan, name, at)[0])) < 1e-6, name
    return len(inside)


def check_mjcf(plan: Plan, folder: Path) -> int:
    """MuJoCo's poses at every key frame against those of the plan; how many welds there are."""
    write(plan, "mjcf", folder / "a.xml")
    model = mujoco.MjModel.from_xml_path(str(folder / "a.xml"))
    data = mujoco.MjData(model)
    stamps = times(plan)
    assert model.nkey == len(stamps)
    names = [*(m.name for m in plan.modules), *moved(plan)]
    names += [f"{m.name}.{e.name}" for m in plan.modules for e in m.effectors]
    expected = {name: poses(plan, name) for name in names}
    for key in sorted({0, model.nkey // 3, model.nkey // 2, model.nkey - 1}):
        mujoco.mj_resetDataKeyframe(model, data, key)
        mujoco.mj_kinematics(model, data)
        assert abs(data.time - stamps[key]) < 1e-9
        for name, wanted in expected.items():
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
            found = pinocchio.SE3(data.xmat[body].reshape(3, 3), data.xpos[body])
            assert apart(found, placed(wanted[key])) < 1e-6, name
    return int((model.eq_type == mujoco.mjtEq.mjEQ_WELD).sum())
