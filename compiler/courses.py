"""Where a body that moves on its own is at a time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence

from .ir import Course, Vec3


def centre_at(start: Vec3, courses: Iterable[Course], time: float) -> Vec3:
    """The centre of a body at `time` (s), in the world. `start` is its centre at time 0, `courses` are its own."""
    centre = start
    begun = sorted((c for c in courses if c.start <= time), key=lambda c: c.start)
    ends = [*(c.start for c in begun[1:]), time]
    for course, end in zip(begun, ends, strict=False):
        centre = _along(centre, course, end - course.start)
    return centre


def way_length(points: Sequence[Vec3]) -> float:
    """The length of the way through `points`, metres."""
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))


def _along(begin: Vec3, course: Course, seconds: float) -> Vec3:
    """Where a body is that has been on a course for some time."""
    points = [begin, *course.points]
    whole = way_length(points)
    if course.speed == 0 or whole == 0:
        return course.points[-1]
    gone = course.speed * seconds
    if course.returns:
        gone %= 2 * whole
        gone = min(gone, 2 * whole - gone)
    for one, other in itertools.pairwise(points):
        leg = math.dist(one, other)
        if gone < leg:
            x, y, z = (a + (b - a) * gone / leg for a, b in zip(one, other, strict=True))
            return x, y, z
        gone -= leg
    return points[-1]
