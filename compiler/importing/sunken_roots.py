"""Robots that the world holds and whose roots are sunk into what they stand on: what lies within it is cut off. Nothing
could hit that part without hitting the body first."""

from __future__ import annotations

from dataclasses import replace

from ..ir import Pose, Vec3
from ..poses import compose, inverse, make
from .models import STRAIGHT, Form, Models, RobotModel, RobotPart, Stood, Thing, ball, corners, upright

SUNK = 1e-3
"""Metres by which things that rest in contact may overlap anyway."""


def cut_roots(models: Models) -> list[str]:
    """Cut the shapes that never move off at the tops of upright boxes around them; gives what is to be told."""
    told = []
    boxes = [t for t in models.things if t.type == "base" and t.forms[0].kind == "box" and upright(t.forms[0].place)]
    for stood in models.stood:
        for base in boxes if stood.fixed else []:
            number, robot = next((k, r) for k, r in enumerate(models.robots) if r.name == stood.robot)
            cut, depth = _cut(robot, stood, base)
            if depth > SUNK:
                models.robots[number] = cut
                told.append(f"`{stood.name}` is sunk {depth * 1000:.0f} mm into `{base.name}`: that much is cut off")
    return told


def _cut(robot: RobotModel, stood: Stood, base: Thing) -> tuple[RobotModel, float]:
    """The robot without what is within a box, and how deep that went."""
    frames = {robot.parts[0].name: stood.place}
    for hinge in robot.hinges:
        if hinge.kind == "fixed" and hinge.parent in frames:
            frames[hinge.child] = compose(frames[hinge.parent], hinge.origin)
    deepest, parts = 0.0, []
    for part in robot.parts:
        forms: list[Form] = []
        for form in part.forms:
            frame = compose(frames[part.name], form.place) if part.name in frames else None
            left, depth = (form, 0.0) if frame is None else _above(form, frame, base.forms[0])
            deepest = max(deepest, depth)
            forms += [] if left is None else [left]
        parts.append(RobotPart(part.name, tuple(forms), part.weight))
    return replace(robot, parts=tuple(parts)), deepest


def _above(form: Form, frame: Pose, box: Form) -> tuple[Form | None, float]:
    """What of a form is above the top of a box, None where nothing is, and how deep it goes; the form itself and 0
    where it does not stand over the top, or is clear of it."""
    own = corners(form) if form.kind != "sphere" else [_scaled(p, form.size[0]) for p in ball()]
    turn = compose(inverse(box.place), frame)
    placed = [compose(turn, make(p, STRAIGHT))[:3] for p in own]
    wide, deep, top = (s / 2 for s in box.size)
    depth = top - min(p[2] for p in placed)
    if depth <= SUNK or depth > box.size[2] + SUNK or any(abs(x) > wide or abs(y) > deep for x, y, _ in placed):
        return form, 0.0
    high = [p for p in placed if p[2] > top]
    if not high:
        return None, depth
    cut = [_crossing(a, b, top) for a in high for b in placed if b[2] <= top]
    return _convex([*high, *cut], form, inverse(turn)), depth


def _convex(points: list[Vec3], form: Form, back: Pose) -> Form:
    """The hull of points, which `back` takes into the frame of a form, as a form of the same part."""
    import numpy as np

    from ..hulls import corners_of

    own = [compose(back, make(p, STRAIGHT))[:3] for p in points]
    hull = [tuple(float(v) for v in p) for p in corners_of(np.array(own))]
    low, high = ([f(p[k] for p in hull) for k in range(3)] for f in (min, max))
    x, y, z = ((a + b) / 2 for a, b in zip(low, high, strict=True))
    size = tuple(v for p in hull for v in (p[0] - x, p[1] - y, p[2] - z))
    return Form("convex", size, compose(form.place, make((x, y, z), STRAIGHT)))


def _crossing(one: Vec3, other: Vec3, level: float) -> Vec3:
    """Where the line from a point above a level to one below crosses it."""
    share = (one[2] - level) / (one[2] - other[2])
    x, y, z = (a + share * (b - a) for a, b in zip(one, other, strict=True))
    return x, y, z


def _scaled(point: Vec3, factor: float) -> Vec3:
    return factor * point[0], factor * point[1], factor * point[2]
