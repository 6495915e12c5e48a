"""Joint values from which a hand comes near what it is to meet: the best of many that are drawn within the limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...compiler.ir import Module, Pose
from ..skeleton import Array
from ..transforms import compose, inverse, joint_frames, rotate

ANYWHERE = 128
"""How many postures are drawn from all that the joints can take …"""
TURNED = 8
"""… and how many in which one joint alone leaves its value, for each joint."""
NEAR = 0.1
"""Metres from the aim that are near enough: what is nearer is not better."""
BENT, TILTED = 0.03, 0.2
"""Metres that a posture may be farther off if its joints are a radian nearer, in the mean, or for the sine of a small
angle by which it is more upright."""
IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
UP = (0.0, 0.0, 1.0)

Stance = tuple[str, Pose]
"""The effector on which a module stands, and its pose in the world."""


@dataclass(frozen=True, slots=True)
class Aim:
    """Where an effector is to come: so far from a point `(3,)` in the world, metres; `upright` is the direction `(3,)`
    in its own frame that is to point up, if any."""

    effector: str
    point: Array
    distance: float
    upright: Array | None = None


def rooms(module: Module, room: float) -> Array:
    """The joint limits `(2, n)` with `room` kept to them: radians or metres, at most a tenth of the range."""
    found = [(j.lower, j.upper, min(room, 0.1 * (j.upper - j.lower))) for j in module.type.joints]
    return np.array([[lower + pull for lower, _, pull in found], [upper - pull for _, upper, pull in found]])


def _draw(values: Array, limits: Array, random: np.random.Generator) -> Array:
    """Postures `(N, n)`: `values` first, then with one joint drawn anew, then with all of them."""
    count = len(values)
    turned = np.tile(values, (count * TURNED, 1))
    which = np.repeat(np.arange(count), TURNED)
    turned[np.arange(len(turned)), which] = random.uniform(limits[0][which], limits[1][which])
    anywhere = random.uniform(limits[0], limits[1], (ANYWHERE, count))
    return np.concatenate([values[None, :], turned, anywhere])


def _frames(module: Module, stance: Stance, values: Array) -> Array:
    """The module frame and all joints' frames in the world `(n + 1, N, 7)`, of a module that stands on an effector."""
    foot = module.type.effector(stance[0])
    own = np.stack(joint_frames(module.type.joints, np.tile(IDENTITY, (len(values), 1)), values))
    base = compose(np.asarray(stance[1]), inverse(compose(own[foot.joint + 1], np.asarray(foot.placement))))
    return compose(base, own)


def reaching(
    module: Module, values: Array, stance: Stance, aim: Aim, room: float, random: np.random.Generator
) -> Array:
    """Joint values `(n,)` that bring a module which stands on an effector near to an aim; near `values` where that is
    as good."""
    limits = rooms(module, room)
    drawn = _draw(np.clip(values, limits[0], limits[1]), limits, random)
    frames = _frames(module, stance, drawn)
    hand = module.type.effector(aim.effector)
    there = compose(frames[hand.joint + 1], np.asarray(hand.placement))
    miss = np.maximum(np.abs(np.linalg.norm(there[:, :3] - aim.point, axis=1) - aim.distance), NEAR)
    if aim.upright is not None:
        miss += TILTED * np.linalg.norm(rotate(there[:, 3:], aim.upright) - UP, axis=1)
    bend = np.abs(drawn - values).sum(axis=1) / max(1, len(values)) * random.uniform(0.0, 1.0, len(drawn))
    return np.asarray(drawn[int((miss + BENT * bend).argmin())])
