"""Overlaps at the start: pairs of bodies and modules whose shapes occupy the same space before anything moves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence, Set
from functools import lru_cache
from operator import sub

from ...langs.frozen import dataclass
from ...langs.source import Span
from .. import ir
from ..checks.findings import Findings
from ..extents import box_sides, corners
from ..joint_lines import are_kept_apart, line
from ..part_names import part_names
from ..poses import Quaternion, compose, joint_frames, orientation, part_pose, position, rotate
from ..remembering import remembered

TOLERANCE = 1e-3
"""Depth in metres up to which things that rest in contact may overlap."""

Box = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Volume:
    """One shape in the world: `owner` is the body or module, `name` the body or effector, `bounds` the axis-aligned box
    around it (lowest corner, highest corner). Of a module also `part`, how the shape is called, its `number` among
    `module_parts`, and the `joint` that carries it."""

    owner: str
    name: str
    shape: ir.Shape
    pose: ir.Pose
    bounds: Box
    span: Span | None
    part: str
    number: int = 0
    joint: int = -1


def check_start(findings: Findings, world: ir.World, carried: Iterable[tuple[str, str]]) -> None:
    """Report every pair that overlaps by more than `TOLERANCE`, the deepest first where one item makes several. What
    never moves may be built into each other, which is worth a warning.

    `carried` holds pairs (thing, support) that may touch: what stands on something.
    """
    exempt = {frozenset(pair) for pair in carried}
    found: dict[frozenset[str], tuple[float, Volume, Volume]] = {}
    solid = {body.name for body in world.solids} | world.modules.keys()
    for one, other in candidates([v for v in volumes(world) if v.owner in solid]):
        if frozenset((one.name, other.name)) in exempt or not _may_overlap(world, one, other):
            continue
        depth = penetration(one, other)
        key = frozenset((one.owner, other.owner))
        if depth > TOLERANCE and (key not in found or depth > found[key][0]):
            found[key] = (depth, one, other)
    pairs = sorted(found.values(), key=lambda f: (-f[0], f[1].owner, f[2].owner))
    fixed = {b.name for b in world.bodies.values() if not b.movable} - {course.body for course in world.courses}
    order = {name: i for i, name in enumerate([*world.bodies, *world.modules])}
    for depth, one, other in pairs:
        first, second = sorted((one, other), key=lambda v: (order[v.owner], v.number))
        labels = [(first.span, f"`{first.owner}` is declared here")] if first.span != second.span else []
        built_in = {first.owner, second.owner} <= fixed
        within = first.owner == second.owner
        apart = "give its joints other values at home" if within else "move them apart, or put one `on` the other"
        apart = _at_foot(world, exempt, depth, one, other) or _at_foot(world, exempt, depth, other, one) or apart
        freedom = "neither ever moves" if built_in else _freedom(world, fixed, first, second)
        findings.report(
            "W0012" if built_in else "E0502",
            second.span,
            f"`{first.part}` and `{second.part}` overlap by {depth * 1000:.0f} mm at the start",
            help=None if built_in else apart,
            note="; ".join(filter(None, (freedom, *(_put(world, v.owner) for v in (first, second))))),
            labels=labels,
        )


def _put(world: ir.World, name: str) -> str | None:
    """Of a body of several parts, or of a hull, what of it is put at its place."""
    body = world.bodies.get(name)
    if body is None or (len(body.shape.solids) == 1 and body.shape.kind != ir.ShapeKind.CONVEX):
        return None
    sides = " x ".join(f"{100 * side:.3g}" for side in box_sides(body.shape))
    return f"`{name}` is put in its place by the middle of the box around it, {sides} cm"


def _at_foot(
    world: ir.World, stands: Set[frozenset[str]], depth: float, part: Volume, support: Volume
) -> str | None:
    """What helps where a module reaches into what one of its effectors stands on: because a part that is rigid with
    the effector goes past it, or because the effector faces along the module."""
    ends = world.modules[part.owner].type.effectors if part.owner in world.modules else ()
    for end in ends:
        foot = f"{part.owner}.{end.name}"
        if part.name == foot or frozenset((foot, support.name)) not in stands:
            continue
        up = rotate(orientation(end.placement), (0.0, 0.0, 1.0))[2] > 0.9
        if end is ends[0] and end.joint < 0 and up and position(end.placement)[2] <= 0.0:
            return (
                f"`{foot}` faces along its module, which therefore hangs head down from what it stands on: give that "
                "effector `normal (0, 0, -1)`"
            )
        if _turns_with(world.modules[part.owner].type.joints, end.joint, part.joint):
            return (
                f"`{part.part}` reaches {depth * 1000:.0f} mm past the face on which `{foot}` stands: set that "
                "effector further out, with `at`, or make the link smaller there"
            )
    return None


def _turns_with(joints: Sequence[ir.Joint], foot: int, part: int) -> bool:
    """Whether what follows joint `part` stays at its height above a foot behind joint `foot`: between them are only
    turns about the line of the module."""
    while part != foot and part >= 0 and joints[part].kind == ir.JointKind.REVOLUTE and abs(joints[part].axis[2]) > 0.9:
        part = joints[part].parent
    return part == foot


def _may_overlap(world: ir.World, one: Volume, other: Volume) -> bool:
    """Whether two shapes are of different things, or of a module that must keep them apart and may start with them in
    each other."""
    if one.owner != other.owner:
        return True
    module = world.modules.get(one.owner)
    if module is None or not are_kept_apart(module.type, one.joint, other.joint):
        return False
    from ..module_parts import own_pairs

    numbers = sorted((one.number, other.number))
    away = next((away for i, k, away in own_pairs(module.type) if [i, k] == numbers), None)
    at_home = module.joints == tuple(j.home for j in module.type.joints)
    return away is not None and not (at_home and away > 0.0)


def _freedom(world: ir.World, fixed: Set[str], *volumes: Volume) -> str:
    """Which parts of modules could move out of an overlap, and by which joints; without modules, which bodies rules may
    move."""
    if not any(v.owner in world.modules for v in volumes):
        loose = " and ".join(f"`{v.owner}`" for v in volumes if v.owner not in fixed)
        return f"rules may move {loose}; only what none moves may be built in"
    told = []
    for volume in volumes:
        if volume.owner not in world.modules:
            told.append(f"`{volume.part}` {'never moves' if volume.owner in fixed else 'can be moved'}")
            continue
        kind = world.modules[volume.owner].type
        names = [kind.joints[j].name for j in reversed(line(kind, volume.joint)[:-1])]
        moved = f"moves with {', '.join(names)}" if names else "moves only with its whole robot"
        told.append(f"`{volume.part}` {moved}")
    return "; ".join(told)


@remembered(4)
def volumes(world: ir.World) -> Sequence[Volume]:
    """All shapes of the scene at the start."""
    return [*_bodies(world), *_modules(world)]


def _bodies(world: ir.World) -> Iterator[Volume]:
    for body in world.bodies.values():
        for solid in body.shape.solids:
            pose = part_pose(body.pose, solid)
            yield Volume(body.name, body.name, solid.shape, pose, bounds(solid.shape, pose), body.span, body.name)


def _modules(world: ir.World) -> Iterator[Volume]:
    for module in world.modules.values():
        type_ = module.type
        frames = joint_frames(type_, module.pose, module.joints)
        ends = [end for end in type_.effectors if end.shape is not None]
        shapes = [
            (f"{module.name}.{e.name}", e.joint, part_pose(e.placement, part), part.shape)
            for e in ends if e.shape is not None for part in e.shape.solids
        ]  # fmt: skip
        shapes += [(module.name, link.joint, link.placement, link.shape) for link in type_.links]
        called = part_names(module.name, [name for name, *_ in shapes])
        for number, (part, (name, joint, placement, shape)) in enumerate(zip(called, shapes, strict=True)):
            pose = compose(frames[joint], placement)
            yield Volume(module.name, name, shape, pose, bounds(shape, pose), module.span, part, number, joint)


def bounds(shape: ir.Shape, pose: ir.Pose) -> Box:
    """The axis-aligned box around a shape, metres in the world."""
    x, y, z = position(pose)
    a, b, c, d, e, f = _bounds(shape, orientation(pose))
    return x + a, y + b, z + c, x + d, y + e, z + f


@lru_cache(maxsize=1024)
def _bounds(shape: ir.Shape, q: Quaternion) -> Box:
    """That box around a shape at the origin: of many bodies few are turned each in its own way."""
    if shape.kind == ir.ShapeKind.CONVEX:
        x, y, z = zip(*(rotate(q, c) for c in corners(shape)), strict=True)
        return min(x), min(y), min(z), max(x), max(y), max(z)
    if shape.kind == ir.ShapeKind.SPHERE:
        reach = [shape.size[0]] * 3
    elif shape.kind == ir.ShapeKind.BOX:
        columns = [rotate(q, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        reach = [sum(abs(c[i]) * s / 2 for c, s in zip(columns, shape.size, strict=True)) for i in range(3)]
    else:
        radius, length = shape.size
        axis = rotate(q, (0.0, 0.0, 1.0))
        round_end = shape.kind == ir.ShapeKind.CAPSULE
        reach = [abs(a) * length / 2 + radius * (1.0 if round_end else math.sqrt(max(0.0, 1.0 - a * a))) for a in axis]
    return -reach[0], -reach[1], -reach[2], reach[0], reach[1], reach[2]


def candidates(found: list[Volume]) -> Iterator[tuple[Volume, Volume]]:
    """Pairs whose boxes overlap by more than the tolerance, by a sweep along the axis on which least of them share
    places: the sum of their widths is the smallest part of what they cover."""

    low, high = ([[v.bounds[k] for v in found] for k in axes] for axes in (range(3), range(3, 6)))

    def crowd(axis: int) -> float:
        width = max(high[axis]) - min(low[axis])
        return float(sum(map(sub, high[axis], low[axis]))) / max(width, TOLERANCE)

    along = min(range(3), key=crowd) if found else 0
    (low_1, high_1), (low_2, high_2) = ((low[k], high[k]) for k in range(3) if k != along)
    ends, active = high[along], list[int]()
    for k in sorted(range(len(found)), key=low[along].__getitem__):
        start = low[along][k] + TOLERANCE
        active = [i for i in active if ends[i] > start]
        least_1, most_1, least_2, most_2 = low_1[k], high_1[k], low_2[k], high_2[k]
        for i in active:
            if (
                high_1[i] - least_1 > TOLERANCE < most_1 - low_1[i]
                and high_2[i] - least_2 > TOLERANCE < most_2 - low_2[i]
                and min(high_1[i], most_1) - max(low_1[i], least_1) > TOLERANCE
                and min(high_2[i], most_2) - max(low_2[i], least_2) > TOLERANCE
            ):
                yield found[i], found[k]
        active.append(k)


def penetration(one: Volume, other: Volume) -> float:
    """How deep two shapes overlap, metres; 0 or less when they do not. Loads coal, which is why only candidates come
    here."""
    import coal
    import numpy as np

    request, result = coal.DistanceRequest(), coal.DistanceResult()
    placed = []
    for volume in (one, other):
        transform = coal.Transform3s()
        transform.setQuatRotation(coal.Quaternion(volume.pose[6], volume.pose[3], volume.pose[4], volume.pose[5]))
        transform.setTranslation(np.array(position(volume.pose)))
        placed.append((_geometry(volume.shape), transform))
    (geometry, transform), (other_geometry, other_transform) = placed
    return -float(coal.distance(geometry, transform, other_geometry, other_transform, request, result))


def _geometry(shape: ir.Shape) -> object:
    import coal

    if shape.kind == ir.ShapeKind.CONVEX:
        from ..hulls import convex_geometry

        return convex_geometry(shape)
    if shape.kind == ir.ShapeKind.BOX:
        return coal.Box(*shape.size)
    if shape.kind == ir.ShapeKind.SPHERE:
        return coal.Sphere(shape.size[0])
    return (coal.Capsule if shape.kind == ir.ShapeKind.CAPSULE else coal.Cylinder)(*shape.size)
