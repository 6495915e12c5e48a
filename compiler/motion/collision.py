"""Collision geometry of a problem: spheres that cover shapes, contacts of each phase.

Metres; sphere centres are in the moving frame of their joint (-1: the module frame, or a body's own frame).
A set of spheres covers a shape *within* `margin`: no point of the shape is farther than `margin` outside the
spheres. Keeping the spheres `margin` away from an obstacle therefore keeps the shape itself clear of it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Protocol

import numpy as np

from ...langs.frozen import dataclass
from ..extents import box_sides
from ..hulls import Array, hull
from ..ir import (
    Action,
    Body,
    Chain,
    Fact,
    JointKind,
    ModuleType,
    Pose,
    Problem,
    Shape,
    ShapeKind,
    Vec3,
)
from ..kept_pairs import keeps_pose, kept_pairs
from ..remembering import remembered
from .covers import cover_hull
from .lasting import lasting

PATH_MARGIN = 0.02
"""The margin that the spheres used along a path and at switches are made for."""
CHECK_MARGIN = 0.005
"""The margin of the denser spheres that accept or refuse a path."""
ON_AXIS = 1e-9

Pair = tuple[str, str]


def pair(a: str, b: str) -> Pair:
    """The unordered pair of two objects."""
    return (a, b) if a <= b else (b, a)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere fixed to the moving frame of `joint`; `effector` names the effector that it belongs to, `part` numbers
    the shapes of its module, effectors first. An `exact` one is a whole shape, no part of a cover."""

    joint: int
    centre: Vec3
    radius: float
    effector: str | None
    exact: bool = False
    part: int = 0


def pose_matrix(pose: Pose | Array) -> Array:
    """The homogeneous matrix `(4, 4)` of a pose `(x, y, z, qx, qy, qz, qw)`."""
    x, y, z, a, b, c, w = (float(v) for v in pose)
    n = 2.0 / (a * a + b * b + c * c + w * w)
    return np.array([
        [1 - n * (b * b + c * c), n * (a * b - c * w), n * (a * c + b * w), x],
        [n * (a * b + c * w), 1 - n * (a * a + c * c), n * (b * c - a * w), y],
        [n * (a * c - b * w), n * (b * c + a * w), 1 - n * (a * a + b * b), z],
        [0.0, 0.0, 0.0, 1.0],
    ])


# --- spheres that cover a shape -------------------------------------------------------------------


def _line(half: float, step: float) -> list[float]:
    """Points from -half to half, at most `step` apart; the middle alone when the line is a point."""
    if half <= ON_AXIS:
        return [0.0]
    count = max(1, math.ceil(2 * half / step - 1e-9))
    return [half * (2 * k / count - 1) for k in range(count + 1)]


def _apart(ball: float, margin: float) -> float:
    """How far apart spheres of radius `ball` that touch a face may be to cover it within `margin`; at least 2 `ball`,
    as that is at most margin / (√3 − 1)."""
    return math.sqrt(2 * margin * (margin + 2 * ball))


def _cover_box(half: Vec3, margin: float) -> Iterator[tuple[Vec3, float]]:
    """Small spheres along the edges; larger ones, farther apart, behind what is left of the faces."""
    small = min(min(half), margin / (math.sqrt(3) - 1))
    overhang = 0.5 * (margin + math.sqrt(margin * (3 * margin + 8 * small)))
    large = min(min(half), 2 * small + overhang)
    if large < 3 * small:
        yield from _box_shell(half, small, _apart(small, margin), edges=False)
        return
    yield from _box_shell(half, small, _apart(small, margin), edges=True)
    yield from _box_shell(half, large, 2 * (large - 2 * small), edges=False)


def _box_shell(half: Vec3, radius: float, step: float, edges: bool) -> Iterator[tuple[Vec3, float]]:
    """Spheres at most `step` apart that touch the box's faces, or two of them, from within."""
    lines = [_line(h - radius, step) for h in half]
    for index in itertools.product(*(range(len(line)) for line in lines)):
        if sum(k in (0, len(line) - 1) for k, line in zip(index, lines, strict=True)) > edges:
            x, y, z = (line[k] for k, line in zip(index, lines, strict=True))
            yield (x, y, z), radius


