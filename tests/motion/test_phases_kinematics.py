"""Re-rooted joint trees against plain forward kinematics, Jacobians against differences, distances against coal."""

from __future__ import annotations

import math

import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.compiler.ir import Joint, ModuleType, Shape
from tamplang.compiler.motion.collision import pose_matrix
from tamplang.runtime.geometry.signed_distances import Shapes
from tamplang.runtime.planner.motion.phases.batch_kinematics import BatchKinematics, Points, mounted_poses
from tamplang.runtime.planner.motion.phases.collision_spheres import Ball
from tamplang.runtime.planner.motion.phases.joint_forest import PhaseTree, link_frames, mount_module, node_frames

Pose = tuple[float, float, float, float, float, float, float]


def random_pose(random: np.random.Generator, size: float = 0.3) -> Pose:
    turn = random.normal(size=4)
    x, y, z, a, b, c, d = np.concatenate([random.uniform(-size, size, 3), turn / np.linalg.norm(turn)]).tolist()
    return (x, y, z, a, b, c, d)


def random_module(random: np.random.Generator, count: int) -> ModuleType:
    """A module with a random, possibly branching, joint tree."""
    joints = []
    for i in range(count):
        x, y, z = random.normal(size=3).tolist()
        axis = (x, y, z) if random.random() < 0.5 else ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))[i % 3]
        kind = "revolute" if random.random() < 0.7 else "prismatic"
        norm = math.hypot(*axis)
        unit = (axis[0] / norm, axis[1] / norm, axis[2] / norm)
        joints.append(Joint(f"j{i}", kind, int(random.integers(-1, i)), random_pose(random), unit, -3.0, 3.0, 0.0, 1.0))
    return ModuleType("module", tuple(joints), (), ())


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_a_module_entered_anywhere_moves_like_the_plain_one(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    module = random_module(random, count)
    entry = int(random.integers(-1, count))
    first, last = random.uniform(-2, 2, count), random.uniform(-2, 2, count)
    base = np.array(random_pose(random))
    anchor = link_frames(module, np.concatenate([base, first]))[entry]
    tree = PhaseTree(0)
    mount_module(tree, "m", module, entry, (-1, anchor))
    assert sorted(j for _, j in tree.variables) == list(range(count))
    plain = link_frames(module, np.concatenate([base, last]))
    carried = anchor @ np.linalg.inv(plain[entry])
    values = np.array([last[j] for _, j in tree.variables])
    frames = [*node_frames(tree, values), np.eye(4)]
    for link, (node, local) in tree.links["m"].items():
        assert frames[node] @ local == pytest.approx(carried @ plain[link], abs=1e-9)
        batched = mounted_poses(tree, (node, local), np.array([values, values]))
        assert batched[1] == pytest.approx(carried @ plain[link], abs=1e-9)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_slopes_are_the_jacobian(seed: int) -> None:
    random = np.random.default_rng(seed)
    module = random_module(random, 5)
    trees = []
    for _ in range(2):
        tree = PhaseTree(0)
        mount_module(tree, "m", module, 4, (-1, pose_matrix(random_pose(random))))
        trees.append(tree)
    kinematics = BatchKinematics(trees)
    points = Points([[Ball(4, (0.1, -0.2, 0.3), 0.1, "m", None, False)]] * 2)
    values = random.uniform(-2, 2, (2, 3, 5))
    frames = kinematics.frames(values)
    at = points.placed(frames)[0]
    phase, time = (side.reshape(-1) for side in np.indices((2, 3)))
    normals = random.normal(size=(6, 3))
    slopes = kinematics.slopes(frames, at.reshape(3, -1).T, normals, phase, time)
    moves, node = set(), 4
    while node >= 0:
        moves.add(node)
        node = trees[0].parents[node]
    for joint in range(5):
        step = np.zeros(5)
        step[joint] = 1e-6
        ahead, behind = (points.placed(kinematics.frames(values + s))[0] for s in (step, -step))
        expected = (((ahead - behind) / 2e-6).reshape(3, -1).T * normals).sum(axis=1)
        if joint in moves:
            assert slopes[:, joint] == pytest.approx(expected, abs=1e-6)
        else:
            assert expected == pytest.approx(np.zeros(6), abs=1e-9)


def coal_shape(shape: Shape) -> object:
    kinds = {"box": coal.Box, "sphere": coal.Sphere, "capsule": coal.Capsule, "cylinder": coal.Cylinder}
    return kinds[shape.kind](*shape.size)


@settings(max_examples=80, deadline=None)
@given(st.sampled_from(["box", "sphere", "capsule", "cylinder"]), st.integers(0, 10**6))
def test_distances_agree_with_coal_and_grow_along_the_normals(kind: str, seed: int) -> None:
    random = np.random.default_rng(seed)
    size = tuple(random.uniform(0.05, 0.4, {"box": 3, "sphere": 1}.get(kind, 2)).tolist())
    frame = pose_matrix(random_pose(random))
    shapes = Shapes([[(Shape(kind, size), frame), None]])
    point = random.uniform(-0.6, 0.6, 3)
    here, there = np.arange(2), np.zeros(2, dtype=np.intp)
    distance, offset, excess = (v[..., 0] for v in shapes.distance_at(np.tile(point, (2, 1))[..., None], here, there))
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    ball = 0.01
    expected = coal.distance(
        coal_shape(Shape(kind, size)), coal.Transform3s(frame[:3, :3], frame[:3, 3]),
        coal.Sphere(ball), coal.Transform3s(np.eye(3), point), request, coal.DistanceResult(),
    )
    if distance[0] > ball:
        assert distance[0] - ball == pytest.approx(expected, abs=1e-5)
    else:
        assert (expected < 1e-6) == (distance[0] - ball < 1e-6)
    assert distance[1] > 1e6
    normal = shapes.normals(offset[:1], excess[:1], here[:1], there[:1])[0]
    ahead = shapes.distance_at((point + 1e-6 * normal)[None, :, None], here[:1], there[:1])[0][0, 0]
    assert (ahead - distance[0]) / 1e-6 == pytest.approx(1.0, abs=1e-3)
