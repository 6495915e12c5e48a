"""Distances from points to convex shapes, in batches. Every shape is a box with half sizes and a rounding radius: a
sphere is a rounded point, a capsule a rounded line; a cylinder is treated in its radius and height, and a convex shape
is replaced by the box around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...compiler.extents import box_sides
from ...compiler.ir import Shape, ShapeKind
from ..skeleton import Array

FLAT = 1e9
NEARLY_PLAIN = 1e-8
"""Rotations closer to the identity than this are left out."""


def half_sizes(shape: Shape) -> tuple[Array, float, bool]:
    """Half sizes `(3,)`, rounding radius, and whether the first size is a radius across the z-axis."""
    size = shape.size
    if shape.kind in (ShapeKind.BOX, ShapeKind.CONVEX):
        return np.array(box_sides(shape)) / 2, 0.0, False
    if shape.kind == ShapeKind.SPHERE:
        return np.zeros(3), size[0], False
    if shape.kind == ShapeKind.CAPSULE:
        return np.array([0.0, 0.0, size[1] / 2]), size[0], False
    return np.array([size[0], FLAT, size[1] / 2]), 0.0, True


def rounded_box_distance(offset: Array, half: Array, turned: NDArray[np.bool_] | None) -> tuple[Array, Array]:
    """Signed distance `(…, phases, times)` to a box of half sizes `half`, and the excess over them, of offsets
    `(…, 3, phases, times)` in its axes; where `turned`, the first half size is a radius across the z-axis."""
    excess = np.abs(offset)
    if turned is not None:
        across = np.hypot(offset[..., 0, :, :], offset[..., 1, :, :])
        excess[..., 0, :, :] = np.where(turned, across, excess[..., 0, :, :])
    excess -= half
    outside = np.maximum(excess, 0.0)
    outside *= outside
    far = np.sqrt(outside[..., 0, :, :] + outside[..., 1, :, :] + outside[..., 2, :, :])
    deepest = np.maximum(np.maximum(excess[..., 0, :, :], excess[..., 1, :, :]), excess[..., 2, :, :])
    return far + np.minimum(deepest, 0.0), excess


class Shapes:
    """Shapes at rest for a batch of phases, `count` per phase, in axes `(count, 3, phases, 1)`. Missing ones (None)
    are put far away."""

    def __init__(self, rows: list[list[tuple[Shape, Array] | None]]) -> None:
        """`rows[phase]` lists shapes with their world poses `(4, 4)`; all rows are equally long."""
        phases, count = len(rows), len(rows[0])
        self.centre = np.full((count, 3, phases, 1), FLAT)
        self.half = np.zeros((count, 3, phases, 1))
        self.rounding = np.zeros((count, phases, 1))
        self.turn = np.broadcast_to(np.eye(3)[:, :, None, None], (count, 3, 3, phases, 1)).copy()
        self.round = np.zeros((count, phases, 1), bool)
        for k, row in enumerate(rows):
            for o, entry in enumerate(row):
                if entry is not None:
                    shape, pose = entry
                    half, rounding, self.round[o, k, 0] = half_sizes(shape)
                    self.centre[o, :, k, 0], self.half[o, :, k, 0] = pose[:3, 3], half
                    self.rounding[o, k, 0], self.turn[o, :, :, k, 0] = rounding, pose[:3, :3]
        self._note_plain()

    def _note_plain(self) -> None:
        self.turned = bool(np.any(np.abs(self.turn - np.eye(3)[:, :, None, None]) > NEARLY_PLAIN))
        self.any_round = bool(self.round.any())
        half = self.half.copy()
        half[:, 1] = np.where(self.round, half[:, 0], half[:, 1])
        self.extent = np.einsum("oijbt,ojbt->oib", np.abs(self.turn), half) + self.rounding[:, None, :, 0]
        """Half the sides `(count, 3, phases)` of the box around each shape along the world's axes."""

    def take(self, index: NDArray[np.intp]) -> Shapes:
        """The shapes of some of the phases."""
        result = object.__new__(Shapes)
        result.centre, result.half = self.centre[:, :, index], self.half[:, :, index]
        result.rounding, result.turn = self.rounding[:, index], self.turn[:, :, :, index]
        result.round, result.extent = self.round[:, index], self.extent[:, :, index]
        result.turned, result.any_round = self.turned, self.any_round
        return result

    def distance_at(
        self, points: Array, shape: NDArray[np.intp], phase: NDArray[np.intp]
    ) -> tuple[Array, Array, Array]:
        """Signed distances `(m, times)` of moving points `(m, 3, times)`, each to one shape in one phase, with the
        offset from the centre and the excess over the half sizes in the shape's own axes, both `(m, 3, times)`."""
        offset = points - self.centre[shape, :, phase]
        if self.turned:
            offset = np.einsum("mij,mit->mjt", self.turn[shape, :, :, phase, 0], offset)
        turned = self.round[shape, phase][..., None] if self.any_round else None
        value, excess = rounded_box_distance(offset[:, :, None], self.half[shape, :, phase][..., None], turned)
        return value[:, 0] - self.rounding[shape, phase], offset, excess[:, :, 0]

    def normals(self, offset: Array, excess: Array, shape: NDArray[np.intp], phase: NDArray[np.intp]) -> Array:
        """World directions `(m, 3)` in which the distances grow, of `m` entries: their `offset` and `excess` `(m, 3)`,
        the shape and the phase they belong to."""
        outside = np.maximum(excess, 0.0)
        length = np.sqrt((outside * outside).sum(axis=1))
        normal = outside / np.maximum(length, 1e-12)[:, None]
        within = np.flatnonzero(length < 1e-12)
        normal[within] = 0.0
        normal[within, excess[within].argmax(axis=1)] = 1.0
        sign = np.where(offset < 0.0, -1.0, 1.0)
        if self.any_round:
            turned = self.round[shape, phase, 0]
            across = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-12)
            radial = normal[:, 0].copy()
            normal *= sign
            normal[turned, 0] = (radial * offset[:, 0] / across)[turned]
            normal[turned, 1] = (radial * offset[:, 1] / across)[turned]
        else:
            normal *= sign
        if self.turned:
            normal = np.einsum("mij,mj->mi", self.turn[shape, :, :, phase, 0], normal)
        return np.asarray(normal)