def _cover_capsule(radius: float, length: float, margin: float) -> Iterator[tuple[Vec3, float]]:
    step = 2 * math.sqrt((radius + margin) ** 2 - radius**2)
    for z in _line(length / 2, step):
        yield (0.0, 0.0, z), radius


def _cover_cylinder(radius: float, length: float, margin: float) -> Iterator[tuple[Vec3, float]]:
    """Rings of spheres: the outermost at every height, all of them at both flat ends."""
    ball = min(radius, length / 2, margin / (math.sqrt(3) - 1))
    step = _apart(ball, margin)
    heights = _line(length / 2 - ball, step)
    rings = sorted({abs(r) for r in _line(radius - ball, step)}, reverse=True)
    for k, z in enumerate(heights):
        for ring in rings if k in (0, len(heights) - 1) else rings[:1]:
            count = 1 if ring <= ON_AXIS else max(4, math.ceil(2 * math.pi * (ring + ball) / step))
            for i in range(count):
                angle = 2 * math.pi * i / count
                yield (ring * math.cos(angle), ring * math.sin(angle), z), ball


def cover(shape: Shape, margin: float) -> tuple[tuple[Vec3, float], ...]:
    """Spheres `(centre, radius)` in the frame of the shape, within it, that cover it within `margin`."""
    if shape.parts:
        return tuple(
            ((x + p.at[0], y + p.at[1], z + p.at[2]), radius)
            for p in shape.parts for (x, y, z), radius in cover(p.shape, margin)
        )  # fmt: skip
    size = shape.size
    if shape.kind == ShapeKind.SPHERE:
        return (((0.0, 0.0, 0.0), size[0]),)
    if shape.kind == ShapeKind.BOX:
        return tuple(_cover_box((size[0] / 2, size[1] / 2, size[2] / 2), margin))
    if shape.kind == ShapeKind.CONVEX:
        return cover_hull(shape, margin)
    if shape.kind == ShapeKind.CAPSULE:
        return tuple(_cover_capsule(size[0], size[1], margin))
    return tuple(_cover_cylinder(size[0], size[1], margin))


def bounding_radius(shape: Shape) -> float:
    """Radius of the sphere around the shape's centre that holds it."""
    size = shape.size
    if shape.kind == ShapeKind.SPHERE:
        return size[0]
    if shape.kind == ShapeKind.CONVEX:
        return hull(shape).radius
    if shape.kind == ShapeKind.BOX:
        return 0.5 * math.hypot(*size)
    if shape.kind == ShapeKind.CAPSULE:
        return size[0] + size[1] / 2
    return math.hypot(size[0], size[1] / 2)


@lru_cache(maxsize=512)
def shape_reach(shape: Shape) -> float:
    """How far the parts of a shape come from its origin, in metres."""
    return max((math.hypot(*p.placement[:3]) + bounding_radius(p.shape) for p in shape.solids), default=0.0)


def on_axis(axis: Vec3, point: Array) -> bool:
    """Whether a point is on the axis through the origin."""
    return bool(np.linalg.norm(np.cross(axis, point)) <= ON_AXIS * math.hypot(*axis))


def _hoist(type_: ModuleType, joint: int, centre: Array) -> tuple[int, Array]:
    """The same point in the frame nearest to the root that carries it: a joint that turns about an axis
    through a point does not move it."""
    while joint >= 0 and type_.joints[joint].kind == JointKind.REVOLUTE:
        if not on_axis(type_.joints[joint].axis, centre):
            break
        centre = (pose_matrix(type_.joints[joint].placement) @ np.append(centre, 1.0))[:3]
        joint = type_.joints[joint].parent
    return joint, centre


