"""Exact distances against coal's own, and what moves when they change."""

from __future__ import annotations

import coal
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tamplang.compiler.ir import Shape
from tamplang.runtime.geometry.exact_distances import Forms, Posed, coal_geometry, distances

PRISM = tuple(float(c) for z in (-0.05, 0.05) for x, y in ((0, 0.06), (0.05, -0.03), (-0.05, -0.03)) for c in (x, y, z))
SHAPES = [
    Shape("sphere", (0.05,)), Shape("capsule", (0.03, 0.2)), Shape("box", (0.1, 0.3, 0.02)),
    Shape("box", (1, 1, 0.001)),
    Shape("cylinder", (0.05, 0.1)), Shape("convex", PRISM),
]  # fmt: skip
COUNT = 1500


def posed(forms: Forms, random: np.random.Generator) -> Posed:
    """Shapes near each other; a third of them lie along the axes, where nearest points are many."""
    rotation = Rotation.random(COUNT, random_state=random).as_matrix()
    rotation[: COUNT // 3] = np.eye(3)
    return Posed(forms, random.integers(0, len(SHAPES), COUNT), random.normal(0.0, 0.2, (COUNT, 3)), rotation)


@pytest.fixture(scope="module")
def pairs() -> tuple[Posed, Posed]:
    random, forms = np.random.default_rng(1), Forms(SHAPES)
    return posed(forms, random), posed(forms, random)


def by_coal(first: Posed, second: Posed, k: int) -> float:
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    sides = (
        (coal_geometry(SHAPES[s.form[k]]), coal.Transform3s(s.rotation[k].copy(), s.position[k].copy()))
        for s in (first, second)
    )
    return float(coal.distance(*next(sides), *next(sides), request, coal.DistanceResult()))


def test_values_are_those_of_coal_and_bounds_are_bounds(pairs: tuple[Posed, Posed]) -> None:
    found = distances(*pairs, np.full(COUNT, 0.1))
    truth = np.array([by_coal(*pairs, k) for k in range(COUNT)])
    apart = found.exact & (truth > 1e-6)
    assert apart.sum() > 300 and found.value[apart] == pytest.approx(truth[apart], abs=1e-5)
    assert (found.value[~found.exact & (truth > 0.0)] <= truth[~found.exact & (truth > 0.0)] + 1e-5).all()
    assert (truth[~found.exact] > 0.1 - 1e-5).all()
    deep = found.exact & (truth < -1e-5)
    assert deep.sum() > 100 and (found.value[deep] < 0.0).all() and (found.value[deep] >= truth[deep] - 1e-4).all()


def test_of_round_shapes_only_the_axis_counts(pairs: tuple[Posed, Posed]) -> None:
    bare = []
    for side in pairs:
        rotation = side.rotation.copy()
        capsules, balls = (np.flatnonzero(side.form == k) for k in (1, 0))
        rotation[capsules, :, :2] = 0.0
        rotation[balls] = 0.0
        bare.append(Posed(side.forms, side.form, side.position, rotation))
    found, full = distances(*bare, np.full(COUNT, 0.1)), distances(*pairs, np.full(COUNT, 0.1))
    assert found.value == pytest.approx(full.value, abs=1e-5)


def test_round_shapes_turn_about_their_nearest_points(pairs: tuple[Posed, Posed]) -> None:
    """What a capsule at a hull does when it turns a little, also deep within: the nearest points are on its axis."""
    first, second = pairs
    found, random = distances(first, second, np.full(COUNT, 0.1)), np.random.default_rng(5)
    turn = 1e-4 * random.normal(size=(COUNT, 3))
    ends = [
        distances(
            Posed(first.forms, first.form, first.position, Rotation.from_rotvec(s * turn).as_matrix() @ first.rotation),
            second, np.full(COUNT, 0.1),
        ).value
        for s in (1, -1)
    ]  # fmt: skip
    lever = np.cross(turn, found.on_first - first.position)
    slope = (ends[0] - ends[1]) - 2.0 * (found.normal * lever).sum(axis=1)
    chosen = found.exact & (first.form == 1) & (second.form == 5) & (np.abs(found.value) > 2e-3)
    chosen[: COUNT // 3] = False
    at = found.on_first[chosen] - first.position[chosen]
    assert chosen.sum() > 5 and np.linalg.norm(at, axis=1).max() <= 0.1 + 1e-6
    assert np.quantile(np.abs(slope[chosen]), 0.9) < 4e-7


def test_normals_are_the_slopes_of_the_distance(pairs: tuple[Posed, Posed]) -> None:
    first, second = pairs
    found = distances(first, second, np.full(COUNT, 0.1))
    step = 1e-5 * np.random.default_rng(2).normal(size=(COUNT, 3))
    ends = [distances(Posed(first.forms, first.form, first.position + s * step, first.rotation), second,
                      np.full(COUNT, 0.1)).value for s in (1, -1)]  # fmt: skip
    slope = (ends[0] - ends[1]) - 2.0 * (found.normal * step).sum(axis=1)
    apart = found.exact & (found.value > 2e-3) & (found.value < 0.09)
    assert apart.sum() > 100 and np.quantile(np.abs(slope[apart]), 0.98) < 2e-6


def test_nearest_points_are_as_far_apart_as_the_shapes(pairs: tuple[Posed, Posed]) -> None:
    found = distances(*pairs, np.full(COUNT, 0.1))
    between = ((found.on_first - found.on_second) * found.normal).sum(axis=1) - pairs[0].radius - pairs[1].radius
    round_or_box = found.exact & (pairs[0].kind < 2) & (pairs[1].kind < 2) & (found.value > 0.0)
    assert between[round_or_box] == pytest.approx(found.value[round_or_box], abs=1e-5)


def test_an_axis_through_a_box_is_measured_where_it_is_deepest() -> None:
    random, size, length = np.random.default_rng(2), np.array([0.2, 0.3, 0.1]), 0.4
    forms = Forms([Shape("capsule", (0.02, length)), Shape("box", tuple(size))])
    turned, count = Rotation.random(100, random_state=random).as_matrix(), 100
    capsules = Posed(forms, np.zeros(count, dtype=np.intp), random.normal(0.0, 0.05, (count, 3)), turned)
    boxes = Posed(forms, np.ones(count, dtype=np.intp), np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1)))
    along = np.linspace(-length / 2, length / 2, 4001)
    points = capsules.position[:, None] + along[:, None] * turned[:, None, :, 2]
    depth = (size / 2 - np.abs(points)).min(axis=2).max(axis=1)
    through = depth > 1e-3
    assert through.sum() > 80
    for found in (distances(capsules, boxes, np.zeros(count)), distances(boxes, capsules, np.zeros(count))):
        assert found.value[through] == pytest.approx(-depth[through] - 0.02, abs=1e-4)
