"""The forms that shapes are drawn with, and what a canvas is that they are drawn on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...compiler.hulls import hull
from ...compiler.ir import Shape, ShapeKind
from ..geometry.transforms import Array
from ..plan import ShapeRecord
from .kinematics import pose_rows

UPRIGHT = (0.0, 0.0, 0.0, 0.7071067811865476, 0.0, 0.0, 0.7071067811865476)


@dataclass(frozen=True, slots=True)
class DrawnForm:
    """A `box` of three sides, a `ball` of a radius, a `tube` of a length along y and a radius, or a `hull` of
    `corners` (C, 3) and `triangles` (T, 3) that look outward; metres."""

    kind: str
    size: tuple[float, ...] = ()
    corners: Array | None = None
    triangles: NDArray[np.int64] | None = None


class Canvas(Protocol):
    """What a scene is drawn on: forms at paths such as "module0/frame1/link0/box", each in the frame above."""

    def draw(self, path: str, form: DrawnForm, colour: str) -> None: ...

    def place(self, path: str, pose: Array) -> None: ...


def matrix(pose: Array) -> Array:
    """Homogeneous matrix `(4, 4)` of one pose `(7,)`."""
    x, y, z, w = pose[3:]
    result = np.eye(4)
    result[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    result[:3, 3] = pose[:3]
    return result


def parts(shape: ShapeRecord) -> list[tuple[str, DrawnForm, Array]]:
    """Name, form and placement of every part of a shape; none for an unknown shape."""
    if shape.parts:
        return [
            (f"part{number}-{name}", form, np.add(pose, [*part.at, 0.0, 0.0, 0.0, 0.0]))
            for number, part in enumerate(shape.parts) for name, form, pose in parts(part.shape)
        ]  # fmt: skip
    size = tuple(float(s) for s in shape.size)
    centre, upright = pose_rows([(0, 0, 0, 0, 0, 0, 1)])[0], pose_rows([UPRIGHT])[0]
    if shape.kind == ShapeKind.BOX and len(size) == 3:
        return [("box", DrawnForm("box", size), centre)]
    if shape.kind == ShapeKind.SPHERE and len(size) == 1:
        return [("ball", DrawnForm("ball", size), centre)]
    if shape.kind == ShapeKind.CONVEX:
        body = hull(Shape(ShapeKind.CONVEX, size))
        return [("hull", DrawnForm("hull", (), body.corners, body.triangles), centre)]
    if shape.kind in (ShapeKind.CAPSULE, ShapeKind.CYLINDER) and len(size) == 2:
        radius, length = size
        result = [("tube", DrawnForm("tube", (length, radius)), upright)]
        if shape.kind == ShapeKind.CAPSULE:
            for name, side in (("low", -0.5), ("high", 0.5)):
                cap = centre.copy()
                cap[2] = side * length
                result.append((name, DrawnForm("ball", (radius,)), cap))
        return result
    return []
