"""Bodies that move on their own into things that stand still, as far as the start of the scene tells."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator

from .. import ir
from ..checks.findings import Findings
from ..courses import centre_at
from ..poses import position
from .check_start import TOLERANCE, Box, Volume, penetration, volumes

STEP = 0.02
"""How far apart a body is looked at along its way, metres; farther where the way is long."""
MOST_PLACES = 200


def check_ways(findings: Findings, world: ir.World, carried: Iterable[tuple[str, str]]) -> None:
    """Warn of every body whose way leads into a module or a resting body. Pairs that touch at the start may; what
    stands on it, by `carried` pairs (thing, support), goes along."""
    if not world.courses:
        return
    moving = {c.body for c in world.courses}
    solid = {body.name for body in world.solids} | world.modules.keys()
    found = [v for v in volumes(world) if v.owner in solid]
    resting = [v for v in found if v.owner not in moving]
    owners = {v.name: v.owner for v in found}
    standing = [(owners.get(thing, thing), owners.get(support, support)) for thing, support in carried]
    for volume in (v for v in found if v.owner in moving):
        along = _standing_on(volume.owner, standing)
        _check_body(findings, world, volume, [v for v in resting if v.owner not in along])


def _standing_on(body: str, standing: list[tuple[str, str]]) -> set[str]:
    """What stands on a body, directly or on other things."""
    found = {body}
    for _ in standing:
        found |= {thing for thing, support in standing if support in found}
    return found - {body}


def _check_body(findings: Findings, world: ir.World, volume: Volume, resting: list[Volume]) -> None:
    begin = position(volume.pose)
    met: set[str] = set()
    own = [c for c in world.courses if c.body == volume.owner]
    for i, course in enumerate(own):
        places = list(_places(centre_at(begin, own[:i], course.start), course))
        around = _hull(_at(volume, begin, place).bounds for place in places)
        for other in (v for v in resting if v.owner not in met and _overlap(around, v.bounds)):
            if penetration(volume, other) > TOLERANCE:
                continue
            deep = max(_depth(_at(volume, begin, place), other) for place in places)
            if deep > TOLERANCE:
                met.add(other.owner)
                findings.report(
                    "W0007",
                    course.span,
                    f"`{course.body}` moves {deep * 1000:.0f} mm into `{other.owner}`, which stands there at the start",
                    labels=[(other.span, f"`{other.owner}` is declared here")],
                )


def _places(begin: ir.Vec3, course: ir.Course) -> Iterator[ir.Vec3]:
    """Where a course leads, from the place at which it starts; a jump leads only to its end."""
    if course.speed == 0:
        yield course.points[-1]
        return
    here = begin
    for there in course.points:
        count = min(MOST_PLACES, max(1, math.ceil(math.dist(here, there) / STEP)))
        for k in range(1, count + 1):
            x, y, z = (a + (b - a) * k / count for a, b in zip(here, there, strict=True))
            yield x, y, z
        here = there


def _at(volume: Volume, begin: ir.Vec3, place: ir.Vec3) -> Volume:
    """The volume with its centre moved from `begin` to `place`."""
    x, y, z = (b - a for a, b in zip(begin, place, strict=True))
    low_x, low_y, low_z, high_x, high_y, high_z = volume.bounds
    box = low_x + x, low_y + y, low_z + z, high_x + x, high_y + y, high_z + z
    return dataclasses.replace(volume, pose=(*place, *volume.pose[3:]), bounds=box)


def _hull(boxes: Iterable[Box]) -> Box:
    """The box around some boxes."""
    columns = list(zip(*boxes, strict=True))
    low_x, low_y, low_z = (min(c) for c in columns[:3])
    high_x, high_y, high_z = (max(c) for c in columns[3:])
    return low_x, low_y, low_z, high_x, high_y, high_z


def _overlap(one: Box, other: Box) -> bool:
    return all(min(one[i + 3], other[i + 3]) - max(one[i], other[i]) > TOLERANCE for i in range(3))


def _depth(volume: Volume, other: Volume) -> float:
    return penetration(volume, other) if _overlap(volume.bounds, other.bounds) else 0.0
