"""Robots and bodies of others as records, and these as text: a program, and a URDF for each module beside it.

A URDF holds what the text of a module cannot: turned frames and axes, and inertias. `reading.py` names the files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import field, replace
from xml.sax.saxutils import quoteattr

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
    """A body of a scene; its form lies in the world."""

    type: str
    name: str
    form: Form
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
    found = [(_extent(form, d), form, d) for form in part.forms for d in directions]
    if not found:
        return make((0.0, 0.0, 0.0), between((0.0, 0.0, 1.0), directions[0]))
    far, form, direction = max(found, key=lambda each: round(each[0], 9))
    middle = form.place[:3]
    short = far - sum(m * d for m, d in zip(middle, direction, strict=True))
    x, y, z = (m + short * d for m, d in zip(middle, direction, strict=True))
    return make((x, y, z), between((0.0, 0.0, 1.0), direction))


def _extent(form: Form, direction: Sequence[float]) -> float:
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


def program(models: Models, files: dict[str, str], scene: str) -> str:
    """The text of the program, whose modules read the URDFs `files`, by robot."""
    lines = [f"import {name}" for name in models.imports] + list(models.declarations)
    for robot in models.robots:
        lines.append(f'module {robot.name} from urdf "{files[robot.name]}" {{')
        lines += [f"    {_end(end)}" for end in robot.ends] + [f"    fact {fact}" for fact in robot.facts] + ["}"]
    inside = [line for thing in models.things for line in _thing(thing)]
    for stood in models.stood:
        inside.append(f"{stood.robot} {stood.name}: at {_vector(stood.place[:3])}{_heading(stood.place)}")
        inside += [f"fact {fact}" for fact in _footing(models, stood)]
    inside += [f"fact {fact}" for fact in models.facts]
    if models.goals:
        lines += [f"task {scene}() {{", *(f"    {line}" for line in inside), f"    goal {', '.join(models.goals)}", "}"]
    elif inside:
        lines += [f"scene {scene}() {{", *(f"    {line}" for line in inside), "}"]
    return "\n".join(lines) + "\n"


def _footing(models: Models, stood: Stood) -> Iterator[str]:
    """In the words of `std.rules`, that a module that is fixed to the world stands on the nearest body at rest."""
    bases = [thing for thing in models.things if thing.type == "base"]
    if not stood.fixed or not bases or "std.rules" not in models.imports:
        return
    root = next(robot for robot in models.robots if robot.name == stood.robot).ends[0]
    at = compose(stood.place, root.place)[:3]
    base = min(bases, key=lambda thing: _away(thing.form, at)).name
    end = f"{stood.name}.{root.name}"
    yield from (f"(support {end})", f"(on {base} {end})", f"[stable {base} {end}]")


def _away(form: Form, point: Vec3) -> float:
    """How far a point is from the box around a shape along the world's axes."""
    spans = [(-_extent(form, [-e for e in axis]), _extent(form, axis)) for axis in DIRECTIONS[:3]]
    along = [sum(a * p for a, p in zip(axis, point, strict=True)) for axis in DIRECTIONS[:3]]
    return math.hypot(*(max(low - p, p - high, 0.0) for (low, high), p in zip(spans, along, strict=True)))


def _end(end: RobotEnd) -> str:
    where = "" if end.place[:3] == (0.0, 0.0, 0.0) else f" at {_vector(end.place[:3])}"
    x, y, z = rotate(orientation(end.place), (0.0, 0.0, 1.0))
    normal = (round(x, 12) + 0.0, round(y, 12) + 0.0, round(z, 12) + 0.0)
    facing = "" if normal == (0.0, 0.0, 1.0) else f" normal ({', '.join(map(_number, normal))})"
    return f'effector {end.name}: {end.type} "{end.part}" sphere({_length(END)}){where}{facing}'


