"""Moments of inertia of solid shapes about their middle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..ir import Shape, ShapeKind
from .masses import solid_masses

Array = NDArray[np.float64]


def shape_moments(shape: Shape, mass: float) -> Array:
    """The matrix (3, 3) in kg m² of a solid shape of that mass, along its axes; a convex one counts as the box around
    it, which is never less, one of several parts as these where they are, about the middle of them all."""
    if shape.parts:
        whole = np.zeros((3, 3))
        for part, own in solid_masses(shape, mass):
            at = np.array(part.at)
            whole += shape_moments(part.shape, own) + own * (at @ at * np.eye(3) - np.outer(at, at))
        return whole
    size = shape.size
    if shape.kind in (ShapeKind.BOX, ShapeKind.CONVEX):
        sides = size if shape.kind == ShapeKind.BOX else np.ptp(np.asarray(size).reshape(-1, 3), axis=0).tolist()
        x, y, z = (s * s for s in sides)
        return np.diag([y + z, x + z, x + y]) * (mass / 12.0)
    if shape.kind == ShapeKind.SPHERE:
        return np.eye(3) * (0.4 * mass * size[0] ** 2)
    radius, length = size
    if shape.kind == ShapeKind.CYLINDER:
        across = mass * (3.0 * radius**2 + length**2) / 12.0
        return np.diag([across, across, mass * radius**2 / 2.0])
    straight, ball = math.pi * radius**2 * length, 4.0 / 3.0 * math.pi * radius**3
    tube = mass * straight / (straight + ball)
    caps = mass - tube
    across = tube * (length**2 / 12.0 + radius**2 / 4.0)
    across += caps * (0.4 * radius**2 + length**2 / 4.0 + 3.0 * length * radius / 8.0)
    return np.diag([across, across, tube * radius**2 / 2.0 + 0.4 * caps * radius**2])
