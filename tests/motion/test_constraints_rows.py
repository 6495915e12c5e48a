"""Distances against coal, Jacobians against differences, residuals against hand values."""

from __future__ import annotations

import casadi as ca
import coal
import numpy as np
import pytest

from tamplang.compiler.ir import Letter, Number, Row
from tamplang.compiler.motion.constraints import (
    BodyKind,
    EffectorKind,
    Kind,
    RestKind,
    arguments,
    parameter_sizes,
    slot_sizes,
    stage,
    units,
)
from tamplang.compiler.motion.distances import SIZES, DistanceShape, bottom, gap, inside, top
from tamplang.compiler.motion.kinematics import pose_frame

from .fixtures import CRAWLER, MOTIONS, X, Y, call, motion, switch

SHAPES = {
    "sphere": ((0.3,), lambda s: coal.Sphere(*s)),
    "box": ((0.4, 0.6, 0.2), lambda s: coal.Box(*s)),
    "capsule": ((0.1, 0.5), lambda s: coal.Capsule(*s)),
    "cylinder": ((0.2, 0.5), lambda s: coal.Cylinder(*s)),
}


def random_pose(random: np.random.Generator, spread: float = 0.8) -> np.ndarray:
    turn = random.normal(size=4)
    return np.concatenate([random.uniform(-spread, spread, 3), turn / np.linalg.norm(turn)])


def coal_pose(pose: np.ndarray) -> coal.Transform3s:
    x, y, z, w = pose[3:]
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    return coal.Transform3s(rotation, pose[:3])


def coal_gap(a: str, pose_a: np.ndarray, b: str, pose_b: np.ndarray) -> float:
    first, second = SHAPES[a][1](SHAPES[a][0]), SHAPES[b][1](SHAPES[b][0])
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return float(coal.distance(first, coal_pose(pose_a), second, coal_pose(pose_b), request, result))


def gap_function(a: str, b: str) -> ca.Function:
    p, q = ca.SX.sym("p", 7), ca.SX.sym("q", 7)
    value = gap(DistanceShape(pose_frame(p), a, SHAPES[a][0]), DistanceShape(pose_frame(q), b, SHAPES[b][0]))
    return ca.Function("gap", [p, q], [value])


@pytest.mark.parametrize("other", list(SHAPES))
def test_sphere_gaps_are_exact(other: str) -> None:
    random = np.random.default_rng(0)
    for a, b in (("sphere", other), (other, "sphere")):
        function = gap_function(a, b)
        for _ in range(40):
            p, q = random_pose(random), random_pose(random)
            assert float(function(p, q)) == pytest.approx(coal_gap(a, p, b, q), abs=2e-4)


def test_box_gap_is_zero_exactly_at_contact() -> None:
    random = np.random.default_rng(1)
    function = gap_function("box", "box")
    for _ in range(60):
        p, q = random_pose(random, 0.5), random_pose(random, 0.5)
        mine, exact = float(function(p, q)), coal_gap("box", p, "box", q)
        assert mine <= exact + 1e-5
        assert (mine > 1e-4) == (exact > 1e-4)


@pytest.mark.parametrize("kinds", [("capsule", "box"), ("cylinder", "capsule"), ("cylinder", "box")])
def test_other_gaps_never_exceed_the_distance(kinds: tuple[str, str]) -> None:
    random = np.random.default_rng(2)
    function = gap_function(*kinds)
    for _ in range(40):
        p, q = random_pose(random), random_pose(random)
        assert float(function(p, q)) <= coal_gap(kinds[0], p, kinds[1], q) + 1e-4


@pytest.mark.parametrize("kind", list(SHAPES))
def test_top_and_bottom_bound_the_shape(kind: str) -> None:
    random = np.random.default_rng(3)
    p = ca.SX.sym("p", 7)
    solid = DistanceShape(pose_frame(p), kind, SHAPES[kind][0])
    function = ca.Function("ends", [p], [ca.vertcat(top(solid), bottom(solid))])
    plate = coal.Box(10.0, 10.0, 2.0)
    shape = SHAPES[kind][1](SHAPES[kind][0])
    level = np.array([0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0])
    for _ in range(10):
        pose = random_pose(random)
        high, low = np.array(function(pose)).ravel()
        above = coal.distance(
            shape, coal_pose(pose), plate, coal_pose(level), coal.DistanceRequest(), coal.DistanceResult()
        )
        assert 2.0 - high == pytest.approx(above, abs=1e-3)
        assert high + low == pytest.approx(2 * pose[2], abs=1e-9)


