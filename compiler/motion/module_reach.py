"""How far a module reaches."""

from __future__ import annotations

import math
from functools import lru_cache

from ..ir import ModuleType, Vec3
from ..joint_lines import line
from .collision import PATH_MARGIN, module_spheres


def _length_between(type_: ModuleType, a: tuple[int, Vec3], b: tuple[int, Vec3]) -> float:
    """An upper bound of the distance of two points fixed to joint frames, along the joints between them."""
    ends: list[Vec3] = []
    length = 0.0
    for (joint, point), (other, _) in ((a, b), (b, a)):
        shared = line(type_, other)
        while joint != -1 and joint not in shared:
            placement = type_.joints[joint].placement
            length += math.hypot(*point) + type_.joints[joint].slide
            point, joint = (placement[0], placement[1], placement[2]), type_.joints[joint].parent
        ends.append(point)
    return length + math.dist(ends[0], ends[1])


@lru_cache(maxsize=256)
def reach(type_: ModuleType, effector: str) -> float:
    """An upper bound of how far any point of the module can be from the origin of one effector's frame."""
    e = type_.effector(effector)
    start = (e.joint, (e.placement[0], e.placement[1], e.placement[2]))
    spheres = module_spheres(type_)
    lengths = (_length_between(type_, start, (s.joint, s.centre)) + s.radius for s in spheres)
    return max(lengths, default=0.0) + PATH_MARGIN
