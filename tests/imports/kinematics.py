"""Where the links of a URDF are, by Pinocchio: what importers wrote, read by others."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence

import pinocchio

from tamplang.compiler.poses import Pose, about, make

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def apart(axis: str, angle: float) -> Pose:
    """A turn about an axis."""
    return make((0.0, 0.0, 0.0), about(AXES[axis], angle))


def spread(names: Sequence[str], count: int) -> Iterator[dict[str, float]]:
    """Random values of joints."""
    draw = random.Random(1)
    for _ in range(count):
        yield {name: draw.uniform(-1, 1) for name in names}


def poses(urdf: str, values: Mapping[str, float]) -> dict[str, Pose]:
    """The frames of links, with the joints at some values."""
    text = urdf.replace("<mimic", "<ignored")
    model = pinocchio.buildModelFromXML(text)
    q = pinocchio.neutral(model)
    for name, joint in zip(model.names, model.joints, strict=True):
        if name in values:
            value = values[name]
            q[joint.idx_q : joint.idx_q + joint.nq] = [value] if joint.nq == 1 else [math.cos(value), math.sin(value)]
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    found: dict[str, Pose] = {}
    for frame, place in zip(model.frames, data.oMf, strict=True):
        if frame.type == pinocchio.FrameType.BODY:
            x, y, z, i, j, k, w = pinocchio.SE3ToXYZQUAT(place).tolist()
            found[frame.name] = (x, y, z, i, j, k, w)
    return found
