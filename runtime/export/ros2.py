"""Motion as messages of ROS 2, one per phase: `trajectory_msgs/JointTrajectory` of each module, and
`trajectory_msgs/MultiDOFJointTrajectory` with the poses of modules and of bodies that move; in YAML, or in a bag.

Within the rules of the ROS 2 joint trajectory controller: times from the start of the phase, above 0 and strictly
increasing, the same joints in each point, and no rate at the end.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ...langs.frozen import dataclass
from ..native import load_extra
from ..plan import Plan
from .motion import Array, moved, poses, times, trajectory

TOPIC = "joint_trajectory"
POSES_TOPIC = "/poses"
FRAME = "world"


@dataclass(frozen=True, slots=True)
class JointMessage:
    """The joints of `module` in `phase`, which begins at `start` seconds: times `t` (T,) from there, and values, rates
    and accelerations (T, joints)."""

    phase: int
    module: str
    start: float
    joints: tuple[str, ...]
    t: Array
    q: Array
    dq: Array
    ddq: Array


@dataclass(frozen=True, slots=True)
class PoseMessage:
    """The poses (N, T, 7) of the things `names` in `phase`, in the world."""

    phase: int
    start: float
    names: tuple[str, ...]
    t: Array
    poses: Array


def trajectories(plan: Plan, rate: float | None) -> bytes:
    """YAML documents, each with `phase`, `action`, `module`, `start` (seconds) and `trajectory`, the message."""
    texts = []
    for m in joint_messages(plan, rate):
        points = [_point(time, m.q[k], m.dq[k], m.ddq[k]) for k, time in enumerate(m.t)]
        head = f"---\n{_phase(plan, m.phase)}module: {json.dumps(m.module)}\nstart: {m.start!r}\ntrajectory:\n"
        names = f"  joint_names: {json.dumps(m.joints)}\n  points:\n"
        texts.append(f"{head}  header: {{frame_id: ''}}\n{names}" + "".join(points))
    return "".join(texts).encode()


def multi_dof(plan: Plan, rate: float | None) -> bytes:
    """YAML documents, each with `phase`, `action`, `start` and `trajectory`, the message."""
    texts = []
    for m in pose_messages(plan, rate):
        head = f"---\n{_phase(plan, m.phase)}start: {m.start!r}\ntrajectory:\n  header: {{frame_id: {FRAME}}}\n"
        points = []
        for k, time in enumerate(m.t):
            told = [_transform(row) for row in m.poses[:, k].tolist()]
            points.append(f"  - {{transforms: [{', '.join(told)}], time_from_start: {_stamp(time)}}}\n")
        texts.append(f"{head}  joint_names: {json.dumps(m.names)}\n  points:\n{''.join(points)}")
    return "".join(texts).encode()


def bag(plan: Plan, rate: float | None) -> bytes:
    """An MCAP bag that `ros2 bag play` plays: on `/MODULE/joint_trajectory` and `/poses` the messages of each phase, at
    the time of its start. Raises MissingLibrary without the extra `ros`."""
    rosbag2, typesys = load_extra("rosbags.rosbag2", "ros"), load_extra("rosbags.typesys", "ros")
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    topics = _topics([m.name for m in plan.modules])
    told: list[tuple[float, str, Any]] = []
    for joint in joint_messages(plan, rate):
        told.append((joint.start, topics[joint.module], _joint_message(store, joint)))
    for pose in pose_messages(plan, rate):
        told.append((pose.start, POSES_TOPIC, _pose_message(store, pose)))
    with TemporaryDirectory() as folder:
        target = Path(folder) / "bag"
        with rosbag2.Writer(target, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
            connections: dict[str, Any] = {}
            for start, topic, message in sorted(told, key=lambda m: m[0]):
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=store)
                writer.write(connections[topic], round(start * 1e9), store.serialize_cdr(message, kind))
        (file,) = target.glob("*.mcap")
        return file.read_bytes()


def joint_messages(plan: Plan, rate: float | None) -> Iterator[JointMessage]:
    """One for each module and phase in which a spline moves it."""
    instants = list(_instants(plan, rate))
    every = np.concatenate([np.zeros(0), *(at for _, at in instants)])
    motions = {m.name: trajectory(plan, m.name, every) for m in plan.modules if m.joints}
    begin = 0
    for index, at in instants:
        start, part = plan.phases[index].start, slice(begin, begin + len(at))
        begin = part.stop
        for name, motion in motions.items():
            splines = [s for s in plan.splines if s.module == name and s.first <= index <= s.until]
            if not splines:
                continue
            if splines[-1].until == index:
                motion.dq[part.stop - 1] = 0.0
            names = tuple(f"{name}.{j}" for j in motion.joints)
            yield JointMessage(index, name, start, names, at - start, motion.q[part], motion.dq[part], motion.ddq[part])


def pose_messages(plan: Plan, rate: float | None) -> Iterator[PoseMessage]:
    """One for each phase."""
    names = (*(m.name for m in plan.modules), *moved(plan))
    instants = list(_instants(plan, rate)) if names else []
    every = np.concatenate([np.zeros(0), *(at for _, at in instants)])
    tracks, begin = [poses(plan, name, every) for name in names], 0
    for index, at in instants:
        start, part = plan.phases[index].start, slice(begin, begin + len(at))
        begin = part.stop
        yield PoseMessage(index, start, names, at - start, np.stack([track[part] for track in tracks]))


def _instants(plan: Plan, rate: float | None) -> Iterator[tuple[int, Array]]:
    """Each phase with its times, its end the last of them."""
    stamps = times(plan, rate)
    for index, phase in enumerate(plan.phases):
        inside = stamps[(stamps > phase.start + 1e-9) & (stamps < phase.end - 1e-9)]
        yield index, np.append(inside, phase.end)


def _topics(modules: list[str]) -> dict[str, str]:
    """Topics of modules: letters, digits and underscores, no two alike."""
    found: dict[str, str] = {}
    for name in modules:
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "module"
        plain = f"m_{plain}" if plain[0].isdigit() else plain
        while f"/{plain}/{TOPIC}" in found.values():
            plain += "_2"
        found[name] = f"/{plain}/{TOPIC}"
    return found


def _joint_message(store: Any, m: JointMessage) -> Any:
    types = store.types
    point = types["trajectory_msgs/msg/JointTrajectoryPoint"]
    points = [
        point(m.q[k], m.dq[k], m.ddq[k], np.zeros(0), _duration(types, time)) for k, time in enumerate(m.t)
    ]  # fmt: skip
    return types["trajectory_msgs/msg/JointTrajectory"](_header(types, m.start, ""), list(m.joints), points)


def _pose_message(store: Any, m: PoseMessage) -> Any:
    types = store.types
    transform, vector = types["geometry_msgs/msg/Transform"], types["geometry_msgs/msg/Vector3"]
    quaternion = types["geometry_msgs/msg/Quaternion"]
    point = types["trajectory_msgs/msg/MultiDOFJointTrajectoryPoint"]
    points = []
    for k, time in enumerate(m.t):
        told = [transform(vector(*row[:3]), quaternion(*row[3:])) for row in m.poses[:, k].tolist()]
        points.append(point(told, [], [], _duration(types, time)))
    kind = types["trajectory_msgs/msg/MultiDOFJointTrajectory"]
    return kind(_header(types, m.start, FRAME), list(m.names), points)


def _header(types: Any, start: float, frame: str) -> Any:
    seconds, nanoseconds = _split(start)
    return types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](seconds, nanoseconds), frame)


def _duration(types: Any, time: float) -> Any:
    return types["builtin_interfaces/msg/Duration"](*_split(time))


def _phase(plan: Plan, index: int) -> str:
    return f"phase: {index}\naction: {json.dumps(plan.phases[index].action)}\n"


def _split(time: float) -> tuple[int, int]:
    return divmod(round(float(time) * 1e9), 1_000_000_000)


def _stamp(time: float) -> str:
    seconds, nanoseconds = _split(time)
    return f"{{sec: {seconds}, nanosec: {nanoseconds}}}"


def _transform(pose: list[float]) -> str:
    x, y, z, qx, qy, qz, qw = pose
    turn = f"{{x: {qx!r}, y: {qy!r}, z: {qz!r}, w: {qw!r}}}"
    return f"{{translation: {{x: {x!r}, y: {y!r}, z: {z!r}}}, rotation: {turn}}}"


def _point(time: float, q: Array, dq: Array, ddq: Array) -> str:
    rows = ("positions", q), ("velocities", dq), ("accelerations", ddq)
    told = ", ".join(f"{name}: {json.dumps(values.tolist())}" for name, values in rows)
    return f"  - {{{told}, time_from_start: {_stamp(time)}}}\n"