def _placed(
    type_: ModuleType, joint: int, placement: Pose, shape: Shape, margin: float
) -> Iterator[tuple[int, Array, float]]:
    frame = pose_matrix(placement)
    for centre, radius in cover(shape, margin):
        yield *_hoist(type_, joint, (frame @ np.array([*centre, 1.0]))[:3]), radius


class _KeptSpheres:
    """The spheres that a joint carries, and whether others are inside one of them."""

    def __init__(self) -> None:
        self._balls = np.zeros((0, 4))
        self._count = 0

    def add(self, centre: Array, radius: float) -> None:
        if self._count == len(self._balls):
            self._balls = np.concatenate([self._balls, np.zeros((max(16, self._count), 4))])
        self._balls[self._count] = *centre, radius
        self._count += 1

    def hold(self, centre: Array, radius: float) -> bool:
        balls = self._balls[: self._count]
        apart = np.sqrt(((balls[:, :3] - centre) ** 2).sum(axis=1))
        return bool((apart + radius <= balls[:, 3] + ON_AXIS).any())


@lru_cache(maxsize=64)
def module_spheres(type_: ModuleType, margin: float = PATH_MARGIN) -> tuple[Sphere, ...]:
    """Spheres that cover the effectors and links of a module within `margin`, effectors first, in declaration
    order. Link spheres that lie inside another one of the module in every pose are left out."""
    spheres: list[Sphere] = []
    kept = {joint: _KeptSpheres() for joint in range(-1, len(type_.joints))}
    for part, e in enumerate(type_.effectors):
        if e.shape is not None:
            for joint, centre, radius in _placed(type_, e.joint, e.placement, e.shape, margin):
                kept[joint].add(centre, radius)
                x, y, z = centre.tolist()
                spheres.append(Sphere(joint, (x, y, z), radius, e.name, e.shape.kind == ShapeKind.SPHERE, part))
    for part, link in enumerate(type_.links, start=len(type_.effectors)):
        for joint, centre, radius in _placed(type_, link.joint, link.placement, link.shape, margin):
            if not kept[joint].hold(centre, radius):
                kept[joint].add(centre, radius)
                x, y, z = centre.tolist()
                spheres.append(Sphere(joint, (x, y, z), radius, None, link.shape.kind == ShapeKind.SPHERE, part))
    return tuple(spheres)


def body_spheres(body: Body, margin: float = PATH_MARGIN) -> tuple[Sphere, ...]:
    """Spheres that cover a body within `margin`, in its own frame."""
    exact = body.shape.kind == ShapeKind.SPHERE
    return tuple(Sphere(-1, centre, radius, None, exact) for centre, radius in cover(body.shape, margin))


# --- contacts -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PhaseContacts:
    """Pairs of objects (effectors or bodies) that touch in a phase: all the time, only when it starts, only
    when it ends. They are exempt from collision there; a pair in `start` and `end` lets go in between."""

    during: frozenset[Pair]
    start: frozenset[Pair]
    end: frozenset[Pair]
    beside: frozenset[Pair] = frozenset()
    """Pairs that may touch all the time, but not overlap."""
    pressed: frozenset[Pair] = frozenset()
    """Those of them that overlap at the start by less than what `check` lets pass, and may so."""


def _kept(problem: Problem, literals: frozenset[Fact]) -> frozenset[Pair]:
    return frozenset(pair(*kept) for kept in (keeps_pose(problem, literal) for literal in literals) if kept)


def _named(literals: frozenset[Fact]) -> frozenset[Pair]:
    return frozenset(pair(a, b) for _, *objects in literals for a, b in itertools.combinations(objects, 2))


class ContactPhase(Protocol):
    """One action: the motion literals that hold until its switch, and those that it adds there."""

    @property
    def action(self) -> Action: ...
    @property
    def mode(self) -> frozenset[Fact]: ...
    @property
    def added(self) -> frozenset[Fact]: ...


class Phases(Protocol):
    """The actions of a plan in order."""

    @property
    def problem(self) -> Problem: ...
    @property
    def phases(self) -> Sequence[ContactPhase]: ...


