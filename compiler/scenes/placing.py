"""Where things stand at the start: the top faces of supports, and modules with one effector set down on them."""

from __future__ import annotations

import math

from ...langs.frozen import dataclass
from .. import ir
from ..extents import box_sides
from ..poses import between, compose, effector_pose, make, orientation, position, product, rotate, yaw

LEVEL = 1e-6
"""By how much the upward part of a unit normal may be below 1: 0.08 degrees, far above what rounding turns a frame."""
DOWN: ir.Vec3 = (0.0, 0.0, -1.0)


def top_of(shape: ir.Shape) -> float:
    """How far the highest point of an upright shape lies above its centre, metres."""
    return box_sides(shape)[2] / 2


def has_flat_top(shape: ir.Shape) -> bool:
    """Whether things can be put on an upright shape."""
    shape = shape.solids[0].shape
    if shape.kind != ir.ShapeKind.CONVEX:
        return shape.kind in (ir.ShapeKind.BOX, ir.ShapeKind.CYLINDER)
    from ..hulls import top_edges

    return len(top_edges(shape)[1]) > 0


@dataclass(frozen=True, slots=True)
class Support:
    """The top face of a body or of an end of a robot: the point of it above or below the middle, in the world, the
    heading of its x-axis, and the part of the shape that has it, with its place in the shape."""

    name: str
    type: str
    centre: ir.Vec3
    heading: float
    shape: ir.Shape
    at: ir.Vec3

    @staticmethod
    def of(body: ir.Body) -> Support:
        return Support._over(body.name, body.type, body.pose, body.shape)

    @staticmethod
    def _over(name: str, type_: str, frame: ir.Pose, shape: ir.Shape) -> Support:
        x, y, z = position(frame)
        axis = rotate(orientation(frame), (1.0, 0.0, 0.0))
        bearer = shape.solids[0]
        top = (x, y, z + bearer.at[2] + top_of(bearer.shape))
        return Support(name, type_, top, math.atan2(axis[1], axis[0]), bearer.shape, bearer.at)

    @staticmethod
    def of_end(name: str, module: ir.Module, end: ir.Effector) -> Support | None:
        """The top of an end of a robot, where its joints are at home; None where that is not level, or turned over and
        of a shape that has no other flat side."""
        assert end.shape is not None
        frame = compose(module.pose, effector_pose(module.type, end.name, module.joints))
        up = rotate(orientation(frame), (0.0, 0.0, 1.0))[2]
        upright = up > 1.0 - LEVEL
        solids = end.shape.solids
        alike = len(solids) == 1 and solids[0].shape.kind in (ir.ShapeKind.BOX, ir.ShapeKind.CYLINDER)
        if not upright and not (alike and up < LEVEL - 1.0):
            return None
        return Support._over(name, end.type, frame, end.shape)

    def point(self, at: tuple[float, float]) -> ir.Vec3:
        """The point of the top face at `at`, measured from its centre along its own axes, in the world."""
        dx, dy, _ = rotate(yaw(self.heading), (at[0], at[1], 0.0))
        return self.centre[0] + dx, self.centre[1] + dy, self.centre[2]

    def carries(self, at: tuple[float, float]) -> bool:
        at = at[0] - self.at[0], at[1] - self.at[1]
        if self.shape.kind == ir.ShapeKind.CONVEX:
            from ..hulls import top_edges

            normals, offsets = top_edges(self.shape)
            return bool((normals @ at <= offsets + 1e-9).all())
        width, depth, _ = box_sides(self.shape)
        if self.shape.kind == ir.ShapeKind.CYLINDER:
            return math.hypot(*at) <= width / 2 + 1e-9
        return abs(at[0]) <= width / 2 + 1e-9 and abs(at[1]) <= depth / 2 + 1e-9

    @property
    def extent(self) -> str:
        width, depth, _ = box_sides(self.shape)
        if self.shape.kind == ir.ShapeKind.CYLINDER:
            return f"round with radius {width / 2:g} m"
        return f"{'within ' if self.shape.kind == ir.ShapeKind.CONVEX else ''}{width:g} m by {depth:g} m"


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
