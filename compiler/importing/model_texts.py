"""Robots and bodies of others as text: a program, and a URDF for each module beside it.

A URDF holds what the text of a module cannot: turned frames and axes, and inertias. `reading.py` names the files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from xml.sax.saxutils import quoteattr

from ..checks.values import LONGEST
from ..ir import Pose, Shape, ShapeKind, Vec3
from ..poses import compose, make, orientation, rotate
from .models import (
    DIRECTIONS,
    END,
    STRAIGHT,
    Form,
    Models,
    RobotEnd,
    RobotModel,
    Stood,
    Thing,
    corners,
    extent,
    upright,
)

MOST = 1e9
"""What is larger is a mistake, and no number for a scene."""


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
    base = min(bases, key=lambda thing: min(_away(form, at) for form in thing.forms)).name
    end = f"{stood.name}.{root.name}"
    yield from (f"(support {end})", f"(on {base} {end})", f"[stable {base} {end}]")


def _away(form: Form, point: Vec3) -> float:
    """How far a point is from the box around a shape along the world's axes."""
    spans = [(-extent(form, [-e for e in axis]), extent(form, axis)) for axis in DIRECTIONS[:3]]
    along = [sum(a * p for a, p in zip(axis, point, strict=True)) for axis in DIRECTIONS[:3]]
    return math.hypot(*(max(low - p, p - high, 0.0) for (low, high), p in zip(spans, along, strict=True)))


def _end(end: RobotEnd) -> str:
    where = "" if end.place[:3] == (0.0, 0.0, 0.0) else f" at {_vector(end.place[:3])}"
    x, y, z = rotate(orientation(end.place), (0.0, 0.0, 1.0))
    normal = (round(x, 12) + 0.0, round(y, 12) + 0.0, round(z, 12) + 0.0)
    facing = "" if normal == (0.0, 0.0, 1.0) else f" normal ({', '.join(map(_number, normal))})"
    return f'effector {end.name}: {end.type} "{end.part}" sphere({_length(END)}){where}{facing}'


def _thing(thing: Thing) -> Iterator[str]:
    mass = f" mass {_number(thing.mass)} kg" if thing.mass > 0 else ""
    form = _sphere_upright(thing.forms[0])
    if len(thing.forms) > 1:
        shape, middle = _union([_sphere_upright(form) for form in thing.forms])
        heading = ""
    elif form.kind != "convex" and upright(form.place):
        shape, middle = _plain(form), form.place[:3]
        heading = "" if form.kind in ("capsule", "cylinder") else _heading(form.place)
    else:
        shape, middle = _hull(form)
        heading = ""
    yield f"{thing.type} {thing.name}: {shape} at {_vector(middle)}{heading}{mass}"


def _sphere_upright(form: Form) -> Form:
    return replace(form, place=make(form.place[:3], STRAIGHT)) if form.kind == "sphere" else form


def _plain(form: Form) -> str:
    return f"{form.kind}({', '.join(map(_length, form.size))})"


def _hull(form: Form) -> tuple[str, Sequence[float]]:
    """A form as the hull of its corners, and where the middle of the box around it lies."""
    points, middle = _turned(form)
    return f"hull({', '.join(map(_vector, points))})", middle


def _turned(form: Form) -> tuple[list[Vec3], Vec3]:
    """The corners along the axes of the world, about the middle of the box around them, and that middle."""
    turn = make((0.0, 0.0, 0.0), orientation(form.place))
    points = [compose(turn, make(p, STRAIGHT))[:3] for p in corners(form)]
    x, y, z = ((min(p[k] for p in points) + max(p[k] for p in points)) / 2 for k in range(3))
    at = form.place[:3]
    return [(p[0] - x, p[1] - y, p[2] - z) for p in points], (at[0] + x, at[1] + y, at[2] + z)


def _union(forms: Sequence[Form]) -> tuple[str, Sequence[float]]:
    """Forms as one shape, and where the middle of the box around it lies, as the language has it."""
    from ..unions import union

    texts, parts = [], []
    for form in forms:
        round_ = form.kind in ("capsule", "cylinder") and upright(form.place)
        if form.kind != "convex" and (round_ or abs(form.place[6]) == 1.0):
            text, at, shape = _plain(form), form.place[:3], Shape(ShapeKind(form.kind), form.size)
        else:
            text, _ = _hull(form)
            points, at = _turned(form)
            shape = Shape(ShapeKind.CONVEX, tuple(v for p in points for v in p))
        texts.append(f"{text} at {_vector(at)}")
        parts.append((at, shape))
    return f"union({', '.join(texts)})", union(parts)[1]


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
    for size in form.size:
        _within(size)
    if form.kind == "box":
        return f'<box size="{_xyz(form.size)}"/>'
    if form.kind == "sphere":
        return f'<sphere radius="{form.size[0]!r}"/>'
    if form.kind == "convex":
        return f'<convex points="{" ".join(f"{v:.9g}" for v in form.size)}"/>'
    return f'<{form.kind} radius="{form.size[0]!r}" length="{form.size[1]!r}"/>'


def _origin(pose: Pose) -> str:
    for place in pose[:3]:
        _within(place)
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


def _within(metres: float) -> None:
    """Raises OverflowError for a size or a place that no scene has."""
    if not abs(metres) <= LONGEST:
        raise OverflowError(f"{metres:g} m")


def _length(value: float) -> str:
    _within(value)
    return "0 m" if value == 0 else f"{_number(value)} m"


def _vector(values: Sequence[float]) -> str:
    return f"({', '.join(_length(v) for v in values)})"


def _heading(place: Pose) -> str:
    angle = 2 * math.atan2(place[5], place[6])
    return "" if abs(angle) < 1e-15 else f" heading {_number(angle)} rad"


