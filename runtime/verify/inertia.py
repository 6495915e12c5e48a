"""Masses of shapes at the density of water, and centres of mass of modules on the samples of a motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from .geometry import Array, Frames, Indices, frames
from .shapes import volume

KILOGRAMS_PER_LITRE = 1.0


def mass_of(shape: ir.Shape) -> float:
    """Kilograms of a solid shape given in metres."""
    if shape.kind == "convex":
        return 1000.0 * KILOGRAMS_PER_LITRE * volume(shape.size)
    match shape.kind, [10.0 * s for s in shape.size]:
        case "box", [x, y, z]:
            litres = x * y * z
        case "sphere", [r]:
            litres = 4.0 / 3.0 * np.pi * r**3
        case "capsule", [r, length]:
            litres = np.pi * r * r * (length + 4.0 / 3.0 * r)
        case _, [r, length]:
            litres = np.pi * r * r * length
        case _:
            litres = 0.0
    return float(KILOGRAMS_PER_LITRE * litres)


def centre_of(module: ir.ModuleType, joints: Mapping[int, Frames], at: Indices) -> tuple[float, Array]:
    """Mass, and centres of mass `(T, 3)` at samples `at`, of a module whose joint frames are given."""
    shapes = [(e.joint, e.placement, e.shape) for e in module.effectors if e.shape is not None]
    shapes += [(k.joint, k.placement, k.shape) for k in module.links]
    total, moment = 0.0, np.zeros((len(at), 3))
    for joint, placement, shape in shapes:
        mass = mass_of(shape)
        moment += mass * joints[joint][at].compose(frames(placement)).position
        total += mass
    return (total, moment / total) if total else (1e-3, joints[-1][at].position)
