"""Where things stand at the start: the top faces of supports, and modules with one effector set down on them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .. import ir
from ..poses import between, effector_pose, make, orientation, position, product, rotate, yaw

DOWN: ir.Vec3 = (0.0, 0.0, -1.0)


def top_of(shape: ir.Shape) -> float:
    """How far the highest point of an upright shape lies above its centre, metres."""
    if shape.kind == "box":
        return shape.size[2] / 2
    if shape.kind == "sphere":
        return shape.size[0]
    return shape.size[1] / 2 + (shape.size[0] if shape.kind == "capsule" else 0.0)


@dataclass(frozen=True, slots=True)
class Support:
    """The top face of a body: its centre in the world, the heading of its x-axis, and its outline. `half` holds the
    half sizes of a box, or the radius of a cylinder."""

    name: str
    type: str
    centre: ir.Vec3
    heading: float
    half: tuple[float, ...]

    @staticmethod
    def of(body: ir.Body) -> Support:
        x, y, z = position(body.pose)
        axis = rotate(orientation(body.pose), (1.0, 0.0, 0.0))
        half = (body.shape.size[0] / 2, body.shape.size[1] / 2) if body.shape.kind == "box" else body.shape.size[:1]
        return Support(body.name, body.type, (x, y, z + top_of(body.shape)), math.atan2(axis[1], axis[0]), half)

    def point(self, at: tuple[float, float]) -> ir.Vec3:
        """The point of the top face at `at`, measured from its centre along its own axes, in the world."""
        dx, dy, _ = rotate(yaw(self.heading), (at[0], at[1], 0.0))
        return self.centre[0] + dx, self.centre[1] + dy, self.centre[2]

    def carries(self, at: tuple[float, float]) -> bool:
        if len(self.half) == 1:
            return math.hypot(*at) <= self.half[0] + 1e-9
        return abs(at[0]) <= self.half[0] + 1e-9 and abs(at[1]) <= self.half[1] + 1e-9

    @property
    def extent(self) -> str:
        if len(self.half) == 1:
            return f"round with radius {self.half[0]:g} m"
        return f"{2 * self.half[0]:g} m by {2 * self.half[1]:g} m"


def module_pose(module: ir.ModuleType, effector: str, point: ir.Vec3, heading: float) -> ir.Pose:
    """The pose of the module frame that sets `effector` down on `point`: its normal points down, its shape touches the
    point from above, the x-axis of the module frame has that heading; joints at home."""
    homes = [j.home for j in module.joints]
    frame = effector_pose(module, effector, homes)
    normal = rotate(orientation(frame), (0.0, 0.0, 1.0))
    upright = between(normal, DOWN)
    x_axis = rotate(upright, (1.0, 0.0, 0.0))
    own = math.atan2(x_axis[1], x_axis[0]) if math.hypot(x_axis[0], x_axis[1]) > 1e-9 else 0.0
    turn = product(yaw(heading - own), upright)
    shape = module.effector(effector).shape
    height = top_of(shape) if shape is not None else 0.0
    offset = rotate(turn, position(frame))
    return make((point[0] - offset[0], point[1] - offset[1], point[2] + height - offset[2]), turn)
