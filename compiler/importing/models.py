"""Robots and bodies of others as records."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field, replace

from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ..ir import IDENTITY, Pose, Vec3
from ..poses import between, compose, inverse, make, orientation, rotate
from .names import GivenNames

STRAIGHT = (0.0, 0.0, 0.0, 1.0)
FAR = 10.0
"""Metres: how far a sliding joint without limits moves each way, and half the edge of a plane without end."""
END = 0.01
"""Radius, m, of the ends that importers put where files know none: small beside what they stand for."""
Six = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Form:
    """A shape at `place`: a box of three edges, a sphere of a radius, a capsule or cylinder of a radius and the length
    of its straight part, or `convex` of x, y, z, x, … of its corners. Metres."""

    kind: str
    size: tuple[float, ...]
    place: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class PartWeight:
    """A mass, kg, with its centre at `place`, and about it ixx, ixy, ixz, iyy, iyz, izz in the axes of `place`."""

    mass: float
    place: Pose
    moments: Six


@dataclass(frozen=True, slots=True)
class RobotPart:
    """A rigid part with the shapes that others may hit."""

    name: str
    forms: tuple[Form, ...] = ()
    weight: PartWeight | None = None


@dataclass(frozen=True, slots=True)
class Hinge:
    """A joint in the words of URDF: `fixed`, `revolute`, `continuous` or `prismatic`; `origin` is the frame of the
    child at 0 in that of the parent. `leader` names another joint, of which this one is a multiple plus a value."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Pose
    axis: Vec3 = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    speed: float = 0.0
    effort: float = 0.0
    leader: tuple[str, float, float] | None = None
    acceleration: float = 0.0


@dataclass(frozen=True, slots=True)
class RobotEnd:
    """An effector at `place` in the frame of a part; its z-axis is the outward normal."""

    name: str
    type: str
    part: str
    place: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class RobotModel:
    """A module type; its first part is the root of the tree."""

    name: str
    parts: tuple[RobotPart, ...]
    hinges: tuple[Hinge, ...]
    ends: tuple[RobotEnd, ...] = ()
    facts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Thing:
    """A body of a scene; its forms lie in the world."""

    type: str
    name: str
    forms: tuple[Form, ...]
    mass: float = 0.0


@dataclass(frozen=True, slots=True)
class Stood:
    """A module in a scene: of which robot, its name, where its root is, and whether the world holds it there."""

    robot: str
    name: str
    place: Pose
    fixed: bool = False


@dataclass(slots=True)
class Models:
    """What a file holds, and what of it has no counterpart."""

    imports: tuple[str, ...] = ("std.rules",)
    declarations: list[str] = field(default_factory=list)
    robots: list[RobotModel] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    stood: list[Stood] = field(default_factory=list)
    facts: list[str] = field(default_factory=list)
    goals: list[str] = field(default_factory=list)
    told: list[Diagnostic] = field(default_factory=list)

    def stand(self, robot: RobotModel, name: str, place: Pose, fixed: bool) -> None:
        """Take in a robot and one module of it in the scene, whose root is at `place`."""
        upright_robot, at = set_upright(robot, place)
        self.robots.append(upright_robot)
        self.stood.append(Stood(robot.name, name, at, fixed))


def linked(ends: Sequence[RobotEnd]) -> tuple[str, ...]:
    """Facts that the first end is linked to each other one."""
    return tuple(f"(linked {ends[0].name} {end.name})" for end in ends[1:])


DIRECTIONS: tuple[Vec3, ...] = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, -1))


def plain_ends(names: GivenNames, parts: Sequence[RobotPart], hinges: Sequence[Hinge]) -> tuple[RobotEnd, ...]:
    """An end in the root that faces down, at its top, as its bottom may be sunk into what it stands on; and one at each
    part on which no other hangs, where it goes farthest out along an axis of its own."""
    above = {h.parent for h in hinges}
    leaves = [p for p in parts if p.name not in above and p.name != parts[0].name]
    x, y, z = _outermost(parts[0], DIRECTIONS[:1])[:3]
    inside = max(z - END, 0.0)
    root = RobotEnd(names.fresh("root"), "gripper", parts[0].name, make((x, y, inside), (1.0, 0.0, 0.0, 0.0)))
    fresh = [names.fresh("tip" if len(leaves) == 1 else leaf.name) for leaf in leaves]
    tips = [
        RobotEnd(name, "gripper", leaf.name, _outermost(leaf, DIRECTIONS))
        for name, leaf in zip(fresh, leaves, strict=True)
    ]
    return (root, *tips)


