"""Masses of shapes at the density of water, and where they sit in a module."""

from __future__ import annotations

import math

from ..hulls import hull
from ..ir import ModuleType, Pose, Shape

DENSITY = 1000.0
"""Kilograms per cubic metre."""


def shape_mass(shape: Shape) -> float:
    """Kilograms of a solid shape."""
    size = shape.size
    if shape.kind == "convex":
        return DENSITY * hull(shape).volume
    if shape.kind == "box":
        return DENSITY * size[0] * size[1] * size[2]
    ball = 4.0 / 3.0 * math.pi * size[0] ** 3
    if shape.kind == "sphere":
        return DENSITY * ball
    straight = math.pi * size[0] ** 2 * size[1]
    return DENSITY * (straight + ball if shape.kind == "capsule" else straight)


def module_masses(module: ModuleType) -> tuple[tuple[int, Pose, float], ...]:
    """Per shape of a module: the joint that carries it (-1: the module frame), where its centre is there, its mass in
    kilograms. Overlaps count twice."""
    ends = [(e.joint, e.placement, shape_mass(e.shape)) for e in module.effectors if e.shape is not None]
    return (*ends, *((k.joint, k.placement, shape_mass(k.shape)) for k in module.links))


def module_mass(module: ModuleType) -> float:
    """Kilograms of a module; one without shapes counts as a gram at its frame."""
    return sum(mass for _, _, mass in module_masses(module)) or 1e-3
