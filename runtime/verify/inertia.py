"""Masses of shapes at the density of water, and centres of mass of modules on the samples of a motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from .geometry import Array, Frames, Indices, frames
from .shapes import volume

KILOGRAMS_PER_LITRE = 1.0


def mass_of(shape: ir.Shape) -> float:
    """Kilograms of a solid shape given in metres, at the density of water."""
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


def weights(module: ir.ModuleType) -> list[tuple[int, ir.Pose, float]]:
    """What weighs in a module: the joint that carries it, where it sits there, and kilograms, stated or of water."""
    found: list[tuple[int, ir.Pose, float]] = []
    for end in module.effectors:
        if end.shape is not None:
            found.append((end.joint, end.placement, mass_of(end.shape) if end.mass is None else end.mass))
    for link in module.links:
        found.append((link.joint, link.placement, mass_of(link.shape) if link.mass is None else link.mass))
    found += [(joint.parent, joint.placement, joint.mass) for joint in module.joints if joint.mass > 0.0]
    found += [(i.joint, (*i.centre, 0.0, 0.0, 0.0, 1.0), i.mass) for i in module.inertials]
    return found


def centre_of(module: ir.ModuleType, joints: Mapping[int, Frames], at: Indices) -> tuple[float, Array]:
    """Mass, and centres of mass `(T, 3)` at samples `at`, of a module whose joint frames are given."""
    total, moment = 0.0, np.zeros((len(at), 3))
    for joint, placement, mass in weights(module):
        moment += mass * joints[joint][at].compose(frames(placement)).position
        total += mass
    return (total, moment / total) if total else (1e-3, joints[-1][at].position)
