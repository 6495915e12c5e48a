"""Things that are put `at` a point and lie on something that can be moved: they are carried along, as what the text
puts `on` it, since nothing floats."""

from __future__ import annotations

import itertools
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Set

from .. import ir
from ..checks.findings import Findings
from ..extents import box_sides
from ..poses import make, orientation, position, rotate, yaw
from .check_start import TOLERANCE, Box, bounds
from .marks import is_region
from .placing import Support, has_flat_top
from .scene import BuiltScene, Standing

SHARE = 0.02
"""Of the least side of two bodies, by how much one may be above or in the other at most where it lies on it."""


def resting(
    built: BuiltScene, types: Mapping[str, str | None], moving: Set[str], settled: Set[str]
) -> list[Standing]:
    """What the text puts `at` a point on top of things in `moving`, and is not `settled`; but not what has its middle
    above the top of something else."""
    boxes = {name: bounds(body.shape, body.pose) for name, body in built.bodies.items()}
    free = (n for n, body in built.bodies.items() if n not in settled and not is_region(body.type, types))
    loose = sorted((boxes[name][2], name) for name in free)
    supports = {name: has_flat_top(body.shape) and _is_upright(body.pose) for name, body in built.bodies.items()}
    under: dict[str, list[str]] = {}
    for name in built.bodies if loose else ():
        if supports[name]:
            for above in _upon(built, boxes, loose, name):
                under.setdefault(above, []).append(name)
    found = []
    for above, below in under.items():
        body = built.bodies[above]
        if moving.isdisjoint(below) or any(n not in moving and _bears(built.bodies[n], body) for n in below):
            continue
        assert body.span is not None
        found += [Standing(above, body.type, n, built.bodies[n].type, body.span) for n in below]
    return found


def _bears(support: ir.Body, body: ir.Body) -> bool:
    """Whether the middle of a body is above the top of another one."""
    top = Support.of(support)
    x, y, _ = (a - b for a, b in zip(position(body.pose), top.centre, strict=True))
    along, aside, _ = rotate(yaw(-top.heading), (x, y, 0.0))
    return top.carries((along, aside))


def tell(findings: Findings, found: Iterable[Standing]) -> None:
    """Warn of what counts as standing on others."""
    for subject, group in itertools.groupby(found, key=lambda s: s.subject):
        standing = list(group)
        below = " and ".join(f"`{s.support}`" for s in standing)
        one = len(standing) == 1
        what = ", which can be moved: it is carried along" if one else ": it keeps them where they are to each other"
        findings.report(
            "W0023",
            standing[0].span,
            f"`{subject}` lies on {below}{what}",
            help=f"write `on {standing[0].support}`, with `at` as an offset from the middle of its top",
        )


def _upon(built: BuiltScene, boxes: dict[str, Box], loose: list[tuple[float, str]], support: str) -> Iterator[str]:
    """Those of `loose`, in order of their lowest point, that lie on the top of a body."""
    under = boxes[support]
    one = built.bodies[support]
    for bottom, name in loose[bisect_left(loose, (under[5] - TOLERANCE, "")) :]:
        if bottom > under[5] + TOLERANCE:
            return
        over, other = boxes[name], built.bodies[name]
        most = min(TOLERANCE, SHARE * min(*box_sides(one.shape), *box_sides(other.shape)))
        if name == support or abs(bottom - under[5]) > most:
            continue
        if any(min(over[k + 3], under[k + 3]) - max(over[k], under[k]) <= most for k in (0, 1)):
            continue
        if _is_level_box(one) and _is_level_box(other):
            yield name
            continue
        from ..symbolic.geometry import Placed, shape_distance

        x, y, z = position(other.pose)
        lowered = Placed(other.shape, make((x, y, z - 2 * most), orientation(other.pose)))
        if shape_distance(Placed(one.shape, one.pose), lowered) == 0.0:
            yield name


def _is_level_box(body: ir.Body) -> bool:
    """Whether a body is the box around it along the axes of the world."""
    _, _, z, w = orientation(body.pose)
    return body.shape.kind == ir.ShapeKind.BOX and _is_upright(body.pose) and 0.0 in (z, w)


def _is_upright(pose: ir.Pose) -> bool:
    """Whether the z-axis of a body points up."""
    x, y, _, _ = orientation(pose)
    return x == 0.0 and y == 0.0
