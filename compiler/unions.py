"""Bodies that are not convex, as several convex parts."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .hulls import convex_shape, corners_around, top_outline
from .ir import Shape, ShapeKind, SolidPart, Vec3

SAME = 1e-2
"""Share by which flat tops may differ in area and are equally large: of those, the highest bears."""


def union(parts: Sequence[tuple[Vec3, Shape]]) -> tuple[Shape, Vec3]:
    """Shapes at places in one frame as one shape, and where the middle of the box around it lies, which becomes its
    origin. One part alone is that part. Raises HullError."""
    flat = _flat(parts)
    if len(flat) == 1:
        return flat[0][1], flat[0][0]
    around, middle, _ = convex_shape(np.concatenate([corners_around(shape) + at for at, shape in flat]))
    back = (-middle[0], -middle[1], -middle[2])
    return _made(around.size, [SolidPart(_sum(at, back), shape) for at, shape in flat]), middle


def union_in_place(parts: Sequence[tuple[Vec3, Shape]]) -> Shape:
    """The same, with the frame that the places are given in as its own: what is around it all need not have its middle
    there. Raises HullError."""
    flat = _flat(parts)
    if len(flat) == 1 and not any(flat[0][0]):
        return flat[0][1]
    around, middle, _ = convex_shape(np.concatenate([corners_around(shape) + at for at, shape in flat]))
    corners = np.reshape(around.size, (-1, 3)) + middle
    return _made(tuple(float(v) for v in corners.ravel()), [SolidPart(at, shape) for at, shape in flat])


def _flat(parts: Sequence[tuple[Vec3, Shape]]) -> list[tuple[Vec3, Shape]]:
    return [(_sum(at, part.at), part.shape) for at, shape in parts for part in shape.solids]


def _made(around: tuple[float, ...], solids: Sequence[SolidPart]) -> Shape:
    first = _bearer(solids)
    return Shape(ShapeKind.CONVEX, around, (first, *(s for s in solids if s is not first)))


def _bearer(solids: Sequence[SolidPart]) -> SolidPart:
    """The part with the largest flat top."""
    areas = [_top(part.shape) for part in solids]
    large = [part for part, area in zip(solids, areas, strict=True) if area >= (1.0 - SAME) * max(areas)]
    return max(large, key=lambda part: part.at[2] + float(corners_around(part.shape)[:, 2].max()))


def _top(shape: Shape) -> float:
    """The area of the flat top, square metres."""
    if shape.kind == ShapeKind.BOX:
        return shape.size[0] * shape.size[1]
    if shape.kind == ShapeKind.CYLINDER:
        return math.pi * shape.size[0] ** 2
    if shape.kind != ShapeKind.CONVEX:
        return 0.0
    x, y = top_outline(shape).T
    return float(abs(x @ np.roll(y, 1) - y @ np.roll(x, 1))) / 2.0


def _sum(a: Vec3, b: Vec3) -> Vec3:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]
