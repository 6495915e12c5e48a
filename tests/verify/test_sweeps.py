"""What shapes sweep: nothing that touches is left out, and what lies between two instants is inside."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tamplang.runtime.plan import ShapeRecord
from tamplang.runtime.verify.geometry import Array, Frames
from tamplang.runtime.verify.sampler import IDENTITY
from tamplang.runtime.verify.shapes import Ruler, transform
from tamplang.runtime.verify.solids import Solid, _solid
from tamplang.runtime.verify.sweeps import (
    edges,
    lower_bound,
    near_instants,
    near_pairs,
    near_resting,
    relative_steps,
    sweep,
)

SHAPES = {"box": [0.3, 0.1, 0.2], "sphere": [0.1], "capsule": [0.05, 0.3], "cylinder": [0.1, 0.2]}
FINE = 20


def solid(kind: str) -> Solid:
    return _solid(kind, kind, None, IDENTITY, ShapeRecord(kind, SHAPES[kind]))


def motion(draw: np.random.Generator, times: Array) -> Frames:
    """A turn about an axis and a way along a bent line."""
    speeds, way = draw.uniform(-1.5, 1.5, size=3), draw.uniform(-0.5, 0.5, size=(3, 3))
    rotation = Rotation.from_rotvec(times[:, None] * speeds).as_matrix()
    return Frames(np.column_stack([np.ones_like(times), times, times**2]) @ way, rotation)


def frame(frames: Frames, index: int) -> Any:
    at = index if len(frames) > 1 else 0
    return transform(frames.position[at], frames.rotation[at])


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("resting", [True, False])
def test_bounds_hold(seed: int, resting: bool) -> None:
    draw = np.random.default_rng([seed, resting])
    first, second = (solid(str(draw.choice(list(SHAPES)))) for _ in range(2))
    times = np.linspace(0.0, 1.0, 31)
    none = np.zeros(len(times) - 1)
    a = sweep(first, motion(draw, times), none + 0.05)
    b = sweep(second, motion(draw, times[:1] if resting else times), none + 0.05)
    distances = np.array([
        Ruler().distance(first.solid, frame(a.frames, t), second.solid, frame(b.frames, t)) for t in range(len(times))
    ])  # fmt: skip
    near = near_instants(a, b)
    touching = np.flatnonzero(distances <= 0.0)
    if near is None:
        assert not len(touching)
        return
    assert len(near_pairs(*edges([a, b]), np.array([[0, 1]]))) == 1
    if resting:
        assert near_resting(a, *edges([b, b])) == [near, near]
    assert all(near[0] <= t <= near[1] for t in touching)
    assert (lower_bound(a, b, *near) <= distances[near[0] : near[1] + 1] + 1e-6).all()
    assert (np.abs(np.diff(distances[near[0] : near[1] + 1])) <= relative_steps(a, b, *near) + 1e-6).all()


@pytest.mark.parametrize("kind", SHAPES)
def test_boxes_hold_what_lies_between_instants(kind: str) -> None:
    made = solid(kind)
    times = np.linspace(0.0, 1.0, 11)
    draw = np.random.default_rng(3)
    speeds, way = draw.uniform(-1.5, 1.5, size=3), draw.uniform(-0.5, 0.5, size=(3, 3))
    acceleration = 2.0 * np.linalg.norm(way[2]) + np.linalg.norm(speeds) ** 2 * made.reach
    coarse = sweep(made, motion(np.random.default_rng(3), times), np.full(10, acceleration * 0.1**2 / 8.0))
    fine = sweep(made, motion(np.random.default_rng(3), np.linspace(0.0, 1.0, FINE * 10 + 1)), np.zeros(FINE * 10))
    for interval in range(10):
        part = slice(FINE * interval, FINE * (interval + 1))
        points = fine.frames[part].position
        reach = np.einsum("tij,mj->tmi", fine.frames[part].rotation, made.points) + points[:, None]
        assert (coarse.low[interval] <= reach.min(axis=(0, 1)) - made.ball).all()
        assert (coarse.high[interval] >= reach.max(axis=(0, 1)) + made.ball).all()