def _thing(thing: Thing) -> Iterator[str]:
    form, mass = thing.form, f" mass {_number(thing.mass)} kg" if thing.mass > 0 else ""
    if form.kind == "sphere":
        form = replace(form, place=make(form.place[:3], (0.0, 0.0, 0.0, 1.0)))
    if form.kind != "convex" and upright(form.place):
        shape = f"{form.kind}({', '.join(map(_length, form.size))})"
        heading = "" if form.kind in ("capsule", "cylinder") else _heading(form.place)
        yield f"{thing.type} {thing.name}: {shape} at {_vector(form.place[:3])}{heading}{mass}"
        return
    points = [compose(make((0, 0, 0), orientation(form.place)), make(p, (0, 0, 0, 1.0)))[:3] for p in corners(form)]
    middle = [(min(p[k] for p in points) + max(p[k] for p in points)) / 2 for k in range(3)]
    listed = ", ".join(_vector([p[k] - middle[k] for k in range(3)]) for p in points)
    yield (
        f"{thing.type} {thing.name}: hull({listed}) "
        f"at {_vector([form.place[k] + middle[k] for k in range(3)])}{mass}"
    )


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


MOST = 1e9
"""Metres and other units: what is larger is a mistake, and no number for a scene."""
ROUND = 16
"""Corners of what stands around something round that leans: 2 % farther out."""


def urdf(robot: RobotModel) -> str:
    """The text of a URDF 1.1: quaternions keep turns to the last digit."""
    lines = ['<?xml version="1.0"?>', f'<robot name={_quoted(robot.name)} version="1.1">']
    for part in robot.parts:
        lines.append(f"  <link name={_quoted(part.name)}>")
        if part.weight is not None:
            m = dict(zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), part.weight.moments, strict=True))
            moments = " ".join(f'{k}="{v!r}"' for k, v in m.items())
            mass = f'<mass value="{part.weight.mass!r}"/>'
            lines.append(f"    <inertial>{_origin(part.weight.place)}{mass}<inertia {moments}/></inertial>")
        for form in part.forms:
            lines.append(f"    <collision>{_origin(form.place)}<geometry>{_geometry(form)}</geometry></collision>")
        lines.append("  </link>")
    for h in robot.hinges:
        lines.append(f'  <joint name={_quoted(h.name)} type="{h.kind}">')
        lines.append(f"    <parent link={_quoted(h.parent)}/><child link={_quoted(h.child)}/>{_origin(h.origin)}")
        if h.kind != "fixed":
            ends = f' lower="{h.lower!r}" upper="{h.upper!r}"' if h.kind != "continuous" else ""
            more = f' acceleration="{h.acceleration!r}"' if h.acceleration > 0 else ""
            limit = f'<limit{ends} effort="{h.effort!r}" velocity="{h.speed!r}"{more}/>'
            lines.append(f'    <axis xyz="{_xyz(h.axis)}"/>{limit}')
        if h.leader is not None:
            name, factor, offset = h.leader
            lines.append(f'    <mimic joint={_quoted(name)} multiplier="{factor!r}" offset="{offset!r}"/>')
        lines.append("  </joint>")
    return "\n".join([*lines, "</robot>", ""])


def _geometry(form: Form) -> str:
    if form.kind == "box":
        return f'<box size="{_xyz(form.size)}"/>'
    if form.kind == "sphere":
        return f'<sphere radius="{form.size[0]!r}"/>'
    if form.kind == "convex":
        return f'<convex points="{" ".join(f"{v:.9g}" for v in form.size)}"/>'
    return f'<{form.kind} radius="{form.size[0]!r}" length="{form.size[1]!r}"/>'


def _origin(pose: Pose) -> str:
    turn = "" if pose[3:6] == (0.0, 0.0, 0.0) else f' quat_xyzw="{_xyz(pose[3:])}"'
    return f'<origin xyz="{_xyz(pose[:3])}"{turn}/>'


def _xyz(values: Sequence[float]) -> str:
    return " ".join(repr(float(v)) for v in values)


def _quoted(text: str) -> str:
    return quoteattr(text)


def _number(value: float) -> str:
    """Raises OverflowError where the language has no such number."""
    if not abs(value) < MOST:
        raise OverflowError(f"{value:g}")
    return f"{value:.15g}".replace("e+", "e")


def _length(value: float) -> str:
    return "0 m" if value == 0 else f"{_number(value)} m"


def _vector(values: Sequence[float]) -> str:
    return f"({', '.join(_length(v) for v in values)})"


def _heading(place: Pose) -> str:
    angle = 2 * math.atan2(place[5], place[6])
    return "" if abs(angle) < 1e-15 else f" heading {_number(angle)} rad"


def relative(world: dict[str, Pose], parent: str, child: str) -> Pose:
    """The frame `child` in the frame `parent`, both known in the world."""
    return compose(inverse(world[parent]), world[child])
