"""Shapes of bodies, links and effectors, as the IR has them; metres."""

from __future__ import annotations

from enum import StrEnum

from ..langs.frozen import dataclass

Vec3 = tuple[float, float, float]
Pose = tuple[float, float, float, float, float, float, float]


class ShapeKind(StrEnum):
    """A convex shape is the hull of corners, from a mesh or a list."""

    BOX = "box"
    SPHERE = "sphere"
    CAPSULE = "capsule"
    CYLINDER = "cylinder"
    CONVEX = "convex"


@dataclass(frozen=True, slots=True)
class Shape:
    """`size` in metres: box (x, y, z), sphere (radius,), capsule and cylinder (radius, length along z without caps),
    convex (the coordinates of all corners in turn, of a hull whose box along the axes has its middle at the origin).
    A body or effector that is not convex is made of `parts`; what is around them all is convex, and its box has its
    middle at the origin of a body's shape, but not of an effector's. The first part is the one that has the largest
    flat top, on which things stand."""

    kind: ShapeKind
    size: tuple[float, ...]
    parts: tuple[SolidPart, ...] = ()

    @property
    def solids(self) -> tuple[SolidPart, ...]:
        """The convex shapes that it is made of: its parts, or itself."""
        return self.parts or (SolidPart((0.0, 0.0, 0.0), self),)


@dataclass(frozen=True, slots=True)
class SolidPart:
    """A convex part of a shape, its frame at `at` in that of the shape, and turned like it."""

    at: Vec3
    shape: Shape

    @property
    def placement(self) -> Pose:
        return (*self.at, 0.0, 0.0, 0.0, 1.0)
