"""Arms whose parts are convex bodies: measured as they are, with no spheres in their place, for what cylinders cost."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from tamplang.compiler.ir import Problem, Shape, ShapeKind
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.geometry.exact_distances import Forms, Posed, distances
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.planner.motion.phases.exact_check import _boxes_apart

SIDES = 24


def _arm(folder: Path, geometry: str) -> Problem:
    """An arm of six links of 24 cm: of cylinders, or of prisms of 24 sides."""
    ring = [(0.06 * math.cos(a), 0.06 * math.sin(a)) for a in np.linspace(0.0, 2.0 * math.pi, SIDES, endpoint=False)]
    rows = [f"v {x:.6f} {y:.6f} {z}" for z in (-0.12, 0.12) for x, y in ring]
    rows.append("f " + " ".join(str(SIDES - i) for i in range(SIDES)))
    rows.append("f " + " ".join(str(SIDES + 1 + i) for i in range(SIDES)))
    rows += [
        f"f {i + 1} {(i + 1) % SIDES + 1} {SIDES + (i + 1) % SIDES + 1} {SIDES + i + 1}" for i in range(SIDES)
    ]
    (folder / "prism.obj").write_text("\n".join(rows) + "\n")
    links = ['<link name="l0"/>']
    for k in range(1, 7):
        up = 0.05 if k == 1 else 0.32
        links.append(f'<link name="l{k}"><collision><origin xyz="0 0 0.17"/><geometry>{geometry}</geometry></collision>'
                     f'</link><joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
                     f'<origin xyz="0 0 {up}"/><axis xyz="{"0 1 0" if k % 2 else "1 0 0"}"/>'
                     '<limit lower="-2" upper="2" effort="1" velocity="2"/></joint>')  # fmt: skip
    (folder / "arm.urdf").write_text(f'<robot name="arm">{"".join(links)}</robot>')
    (folder / "arm.tamp").write_text("""
import std.rules
module arm from urdf "arm.urdf" {
    effector foot: gripper "l0" box(16 cm, 16 cm, 2 cm) at (0, 0, -1 cm) normal (0, 0, -1)
    effector tool: gripper "l6" sphere(3 cm) at (0, 0, 36 cm)
    fact (linked foot tool)
}
task t() {
    base table: box(40 cm, 40 cm, 40 cm) at (0, 0, 0)
    object post: box(8 cm, 8 cm, 80 cm) at (60 cm, 20 cm, 40 cm)
    object ball: sphere(4 cm) at (1 m, 40 cm, 1 m)
    fact (grippable ball)
    arm a: foot on table
    goal (held ball)
}
""")
    return compile_problem(folder / "arm.tamp", "t")[0]


def test_an_arm_of_meshes_reaches_past_a_post(tmp_path: Path) -> None:
    outcome = solve(_arm(tmp_path, '<mesh filename="prism.obj"/>'), SolveOptions(seed=2, time=60.0))
    assert outcome.status == "solved" and outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified


def test_the_boxes_around_bodies_are_no_farther_apart_than_these() -> None:
    random = np.random.default_rng(7)
    corners = random.normal(0.0, 0.1, (12, 3))
    corners -= 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    body = Shape(ShapeKind.CONVEX, tuple(corners.ravel().tolist()))
    shapes = [body, Shape(ShapeKind.BOX, (0.2, 0.1, 0.05)), Shape(ShapeKind.CYLINDER, (0.05, 0.2))]
    half = np.array([np.ptp(corners, axis=0) / 2, [0.1, 0.05, 0.025], [0.05, 0.05, 0.1]])
    forms, count = Forms(shapes), 300
    turns = [np.linalg.qr(random.normal(size=(3, 3)))[0] for _ in range(2 * count)]
    turns = [q * np.sign(np.linalg.det(q)) for q in turns]
    one, other = (
        Posed(forms, random.integers(0, 3, count), random.uniform(-0.4, 0.4, (count, 3)), np.array(turns[k::2]))
        for k in range(2)
    )
    bound = _boxes_apart(one, other, half)
    exact = distances(one, other, np.full(count, 10.0)).value
    assert (bound <= np.maximum(exact, 0.0) + 1e-5).all() and (bound > 0.5 * exact)[exact > 0.2].mean() > 0.5
