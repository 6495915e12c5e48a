"""Joint values from which a hand comes near what it is to meet: the best of many that are drawn within the limits."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .....compiler import poses
from .....compiler.ir import JointKind, Module, ModuleType, Pose
from .....langs.frozen import dataclass
from ....geometry.transforms import compose, cross, inverse, joint_frames, multiply, rotate
from ....skeleton import Array
from .settings import KEYFRAMES

IDENTITY = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
UP = (0.0, 0.0, 1.0)

Stance = tuple[str, Pose]
"""The effector on which a module stands, "" for the module frame, and its pose in the world."""


@dataclass(frozen=True, slots=True)
class Aim:
    """Where an effector is to come: so far from a point `(3,)` in the world, metres; `upright` is the direction `(3,)`
    in its own frame that is to point up, if any."""

    effector: str
    point: Array
    distance: float
    upright: Array | None = None


def _placed(type_: ModuleType, name: str) -> tuple[int, Pose]:
    """The joint that carries an effector, and its pose there; "" is the module frame."""
    end = type_.effector(name) if name else None
    return (-1, IDENTITY) if end is None else (end.joint, end.placement)


def rooms(module: Module, room: float) -> Array:
    """The joint limits `(2, n)` with `room` kept to them: radians or metres, at most a tenth of the range."""
    found = [(j.lower, j.upper, min(room, 0.1 * (j.upper - j.lower))) for j in module.type.joints]
    return np.array([[lower + pull for lower, _, pull in found], [upper - pull for _, upper, pull in found]])


def _draw(values: Array, limits: Array, random: np.random.Generator) -> Array:
    """Postures `(N, n)`: `values` first, then with one joint drawn anew, then with all of them."""
    count = len(values)
    turned = np.tile(values, (count * KEYFRAMES.postures_turned, 1))
    which = np.repeat(np.arange(count), KEYFRAMES.postures_turned)
    turned[np.arange(len(turned)), which] = random.uniform(limits[0][which], limits[1][which])
    anywhere = random.uniform(limits[0], limits[1], (KEYFRAMES.postures_anywhere, count))
    return np.concatenate([values[None, :], turned, anywhere])


def standing(type_: ModuleType, stance: Stance, values: Array) -> tuple[Array, list[Array]]:
    """Of a module that stands on an effector, for joint values `(N, n)`: poses `(N, 7)` of its frame in the world, and
    of its frame and joints in its frame."""
    foot, placement = _placed(type_, stance[0])
    own = joint_frames(type_.joints, np.tile(IDENTITY, (len(values), 1)), values)
    return compose(np.asarray(stance[1]), inverse(compose(own[foot + 1], np.asarray(placement)))), own


def hands(type_: ModuleType, stance: Stance, effector: str, values: Array) -> Array:
    """Poses in the world `(N, 7)` of an effector of a module that stands on another one, for joint values `(N, n)`."""
    hand = type_.effector(effector)
    base, own = standing(type_, stance, values)
    return compose(base, compose(own[hand.joint + 1], np.asarray(hand.placement)))


@lru_cache(maxsize=256)
def freedom(type_: ModuleType, foot: str, hand: str) -> int:
    """In how many independent directions, of six, one effector of a module can move while another one rests."""
    random = np.random.default_rng(0)
    lower, upper = np.array([[j.lower, j.upper] for j in type_.joints]).reshape(-1, 2).T
    values = random.uniform(np.maximum(lower, -np.pi), np.minimum(upper, np.pi))
    varied = KEYFRAMES.posture_difference * np.eye(len(values))
    moved = hands(type_, (foot, IDENTITY), hand, np.concatenate([values[None], values + varied]))
    turns = multiply(moved[1:, 3:], inverse(moved[:1])[:, 3:])
    twists = np.concatenate([moved[1:, :3] - moved[:1, :3], 2.0 * turns[:, :3]], axis=1) / KEYFRAMES.posture_difference
    least = KEYFRAMES.posture_rank * max(1.0, float(np.abs(twists).max(initial=0.0)))
    return int(np.linalg.matrix_rank(twists, tol=least))


def reaching(
    module: Module, values: Array, stance: Stance, aim: Aim, room: float, random: np.random.Generator
) -> Array:
    """Joint values `(n,)` that bring a module which stands on an effector near to an aim; near `values` where that is
    as good."""
    limits = rooms(module, room)
    drawn = _draw(np.clip(values, limits[0], limits[1]), limits, random)
    there = hands(module.type, stance, aim.effector, drawn)
    miss = np.maximum(np.abs(np.linalg.norm(there[:, :3] - aim.point, axis=1) - aim.distance), KEYFRAMES.posture_near)
    if aim.upright is not None:
        miss += KEYFRAMES.tilted * np.linalg.norm(rotate(there[:, 3:], aim.upright) - UP, axis=1)
    bend = np.abs(drawn - values).sum(axis=1) / max(1, len(values)) * random.uniform(0.0, 1.0, len(drawn))
    return np.asarray(drawn[int((miss + KEYFRAMES.bent * bend).argmin())])


def meeting(
    ends: tuple[tuple[Module, Array, Stance, str], tuple[Module, Array, Stance, str]], distance: float, room: float,
    random: np.random.Generator,
) -> tuple[Array, Array]:  # fmt: skip
    """Joint values of two modules that stand on their own, each with its values now, its stance and an effector, so
    that the effectors face each other, so far apart: the best of all pairs that are drawn."""
    drawn, there = [], []
    for module, values, stance, effector in ends:
        limits = rooms(module, room)
        drawn.append(_draw(np.clip(values, limits[0], limits[1]), limits, random))
        there.append(hands(module.type, stance, effector, drawn[-1]))
    normals = [rotate(hands[:, 3:], np.array(UP)) for hands in there]
    apart = max(float(np.linalg.norm(np.subtract(ends[0][2][1][:3], ends[1][2][1][:3]))), distance)
    met = there[0][:, :3] + distance * normals[0]
    miss = np.linalg.norm(met[:, None] - there[1][None, :, :3], axis=2) / apart
    miss += KEYFRAMES.averted * np.linalg.norm(normals[0][:, None] + normals[1][None], axis=2)
    one, other = np.unravel_index(int(miss.argmin()), miss.shape)
    return drawn[0][one], drawn[1][other]


def closing(module: Module, values: Array, stance: Stance, aim: Aim, room: float) -> Array:
    """Joint values `(n,)` near given ones that bring an effector to an aim itself, or as near as damped Gauss-Newton
    steps within the limits do."""
    limits = rooms(module, room)
    best, least = values, np.inf
    for _ in range(KEYFRAMES.posture_steps):
        there, slopes = _position_and_slopes(module.type, stance, aim.effector, values)
        miss = there - aim.point
        length = float(np.linalg.norm(miss))
        if length > KEYFRAMES.posture_slow * least:
            break
        best, least = values, length
        if length < KEYFRAMES.posture_closed:
            break
        wish = values - _step(slopes, miss)
        slopes[((values <= limits[0]) & (wish < values)) | ((values >= limits[1]) & (wish > values))] = 0.0
        values = np.clip(values - _step(slopes, miss), limits[0], limits[1])
    return best


def _step(slopes: Array, miss: Array) -> Array:
    return np.asarray(slopes @ np.linalg.solve(slopes.T @ slopes + KEYFRAMES.posture_damping * np.eye(3), miss))


def _position_and_slopes(type_: ModuleType, stance: Stance, effector: str, values: Array) -> tuple[Array, Array]:
    """Where an effector is `(3,)` in the world, of a module that stands on another one, and its derivatives `(n, 3)` by
    the joints."""
    (foot, placement), hand = _placed(type_, stance[0]), type_.effector(effector)
    frames = poses.joint_frames(type_, IDENTITY, values.tolist())
    base = poses.compose(stance[1], poses.inverse(poses.compose(frames[foot], placement)))
    there = np.array(poses.compose(base, poses.compose(frames[hand.joint], hand.placement))[:3])
    slopes = np.zeros((len(values), 3))
    for start, sign in ((hand.joint, 1.0), (foot, -1.0)):
        index = start
        while index >= 0:
            joint, frame = type_.joints[index], poses.compose(base, frames[index])
            axis = np.array(poses.rotate(poses.orientation(frame), joint.axis))
            turning = joint.kind == JointKind.REVOLUTE
            slopes[index] += sign * (cross(axis, there - np.array(frame[:3])) if turning else axis)
            index = joint.parent
    for index, joint in enumerate(type_.joints):
        if joint.follows is not None:
            slopes[joint.follows.leader] += joint.follows.factor * slopes[index]
            slopes[index] = 0.0
    return there, slopes