def test_inside_measures_to_the_four_sides() -> None:
    p = ca.SX.sym("p", 7)
    turned = np.array([1.0, 2.0, 0.0, 0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4)])
    table = DistanceShape(pose_frame(ca.DM(turned)), "box", (0.4, 1.0, 0.1))
    function = ca.Function("inside", [p], [inside(DistanceShape(pose_frame(p), "sphere", (0.05,)), table)])
    rows = np.array(function(np.array([1.3, 2.1, 0.5, 0, 0, 0, 1]))).ravel()
    assert rows == pytest.approx([0.2 - 0.1, 0.2 + 0.1, 0.5 + 0.3, 0.5 - 0.3])


KINDS: list[tuple[str, tuple[Kind, ...]]] = [
    ("touch", (EffectorKind(CRAWLER, "B", 0), BodyKind("sphere", 1))),
    ("touch", (EffectorKind(CRAWLER, "B", 0), BodyKind("box", 1))),
    ("touch", (EffectorKind(CRAWLER, "A", 0), EffectorKind(CRAWLER, "B", 0))),
    ("stable", (RestKind("box"), EffectorKind(CRAWLER, "B", 0))),
    ("stable", (EffectorKind(CRAWLER, "A", 0), EffectorKind(CRAWLER, "B", 1))),
    ("stable", (EffectorKind(CRAWLER, "B", 0), BodyKind("box", 1))),
    ("stand", (EffectorKind(CRAWLER, "A", 0), RestKind("box"))),
    ("rest", (BodyKind("cylinder", 0), RestKind("cylinder"))),
    ("connectCrawlers", (EffectorKind(CRAWLER, "A", 0), EffectorKind(CRAWLER, "B", 1))),
]


def sample(row: Row, kinds: tuple[Kind, ...], random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    slots = []
    for _ in range(2 if row.when == "keep" else 1):
        slots += [np.concatenate([random_pose(random), random.uniform(-1, 1, n - 7)]) for n in slot_sizes(kinds)]
    constants = []
    for kind, count in zip(kinds, parameter_sizes(kinds), strict=True):
        if count > 7:
            constants.append(random_pose(random))
        if not isinstance(kind, EffectorKind):
            constants.append(random.uniform(0.2, 0.6, SIZES[kind.shape]))
    return np.concatenate(slots), np.concatenate([*constants, np.zeros(0)])


@pytest.mark.parametrize(("name", "kinds"), KINDS)
def test_jacobians_agree_with_differences(name: str, kinds: tuple[Kind, ...]) -> None:
    random = np.random.default_rng(4)
    predicate = MOTIONS[name]
    for row in predicate.rows:
        names = arguments(row, predicate.variables)
        used = tuple(k for v, k in zip(predicate.variables, kinds, strict=True) if v.name in names)
        made = stage(row, names, used)
        assert made.rows == row.rows == len(units(row))
        x, p = sample(row, used, random)
        jacobian = made.jacobians(x[None], p[None])[0]
        for _ in range(3):
            d = random.normal(size=len(x))
            ends = made.values(np.array([x + 1e-6 * d, x - 1e-6 * d]), np.array([p, p]))
            assert jacobian @ d == pytest.approx((ends[0] - ends[1]) / 2e-6, abs=1e-6)


def test_batches_equal_single_calls() -> None:
    row = MOTIONS["touch"].rows[0]
    made = stage(row, ("X", "Y"), (EffectorKind(CRAWLER, "B", 0), RestKind("box")))
    random = np.random.default_rng(5)
    x = random.normal(size=(11, made.inputs))
    p = random.uniform(0.3, 1.0, (11, made.parameters))
    single = np.array([made.values(x[i : i + 1], p[i : i + 1])[0] for i in range(11)])
    assert np.array_equal(made.values(x, p), single)


def test_stages_are_shared() -> None:
    row = MOTIONS["touch"].rows[0]
    kinds = (EffectorKind(CRAWLER, "B", 0), RestKind("box"))
    assert stage(row, ("X", "Y"), kinds) is stage(row, ("X", "Y"), kinds)


def test_inequality_signs_and_units() -> None:
    at_least = motion("high", switch(call("bottom", X), ">=", Number(0.5), 1)).rows[0]
    made = stage(at_least, ("X",), (BodyKind("sphere", 0),))
    residual = made.values(np.array([[0, 0, 0.4, 0, 0, 0, 1.0]]), np.array([[0.1]]))
    assert residual == pytest.approx(np.array([[0.2]]))
    assert units(at_least) == ("m",)
    assert units(switch(call("axis", X, Letter("z")), "=", Number(0), 3)) == ("1", "1", "1")
    assert units(MOTIONS["stable"].rows[0]) == ("m", "m", "m", "rad", "rad", "rad")


def test_unknown_function_is_refused() -> None:
    row = switch(call("reach", X, Y), "=", Number(0), 1)
    with pytest.raises(ValueError, match="reach"):
        stage(row, ("X", "Y"), (BodyKind("sphere", 0), BodyKind("sphere", 1)))
