"""Where things go that are put down on one body: a grid over its top, laid out for the whole skeleton at once.

Where few go on a body, each finds room by itself, but for bodies of several parts: what ends at the wall of a bin
without collisions is pushed out on its far side as soon as they count.
"""

from __future__ import annotations

import math

import numpy as np

from .....compiler.extents import box_sides
from .....compiler.ir import Body
from .....compiler.kept_pairs import keeps_pose, kept_pairs
from .....compiler.motion.collision import bounding_radius
from .....compiler.poses import compose, rotate
from .....compiler.remembering import remembered
from ....geometry.attachments import followers
from ....skeleton import Array, Skeleton
from .settings import KEYFRAMES

Places = dict[tuple[int, str], Array]
"""Where the middle of a thing goes that is put down in a phase, `(2,)`, x and y in the world, by phase and thing."""


def outline(body: Body) -> Array:
    """Lengths in x and y of the top on which things stand, of a body that lies in its own axes."""
    return np.array(box_sides(body.shape.solids[0].shape)[:2])


def _middle(body: Body) -> tuple[Array, Array]:
    """The middle of the top on which things stand, x and y in the world, and the axes of the body there as columns."""
    x, y, *_ = compose(body.pose, body.shape.solids[0].placement)
    (a, b, _), (c, d, _) = (rotate(body.pose[3:], axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    return np.array([x, y]), np.array([[a, c], [b, d]])


def _put_down(skeleton: Skeleton) -> dict[str, list[tuple[int, str]]]:
    """By body that rests: the phases that put things down on it, and the things, in the order of the skeleton."""
    problem = skeleton.problem
    bodies = problem.world.bodies
    found: dict[str, list[tuple[int, str]]] = {}
    for number, phase in enumerate(skeleton.phases):
        for literal in sorted(phase.added):
            kept = keeps_pose(problem, literal)
            if kept and set(kept) <= bodies.keys() and kept[0] not in followers(problem, phase.mode):
                found.setdefault(kept[0], []).append((number, kept[1]))
    return found


def _resting(skeleton: Skeleton, base: str) -> list[Body]:
    """What lies on a body at the start."""
    bodies = skeleton.problem.world.bodies
    kept = kept_pairs(skeleton.problem, skeleton.problem.init_motion)
    return [bodies[thing] for below, thing in kept if below == base and thing in bodies]


def _cells(sides: Array, count: int, least: float, most: float, taken: list[tuple[Array, float]]) -> list[Array]:
    """At least `count` free places on a grid over a rectangle, as wide as fits; none when it does not fit. The
    rectangle is of the places' middles; `taken` tells where something lies, and how far to stay off it."""
    wide = most
    while True:
        rows = [int(side / wide + 1e-9) + 1 for side in sides]
        steps = [min(most, side / (n - 1)) if n > 1 else 0.0 for side, n in zip(sides, rows, strict=True)]
        x, y = (step * (np.arange(n) - (n - 1) / 2) for step, n in zip(steps, rows, strict=True))
        cells = [np.array([a, b]) for a in x for b in y]
        free = [c for c in cells if all(math.dist(c, there) >= off for there, off in taken)]
        if len(free) >= count:
            return sorted(free, key=lambda c: float(c @ c))[:count]
        if wide <= least:
            return []
        wide = max(0.95 * wide, least)


@remembered(8)
def places(skeleton: Skeleton) -> Places:
    """Places of all things that are put down on bodies that get many of them; empty where the tops are too small."""
    world = skeleton.problem.world
    result: Places = {}
    for base, put_down in _put_down(skeleton).items():
        later = [thing for body, thing in skeleton.coming if body == base]
        things = list(dict.fromkeys([*(name for _, name in put_down), *later]))
        if len(things) < KEYFRAMES.laid_out_from and not world.bodies[base].shape.parts:
            continue
        middle, axes = _middle(world.bodies[base])
        resting = [
            ((np.array(body.pose[:2]) - middle) @ axes, bounding_radius(body.shape))
            for body in _resting(skeleton, base)
            if body.name not in things
        ]
        found = _lay_out(world.bodies[base], [world.bodies[name] for name in things], resting)
        order = sorted(found, key=lambda c: (-round(float(np.hypot(*c)), 6), *c))
        cells = dict(zip(things, order, strict=False))
        result |= {(number, name): middle + axes @ cells[name] for number, name in put_down if name in cells}
    return result


def _lay_out(base: Body, things: list[Body], resting: list[tuple[Array, float]]) -> list[Array]:
    """As many places on a base as there are things, from its middle: with room to turn them, else side by side."""
    widths = [box_sides(thing.shape)[:2] for thing in things]
    radius = max(float(np.hypot(*width)) / 2 for width in widths)
    side = max(float(max(width)) for width in widths)
    wide = 2 * radius + KEYFRAMES.gap
    for edge, least in ((radius + KEYFRAMES.edge, wide), (KEYFRAMES.tight_edge, side + KEYFRAMES.tight_gap)):
        taken = [(place, least / 2 + KEYFRAMES.gap / 2 + around) for place, around in resting]
        sides = np.maximum(outline(base) - 2 * edge, 0.0)
        found = _cells(sides, len(things), least, max(least, KEYFRAMES.widest_grid * wide), taken)
        if found:
            return found
    return []
