"""Convex bodies from points and meshes: their geometry, what planner and verifier make of it, and whole plans."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import tamplang
from tamplang.compiler.extents import box_sides
from tamplang.compiler.hulls import MOST_CORNERS, convex_geometry, convex_shape, hull, slices
from tamplang.compiler.ir import Shape
from tamplang.compiler.motion.collision import cover
from tamplang.compiler.motion.distances import DistanceShape, bottom, gap, inside, mass, top
from tamplang.compiler.motion.kinematics import pose_frame
from tamplang.compiler.pipeline import check_sources, compile_problem, compile_sources
from tamplang.langs.source import Source
from tamplang.runtime.verify import inertia, shapes
from tamplang.runtime.verify.geometry import rotation_matrices

PROGRAMS = Path(__file__).parents[1] / "programs"
LEVEL = np.array([0.0, 0, 0, 0, 0, 0, 1])
TABLE = convex_shape([(0, 0, 0), (5, 0, 0), (5, 5, 0), (0, 5, 0), (1, 1, 2), (4, 1, 2), (4, 3, 2), (1, 3, 2)])[0]


@st.composite
def bodies(draw: st.DrawFn) -> Shape:
    """The hulls of some random points."""
    random = np.random.default_rng(draw(st.integers(0, 10**6)))
    stretch = random.uniform(0.05, 0.3, 3)
    return convex_shape(random.uniform(-1, 1, (draw(st.integers(4, 30)), 3)) * stretch)[0]


def on_surface(shape: Shape, count: int) -> np.ndarray:
    """Random points (count, 3) of the surface."""
    random, body = np.random.default_rng(0), hull(shape)
    triangles = body.corners[body.triangles[random.integers(len(body.triangles), size=count)]]
    return np.einsum("ij,ijk->ik", random.dirichlet([0.4] * 3, count), triangles)


@settings(max_examples=8, deadline=None)
@given(bodies(), st.sampled_from([0.02, 0.01]))
def test_spheres_cover_a_body_from_within_and_slices_from_without(shape: Shape, margin: float) -> None:
    spheres = cover(shape, margin)
    centres, radii = np.array([c for c, _ in spheres]), np.array([r for _, r in spheres])
    assert (hull(shape).distance(centres) + radii).max() <= 2e-6
    points = on_surface(shape, 300)
    assert (np.linalg.norm(points[:, None] - centres, axis=2) - radii).min(axis=1).max() <= margin + 1e-9
    boxes = np.array(slices(shape))
    beyond = (np.abs(points[:, None] - boxes[:, 0]) - boxes[:, 1]).max(axis=2)
    assert beyond.min(axis=1).max() <= 1e-6


@settings(max_examples=6, deadline=None)
@given(bodies(), st.integers(0, 10**6))
def test_planner_and_verifier_measure_the_same(shape: Shape, seed: int) -> None:
    random = np.random.default_rng(seed)
    pose = np.concatenate([random.uniform(-1, 1, 3), random.normal(size=4)])
    pose[3:] /= np.linalg.norm(pose[3:])
    solid = DistanceShape(pose_frame(ca.DM(pose)), "convex", shape.size)
    turn = rotation_matrices(pose[None, 3:])
    for measure, up, sign in ((top, True, 1), (bottom, False, -1)):
        expected = pose[2] + sign * shapes.heights("convex", shape.size, turn, up)[0]
        assert float(ca.evalf(ca.SX(measure(solid)))) == pytest.approx(expected, abs=1e-9)
    assert float(ca.evalf(mass(solid))) == pytest.approx(inertia.mass_of(shape))
    for _ in range(6):
        point = random.uniform(-1.2, 1.2, 3)
        ball = DistanceShape(pose_frame(ca.DM([*point, 0, 0, 0, 1])), "sphere", (0.03,))
        exact = distance(shape, pose, coal.Sphere(0.03), point)
        mine = float(ca.evalf(gap(solid, ball)))
        assert mine == pytest.approx(exact, abs=1e-4)


def distance(shape: Shape, pose: np.ndarray, other: object, at: np.ndarray) -> float:
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    place = coal.Transform3s(rotation_matrices(pose[None, 3:])[0], pose[:3])
    there = coal.Transform3s(np.eye(3), at)
    return float(coal.distance(convex_geometry(shape), place, other, there, request, coal.DistanceResult()))


@pytest.mark.parametrize("other", [Shape("box", (0.4, 0.2, 0.3)), TABLE])
def test_gaps_between_flat_bodies_do_not_exceed_the_distance(other: Shape) -> None:
    random = np.random.default_rng(4)
    solid = DistanceShape(pose_frame(ca.DM(LEVEL)), "convex", TABLE.size)
    geometry = convex_geometry(other) if other.kind == "convex" else coal.Box(*other.size)
    for _ in range(6):
        at = random.uniform(-4, 4, 3)
        mine = float(ca.evalf(gap(solid, DistanceShape(pose_frame(ca.DM([*at, 0, 0, 0, 1])), other.kind, other.size))))
        assert mine <= distance(TABLE, LEVEL, geometry, at) + 1e-4


def test_inside_is_measured_to_the_edges_of_the_flat_top() -> None:
    surface = DistanceShape(pose_frame(ca.DM(LEVEL)), "convex", TABLE.size)
    for x, y in ((0.0, -0.5), (1.2, 0.0), (-2.0, 0.3), (0.0, 2.0)):
        foot = DistanceShape(pose_frame(ca.DM([x, y, 1.5, 0, 0, 0, 1])), "sphere", (0.05,))
        rows = np.array(ca.evalf(inside(foot, surface))).ravel()
        expected = min(1.5 - abs(x), 1.0 - abs(y + 0.5))
        assert rows.min() == pytest.approx(expected) and len(rows) == 4
        assert shapes.inside_top(TABLE.size, np.array([[x, y]]))[0] == pytest.approx(expected)
    spike = convex_shape([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])[0]
    assert shapes.inside_top(spike.size, np.zeros((1, 2)))[0] == -1.0


def test_a_body_of_many_corners_is_replaced_by_one_around_it() -> None:
    points = np.random.default_rng(0).normal(size=(400, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    shape, middle, simpler = convex_shape(points)
    assert simpler and len(shape.size) <= 3 * MOST_CORNERS
    assert hull(shape).distance(points - middle).max() <= 1e-6
    assert max(box_sides(shape)) < 2.05


def test_a_plan_with_meshes_stands_alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(PROGRAMS)
    problem, _ = compile_problem("good/meshes.tamp")
    monkeypatch.chdir(tmp_path)
    again, _ = compile_sources(problem.sources, files=problem.files)
    assert again.world == problem.world
    assert box_sides(problem.world.bodies["wedge"].shape) == pytest.approx((0.5, 0.4, 0.2))
    assert problem.world.bodies["stone"].pose[2] == pytest.approx(0.126 + 0.1 + 0.05)


def test_a_robot_climbs_a_mesh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(PROGRAMS)
    result = tamplang.load("good/meshes.tamp", seed=2).solve(time=60.0)
    assert result.plan is not None and any("wedge" in action for action in result.plan.actions)
    result.plan.save(tmp_path / "plan.json")
    monkeypatch.chdir(tmp_path)
    assert tamplang.read_plan("plan.json").verify().verified


def test_no_open_mesh_is_asked_for_its_hull(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(PROGRAMS / "bad")
    name = "parts/open_corner.stl"
    text = f"""object a: hull("{name}") at (0, 0, 0) object b: mesh("{name}") at (9 m, 0, 0)"""
    found = check_sources([Source("t.tamp", f"predicate (lit)\ntask t {{ {text} goal (lit) }}")])
    assert "E0518" in [d.code for d in found]


def test_a_convex_stone_is_put_on_a_convex_table_past_a_convex_wall() -> None:
    result = tamplang.load(PROGRAMS / "good" / "convex_bodies.tamp").solve(time=60.0)
    assert result.plan is not None and result.plan.verify().verified
    assert [action.partition("(")[0] for action in result.plan.actions][-2:] == ["grasp", "place"]
