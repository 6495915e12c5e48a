"""The shapes of a module as parts, which of them may touch for ever, and how near the others are at home: of modules
with bodies of many corners remembered on the disk, as it takes a second to load what measures them."""

from __future__ import annotations

import hashlib
import itertools
import json
from functools import lru_cache
from typing import TYPE_CHECKING

from ..langs.disk_cache import cache_folder, keep_sealed, recalled_sealed
from ..langs.frozen import dataclass
from .ir import ModuleType, Pose, Shape, ShapeKind
from .joint_lines import are_kept_apart
from .poses import compose, joint_frames, part_pose

if TYPE_CHECKING:
    from .symbolic.geometry import Placed

METHOD = "1"
"""Told apart in the cache: how pairs are found. To be counted up with every change of it."""

NOWHERE: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class ModulePart:
    """A convex shape at `placement` in the moving frame of `joint` (-1: the module frame); `effector` names the
    effector that it belongs to, None for a link. `several`: it is one of several of its effector."""

    joint: int
    placement: Pose
    shape: Shape
    effector: str | None = None
    several: bool = False


@lru_cache(maxsize=64)
def module_parts(type_: ModuleType) -> tuple[ModulePart, ...]:
    """The convex shapes of a module's effectors, then of its links."""
    ends = tuple(
        ModulePart(e.joint, part_pose(e.placement, part), part.shape, e.name, bool(e.shape.parts))
        for e in type_.effectors if e.shape is not None for part in e.shape.solids
    )  # fmt: skip
    return (*ends, *(ModulePart(link.joint, link.placement, link.shape) for link in type_.links))


@lru_cache(maxsize=64)
def own_pairs(type_: ModuleType) -> tuple[tuple[int, int, float], ...]:
    """The pairs of parts of a module that may not overlap, and how far apart they are at home, metres. Left out are
    parts that sit on one joint, that have no other part between them along the joints, and that are built into each
    other, which shows when all joints are at zero (or at the limit nearest to it)."""
    if not any(part.shape.kind == ShapeKind.CONVEX for part in module_parts(type_)):
        return _measured(type_)
    told = json.dumps([METHOD, [(p.joint, p.placement, p.shape.kind, p.shape.size) for p in module_parts(type_)], [
        (j.kind, j.parent, j.placement, j.axis, j.lower, j.upper, j.home, repr(j.follows)) for j in type_.joints
    ]])  # fmt: skip
    file = cache_folder() / f"pairs-{hashlib.sha256(told.encode()).hexdigest()[:32]}.json"
    content = recalled_sealed(file)
    if content is not None:
        return tuple((int(i), int(k), float(apart)) for i, k, apart in json.loads(content))
    found = _measured(type_)
    keep_sealed(file, json.dumps(found).encode())
    return found


def _measured(type_: ModuleType) -> tuple[tuple[int, int, float], ...]:
    from .symbolic.geometry import shape_distance

    parts = module_parts(type_)
    neutral = _placed(type_, tuple(min(max(0.0, j.lower), j.upper) for j in type_.joints))
    home = _placed(type_, tuple(j.home for j in type_.joints))
    found = []
    for i, k in itertools.combinations(range(len(parts)), 2):
        if not are_kept_apart(type_, parts[i].joint, parts[k].joint):
            continue
        if shape_distance(neutral[i], neutral[k]) > 0.0:
            found.append((i, k, shape_distance(home[i], home[k])))
    return tuple(found)


def _placed(type_: ModuleType, joints: tuple[float, ...]) -> list[Placed]:
    from .symbolic.geometry import Placed

    frames = joint_frames(type_, NOWHERE, joints)
    return [Placed(part.shape, compose(frames[part.joint], part.placement)) for part in module_parts(type_)]