@remembered(8)
def contacts(skeleton: Phases) -> tuple[PhaseContacts, ...]:
    """The contacts of each phase: kept poses of its mode hold during it, and what its rows hold in contact; literals
    that are added end it; whatever touched when the phase before ended and is not kept touches at its start only.
    Bodies that no module carries, and modules that no action concerns, rest and touch still."""
    result: list[PhaseContacts] = []
    touching: frozenset[Pair] = _named(skeleton.problem.init_motion) | skeleton.problem.touching
    pressed = skeleton.problem.pressed
    for phase in skeleton.phases:
        kept = _kept(skeleton.problem, phase.mode)
        still = skeleton.problem.world.bodies.keys() - _carried(skeleton.problem, phase.mode)
        during = kept | {objects for objects in touching if still.issuperset(objects)}
        beside = {pair(*objects) for literal in phase.mode for objects in lasting(skeleton.problem, literal)} - during
        added = _named(phase.added)
        start, deep = touching - during, pressed - during
        result.append(PhaseContacts(during, start, added - during, frozenset(beside | deep), deep))
        touching = during | added | beside | _resting(start, skeleton.problem, phase, kept)
    return tuple(result)


def _carried(problem: Problem, mode: frozenset[Fact]) -> set[str]:
    """The bodies that modules carry, or that lie on such bodies."""
    kept = kept_pairs(problem, mode)
    found: set[str] = set()
    while more := {
        follows
        for fixed, follows in kept
        if follows in problem.world.bodies and follows not in found
        if fixed in found or problem.world.effector(fixed)
    }:
        found |= more
    return found


def _resting(
    touching: frozenset[Pair], problem: Problem, phase: ContactPhase, kept: frozenset[Pair]
) -> frozenset[Pair]:
    """The contacts of modules that the phase's action does not concern: it concerns what it names, the modules of its
    chains, what it adds, and every module that is linked to these."""
    owner = problem.world.owner
    args = phase.action.args
    chained = [part for arg in args if isinstance(arg, Chain) for line in arg.modules for part in line]
    named = [*map(str, args), *chained, *(name for _, *objects in phase.added for name in objects)]
    concerned = set(map(owner, named))
    links = [{owner(a), owner(b)} for a, b in kept]
    links = [link for link in links if link <= problem.world.modules.keys()]
    while more := {name for link in links if link & concerned for name in link} - concerned:
        concerned |= more

    def rests(objects: Pair) -> bool:
        modules = set(map(owner, objects)) & problem.world.modules.keys()
        return bool(modules) and not modules & concerned

    return frozenset(filter(rests, touching))


def taper(contact: PhaseContacts, objects: Pair, times: Array, slices: int, over: int = 3) -> Array | None:
    """The share of the margin that a pair of objects must keep at `times`, counted in slices from the start
    of the phase: 1, but falling to 0 over the `over` slices next to a contact that ends or begins; 0 for a pair that
    may touch all the time, None for one that does."""
    if objects in contact.during:
        return None
    if objects in contact.beside:
        return np.zeros(times.shape)
    share = np.ones(times.shape)
    if objects in contact.start:
        share = np.minimum(share, times / over)
    if objects in contact.end:
        share = np.minimum(share, (slices - times) / over)
    return share


# --- what is near ---------------------------------------------------------------------------------


def shape_distance(shape: Shape, frame: Array, point: Array) -> float:
    """Distance from a point `(3,)` to a shape whose frame is `(4, 4)`, both in the world; 0 inside, and a lower
    bound unless the shape is a box or a sphere."""
    x, y, z = (abs(v) for v in (frame[:3, :3].T @ (point - frame[:3, 3])).tolist())
    if shape.kind in (ShapeKind.BOX, ShapeKind.CONVEX):
        return math.hypot(*(max(v - s / 2, 0.0) for v, s in zip((x, y, z), box_sides(shape), strict=True)))
    return max(0.0, math.hypot(x, y, z) - bounding_radius(shape))
