"""How large shapes are, along their own axes. Metres."""

from __future__ import annotations

from collections.abc import Iterator

from .ir import Shape, ShapeKind, Vec3


def box_sides(shape: Shape) -> Vec3:
    """The sizes of the box around a shape along its own axes; its frame is in the middle of that box."""
    size = shape.size
    if shape.kind == ShapeKind.BOX:
        return size[0], size[1], size[2]
    if shape.kind == ShapeKind.SPHERE:
        return 2 * size[0], 2 * size[0], 2 * size[0]
    if shape.kind == ShapeKind.CONVEX:
        x, y, z = (max(size[i::3]) - min(size[i::3]) for i in range(3))
        return x, y, z
    return 2 * size[0], 2 * size[0], size[1] + (2 * size[0] if shape.kind == ShapeKind.CAPSULE else 0.0)


def corners(shape: Shape) -> Iterator[Vec3]:
    """The corners of a shape of kind "convex", in its own frame."""
    for i in range(0, len(shape.size), 3):
        yield shape.size[i], shape.size[i + 1], shape.size[i + 2]
