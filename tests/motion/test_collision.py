"""Spheres that cover shapes, pairs that can meet, contacts of phases, reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.compiler.ir import Shape
from tamplang.compiler.motion.collision import (
    CHECK_MARGIN,
    PATH_MARGIN,
    contacts,
    cover,
    module_spheres,
    pair,
    taper,
)
from tamplang.compiler.motion.module_reach import reach
from tamplang.runtime.planner.motion.phases.joint_forest import link_frames

from .fixtures import CRAWLER, climb_alone, climb_together, pick_and_place

LENGTH = st.floats(0.01, 0.25)
SHAPES = st.one_of(
    st.tuples(LENGTH, LENGTH, LENGTH).map(lambda s: Shape("box", s)),
    st.tuples(st.floats(0.01, 0.1), LENGTH).map(lambda s: Shape("capsule", s)),
    st.tuples(st.floats(0.01, 0.1), LENGTH).map(lambda s: Shape("cylinder", s)),
    st.floats(0.01, 0.2).map(lambda r: Shape("sphere", (r,))),
)


def surface(shape: Shape, random: np.random.Generator, count: int = 300) -> np.ndarray:
    """Points on a shape, its edges and corners included."""
    u = random.uniform(-1.0, 1.0, (count, 3))
    if shape.kind == "box":
        u[np.arange(count), random.integers(0, 3, count)] = np.sign(u[:, 0])
        u[: count // 3] = np.sign(u[: count // 3])
        return u * np.array(shape.size) / 2
    directions = u / np.linalg.norm(u, axis=1)[:, None]
    if shape.kind == "sphere":
        return directions * shape.size[0]
    radius, half = shape.size[0], shape.size[1] / 2
    if shape.kind == "capsule":
        walls = np.arange(count) % 2 == 0
        flat = directions * [1, 1, 0]
        flat /= np.linalg.norm(flat, axis=1)[:, None]
        points = np.where(walls[:, None], flat, directions) * radius
        points[:, 2] += half * np.where(walls, u[:, 1], np.sign(directions[:, 2]))
        return points
    angle = math.pi * u[:, 0]
    across = radius * np.where(np.arange(count) % 2, 1.0, np.sqrt(np.abs(u[:, 1])))
    height = np.where(np.arange(count) % 4, np.sign(u[:, 2]), u[:, 2]) * half
    height[across < radius] = half * np.sign(u[across < radius, 2])
    return np.stack([across * np.cos(angle), across * np.sin(angle), height], axis=1)


@settings(deadline=None)
@given(SHAPES, st.sampled_from([PATH_MARGIN, CHECK_MARGIN]), st.integers(0, 99))
def test_spheres_cover_their_shape_within_the_margin_and_stay_inside(shape: Shape, margin: float, seed: int) -> None:
    spheres = cover(shape, margin)
    centres, radii = np.array([c for c, _ in spheres]), np.array([r for _, r in spheres])
    points = surface(shape, np.random.default_rng(seed))
    outside = np.linalg.norm(points[:, None] - centres, axis=2) - radii
    assert outside.min(axis=1).max() <= margin + 1e-9
    assert outside.min() >= -1e-3 * radii.max() - 1e-9


def test_crawler_has_an_exact_sphere_per_effector_and_few_link_spheres() -> None:
    spheres = module_spheres(CRAWLER)
    assert [(s.effector, s.radius, s.exact) for s in spheres[:2]] == [("A", 0.05, True), ("B", 0.05, True)]
    assert len(spheres) <= 14
    assert all(s.effector is None and s.radius == pytest.approx(0.04) for s in spheres[2:])


@given(st.lists(st.floats(-2.0, 2.0), min_size=7, max_size=7))
def test_reach_bounds_every_sphere(values: list[float]) -> None:
    frames = link_frames(CRAWLER, np.array([0, 0, 0, 0, 0, 0, 1, *values]))
    placed = [(frames[s.joint] @ np.array([*s.centre, 1.0]))[:3] for s in module_spheres(CRAWLER)]
    tip = frames[6][:3, 3]
    assert max(math.dist(tip, p) for p in placed) <= reach(CRAWLER, "B")


def test_a_foot_that_is_left_touches_only_at_the_start() -> None:
    first, second, third, last = contacts(climb_alone(3))
    ground, stair = pair("ground", "c[1].A"), pair("stair[1]", "c[1].B")
    assert ground in first.during and stair in first.end and not first.start
    assert ground in second.start and stair in second.during and ground not in second.during
    assert ground not in third.start
    assert pair("c[1].A", "target") in last.end


def test_docked_effectors_touch_during_every_later_phase() -> None:
    docked = pair("c[1].B", "c[2].B")
    first, *later = contacts(climb_together(2))
    assert docked in first.end
    assert all(docked in phase.during for phase in later)


def test_an_item_that_is_put_down_touches_the_gripper_at_the_next_start() -> None:
    _, place, grasp, _ = contacts(pick_and_place(2))
    assert pair("c.B", "item[1]") in place.during
    assert pair("table", "item[1]") in place.start
    assert pair("goal_tray", "item[1]") in place.end
    assert pair("c.B", "item[1]") in grasp.start


def test_the_margin_tapers_next_to_contacts() -> None:
    first, second, *_ = contacts(climb_alone(3))
    times = np.arange(21.0)
    assert taper(first, pair("ground", "c[1].A"), times, 20) is None
    landing = taper(first, pair("stair[1]", "c[1].B"), times, 20)
    leaving = taper(second, pair("ground", "c[1].A"), times, 20)
    assert landing is not None and leaving is not None
    assert landing[-4:] == pytest.approx([1.0, 2 / 3, 1 / 3, 0.0]) and landing[:17] == pytest.approx(1.0)
    assert leaving == pytest.approx(landing[::-1])