def _outermost(part: RobotPart, directions: Sequence[Vec3]) -> Pose:
    """Where the shapes of a part go farthest along one of the directions, facing that way; the frame of a part without
    shapes."""
    found = [(extent(form, d), form, d) for form in part.forms for d in directions]
    if not found:
        return make((0.0, 0.0, 0.0), between((0.0, 0.0, 1.0), directions[0]))
    far, form, direction = max(found, key=lambda each: round(each[0], 9))
    middle = form.place[:3]
    short = far - sum(m * d for m, d in zip(middle, direction, strict=True))
    x, y, z = (m + short * d for m, d in zip(middle, direction, strict=True))
    return make((x, y, z), between((0.0, 0.0, 1.0), direction))


def extent(form: Form, direction: Sequence[float]) -> float:
    """How far a shape goes along a direction from the origin of its part."""
    if form.kind == "sphere":
        points, radius = [(0.0, 0.0, 0.0)], form.size[0]
    elif form.kind == "capsule":
        points, radius = [(0.0, 0.0, side * form.size[1] / 2) for side in (-1, 1)], form.size[0]
    else:
        points, radius = corners(form), 0.0
    placed = (compose(form.place, make(p, (0.0, 0.0, 0.0, 1.0)))[:3] for p in points)
    return radius + max(sum(a * d for a, d in zip(p, direction, strict=True)) for p in placed)


def upright(place: Pose) -> bool:
    """Whether only a turn about the vertical is in it, as bodies and modules of scenes have it."""
    return abs(rotate(orientation(place), (0.0, 0.0, 1.0))[2] - 1.0) < 1e-12


def set_upright(robot: RobotModel, place: Pose) -> tuple[RobotModel, Pose]:
    """The robot with an upright root where `place` leans: the leaning goes into a fixed joint of its own."""
    if upright(place):
        return robot, place
    base = RobotPart(f"{robot.name}_stand")
    leaning = make((0.0, 0.0, 0.0), orientation(place))
    lean = Hinge(f"{robot.name}_lean", "fixed", base.name, robot.parts[0].name, leaning)
    stood = replace(robot, parts=(base, *robot.parts), hinges=(lean, *robot.hinges))
    return stood, make(place[:3], (0.0, 0.0, 0.0, 1.0))


def corners(form: Form) -> list[Vec3]:
    """The corners of a convex body that is the shape, or, where it is round, lies around it."""
    if form.kind == "convex":
        return [(form.size[k], form.size[k + 1], form.size[k + 2]) for k in range(0, len(form.size), 3)]
    if form.kind == "box":
        x, y, z = (s / 2 for s in form.size)
        return [(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    radius, half = form.size[0], form.size[1] / 2
    wide = radius / math.cos(math.pi / ROUND)
    ring = [(math.cos(2 * math.pi * k / ROUND), math.sin(2 * math.pi * k / ROUND)) for k in range(ROUND)]
    if form.kind == "cylinder":
        return [(wide * x, wide * y, z) for x, y in ring for z in (-half, half)]
    top = half + radius
    slope = math.tan(math.pi / 8) * radius
    return [(wide * x, wide * y, z) for x, y in ring for z in (-half - slope, half + slope)] + [
        (slope / radius * wide * x, slope / radius * wide * y, z) for x, y in ring for z in (-top, top)
    ]


ROUND = 16
"""Corners of what stands around something round that leans: 2 % farther out."""


def relative(world: dict[str, Pose], parent: str, child: str) -> Pose:
    """The frame `child` in the frame `parent`, both known in the world."""
    return compose(inverse(world[parent]), world[child])


def ball() -> list[Vec3]:
    """Corners of a body around the sphere of radius 1: rings of 12 at 6 heights, and two ends."""
    wide = 1.0 / (math.cos(math.pi / 12) * math.cos(math.pi / 14))
    found: list[Vec3] = [(0.0, 0.0, wide), (0.0, 0.0, -wide)]
    for ring in range(1, 7):
        high = math.pi * ring / 7
        for k in range(12):
            angle = math.pi * k / 6
            out = wide * math.sin(high)
            found.append((out * math.cos(angle), out * math.sin(angle), wide * math.cos(high)))
    return found
