"""Mass, centre and inertia of shapes filled with water, and convex ones as STL."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...compiler.ir import ShapeKind
from ...langs.frozen import dataclass
from ..plan import ShapeRecord
from .motion import Pose

Array = NDArray[np.float64]
WATER = 1000.0
"""Kilograms per cubic metre."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """`mass` in kilograms, `centre` (3,) in metres, and `inertia` (3, 3) about the centre, kg m²."""

    mass: float
    centre: Array
    inertia: Array


def solid(shape: ShapeRecord, pose: Pose) -> Solid:
    """A shape at `pose`, whose axes are those of the result."""
    from scipy.spatial.transform import Rotation

    volume, centre, moments = _convex(shape) if shape.kind == ShapeKind.CONVEX else _round(shape)
    turn = Rotation.from_quat(pose[3:]).as_matrix()
    return Solid(WATER * volume, turn @ centre + pose[:3], WATER * turn @ moments @ turn.T)


def together(parts: Sequence[Solid]) -> Solid:
    """All parts as one."""
    mass = sum(p.mass for p in parts)
    centre = sum((p.mass * p.centre for p in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        d = part.centre - centre
        inertia += part.inertia + part.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Solid(mass, centre, inertia)


def _round(shape: ShapeRecord) -> tuple[float, Array, Array]:
    """Volume, centre and inertia at density 1 of a box or round shape, about its centre."""
    if shape.kind == ShapeKind.BOX:
        x, y, z = shape.size
        volume = x * y * z
        moments = [volume / 12 * (b * b + c * c) for b, c in ((y, z), (x, z), (x, y))]
        return volume, np.zeros(3), np.diag(moments)
    r = shape.size[0]
    ball = 4 / 3 * np.pi * r**3
    if shape.kind == ShapeKind.SPHERE:
        return ball, np.zeros(3), np.eye(3) * (0.4 * ball * r * r)
    length = shape.size[1]
    tube = np.pi * r * r * length
    along, across = tube * r * r / 2, tube * (r * r / 4 + length * length / 12)
    if shape.kind == ShapeKind.CYLINDER:
        return tube, np.zeros(3), np.diag([across, across, along])
    # Two half balls: about the middle of the capsule, by the theorem of parallel axes through their centres of mass.
    along += 0.4 * ball * r * r
    across += ball * (0.4 * r * r + length * length / 4 + 3 / 8 * length * r)
    return tube + ball, np.zeros(3), np.diag([across, across, along])


def _convex(shape: ShapeRecord) -> tuple[float, Array, Array]:
    """The same of a convex shape, from the tetrahedra between its faces and its origin."""
    corners = _triangles(shape)
    volumes = np.linalg.det(corners) / 6
    volume = float(volumes.sum())
    sums = corners.sum(axis=1)
    centre = (volumes @ sums) / (4 * volume)
    second = np.einsum("t,tki,tkj->ij", volumes, corners, corners) + np.einsum("t,ti,tj->ij", volumes, sums, sums)
    second = second / 20 - volume * np.outer(centre, centre)
    return volume, centre, np.trace(second) * np.eye(3) - second


def _triangles(shape: ShapeRecord) -> Array:
    """The faces (T, 3, 3) of a convex shape, counter-clockwise from outside."""
    from ...compiler.hulls import hull
    from ...compiler.ir import Shape

    made = hull(Shape(ShapeKind.CONVEX, tuple(shape.size)))
    return np.asarray(made.corners[made.triangles])


def stl(shape: ShapeRecord) -> bytes:
    """A convex shape as binary STL, metres."""
    faces = _triangles(shape)
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    records = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("faces", "<f4", (3, 3)), ("more", "<u2")])
    records["normal"], records["faces"] = normals, faces
    return b"tamplang".ljust(80) + len(faces).to_bytes(4, "little") + records.tobytes()
