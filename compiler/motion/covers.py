"""Spheres within a convex body that cover it, found by halving boxes until each is covered by one sphere."""

from __future__ import annotations

import numpy as np

from ..hulls import Array, Hull, hull
from ..ir import Shape, Vec3

STEPS = np.linspace(0.0, 4.0, 65)[:, None]
"""How far the centre of a sphere may be moved from that of its box into the body, in halves of the box's diagonal plus
the margin."""
MOST_HALVINGS = 40
BLOCK = 1024
"""So many boxes are looked at at once: some hundred megabytes and a tenth of a second, for bodies of many faces."""
PUSHES = 30
TOUCHING = 1e-6
"""Metres by which a sphere may stick out where a point was pushed into the body."""
TINY = 1e-12


def cover_hull(shape: Shape, margin: float) -> tuple[tuple[Vec3, float], ...]:
    """Spheres `(centre, radius)` within a convex body; no point of its surface is farther than `margin` from them."""
    body = hull(shape)
    centres, halves = np.zeros((1, 3)), body.sides[None] / 2
    spheres: list[tuple[Vec3, float]] = []
    for _ in range(MOST_HALVINGS):
        around = np.linalg.norm(halves, axis=1)
        on_surface = np.abs(body.distance(centres)) < around
        centres, halves, around = centres[on_surface], halves[on_surface], around[on_surface]
        if len(centres) == 0:
            break
        blocks = (slice(k, k + BLOCK) for k in range(0, len(centres), BLOCK))
        found = [_best(body, centres[b], around[b], margin) for b in blocks]
        places, radii, spare = (np.concatenate(parts) for parts in zip(*found, strict=True))
        done = spare >= 0.0
        x_y_z = places[done].tolist()
        spheres += [((x, y, z), r) for (x, y, z), r in zip(x_y_z, radii[done].tolist(), strict=True)]
        centres, halves = _halved(centres[~done], halves[~done])
    return tuple(spheres)


def _best(body: Hull, centres: Array, around: Array, margin: float) -> tuple[Array, Array, Array]:
    """Per box the sphere that covers best what of the body is in it: its place (M, 3), its radius (M,), and how much is
    left of the margin (M,), negative when it does not cover it.

    The centre is moved from that of the box against a weighted sum of the faces' normals. What is in the body is
    nowhere farther out along that sum than the faces are, which bounds how far it can be from the new centre."""
    reach = around + margin
    slack = body.offsets - centres @ body.normals.T
    weights = np.maximum((reach + around)[:, None] - slack, 0.0)
    inward = -weights @ body.normals
    length = np.maximum(np.linalg.norm(inward, axis=1), TINY)
    outside = (weights * slack).sum(axis=1) / length
    moved = STEPS * reach
    places = centres + moved[:, :, None] * (inward / length[:, None])
    radii = -body.distance(places)
    farthest = np.sqrt(np.maximum(around**2 + 2 * moved * outside + moved**2, 0.0))
    nearest = _projected(body, centres)
    places = np.concatenate([places, nearest[None]])
    depth = -body.distance(nearest)
    radii = np.concatenate([radii, np.where(depth < 0.0, depth + TOUCHING, depth)[None]])
    moved = np.concatenate([moved, np.linalg.norm(nearest - centres, axis=1)[None]])
    farthest = np.minimum(np.concatenate([farthest, np.full((1, len(centres)), np.inf)]), around + moved)
    spare = np.where(radii >= 0.0, radii + margin - farthest, -np.inf)
    chosen = spare.argmax(axis=0), np.arange(len(centres))
    return places[chosen], radii[chosen], spare[chosen]


def _projected(body: Hull, points: Array) -> Array:
    """Points (M, 3) pushed into the body, across one violated face after the other."""
    for _ in range(PUSHES):
        beyond = points @ body.normals.T - body.offsets
        worst = beyond.argmax(axis=1)
        points = points - np.maximum(beyond.max(axis=1), 0.0)[:, None] * body.normals[worst]
    return points


def _halved(centres: Array, halves: Array) -> tuple[Array, Array]:
    """Each box cut in two across its longest side."""
    rows, longest = np.arange(len(halves)), halves.argmax(axis=1)
    smaller, shift = halves.copy(), np.zeros_like(halves)
    smaller[rows, longest] /= 2
    shift[rows, longest] = smaller[rows, longest]
    return np.concatenate([centres - shift, centres + shift]), np.concatenate([smaller, smaller])
