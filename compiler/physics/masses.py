"""Masses of shapes and modules: what is stated, else that of a solid body at the density of water."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

from ..ir import Body, ModuleType, Pose, Shape, ShapeKind, SolidPart
from ..poses import part_pose

GRAVITY = 9.81
"""Metres per second squared."""
DENSITY = 1000.0
"""Kilograms per cubic metre of what states no mass: water."""


def shape_mass(shape: Shape, density: float = DENSITY) -> float:
    """Kilograms of a solid shape; where boxes that it is made of overlap, they count once."""
    if shape.parts:
        return density * parts_volume(shape.parts)
    size = shape.size
    if shape.kind == ShapeKind.CONVEX:
        from ..hulls import hull

        return density * hull(shape).volume
    if shape.kind == ShapeKind.BOX:
        return density * size[0] * size[1] * size[2]
    ball = 4.0 / 3.0 * math.pi * size[0] ** 3
    if shape.kind == ShapeKind.SPHERE:
        return density * ball
    straight = math.pi * size[0] ** 2 * size[1]
    return density * (straight + ball if shape.kind == ShapeKind.CAPSULE else straight)


def shape_volume(shape: Shape) -> float:
    """Cubic metres of a solid shape."""
    return shape_mass(shape, 1.0)


@lru_cache(maxsize=256)
def parts_volume(parts: tuple[SolidPart, ...]) -> float:
    """Cubic metres of the parts of a shape together; where boxes among them overlap, they count once."""
    boxes = [p for p in parts if p.shape.kind == ShapeKind.BOX]
    spans = [tuple((c - s / 2, c + s / 2) for c, s in zip(p.at, p.shape.size, strict=True)) for p in boxes]
    return sum(shape_volume(p.shape) for p in parts if p.shape.kind != ShapeKind.BOX) + _covered(spans)


def _covered(boxes: Sequence[tuple[tuple[float, float], ...]]) -> float:
    """The length, area or volume that some boxes cover together, each given by its two ends along every axis: slab by
    slab between the ends along the first one."""
    if not boxes:
        return 0.0
    if not boxes[0]:
        return 1.0
    ends = sorted({end for box in boxes for end in box[0]})
    return sum(
        (b - a) * _covered([box[1:] for box in boxes if box[0][0] <= a and b <= box[0][1]]) for a, b in pairwise(ends)
    )


def solid_masses(shape: Shape, mass: float) -> list[tuple[SolidPart, float]]:
    """The convex parts of a shape of that mass, kg, and what each weighs: as much of it as it has of their volumes."""
    volumes = [shape_volume(part.shape) for part in shape.solids]
    return [(part, mass * volume / sum(volumes)) for part, volume in zip(shape.solids, volumes, strict=True)]


def part_mass(shape: Shape, stated: float | None) -> float:
    """Kilograms of a part."""
    return shape_mass(shape) if stated is None else stated


def body_mass(body: Body) -> float:
    return part_mass(body.shape, body.mass)


def module_masses(module: ModuleType) -> tuple[tuple[int, Pose, float], ...]:
    """Per weight of a module: the joint that carries it (-1: the module frame), where its centre is there, its mass in
    kilograms. The drive of a joint sits where the joint is, on what carries it. Where parts overlap, both count."""
    found = [
        (e.joint, part_pose(e.placement, part), mass)
        for e in module.effectors if e.shape is not None
        for part, mass in solid_masses(e.shape, part_mass(e.shape, e.mass))
    ]  # fmt: skip
    found += [(k.joint, k.placement, part_mass(k.shape, k.mass)) for k in module.links]
    found += [(j.parent, j.placement, j.mass) for j in module.joints if j.mass]
    found += [(i.joint, (*i.centre, 0.0, 0.0, 0.0, 1.0), i.mass) for i in module.inertials]
    return tuple(found)


def module_mass(module: ModuleType) -> float:
    """Kilograms of a module; one without shapes counts as a gram at its frame."""
    return sum(mass for _, _, mass in module_masses(module)) or 1e-3


def unstated(module: ModuleType) -> bool:
    """Whether a part of the module that has a shape states no mass."""
    return any(e.mass is None for e in module.effectors if e.shape is not None) or any(
        k.mass is None for k in module.links
    )
