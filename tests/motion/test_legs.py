"""Legs from a URDF: four of three joints each, whose feet are balls given as meshes and again as effectors."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import SolveOptions, solve

RADIUS, THIGH, HIP = 0.02, 0.16, 0.8
FEET = list(itertools.product((1, -1), (1, -1)))

TASK = """
import std.motion

type foot < effector
type tile < object
predicate (stands A: foot, X: tile)  functional in A
derived (lifted A: foot) = not exists X: tile { (stands A X) }

module dog from urdf "dog.urdf" {
ENDS
}
placement (A: foot) on (X: tile) { (stands A X), [stable X A] }
motion [set A: effector, X: object] {
    at switch bottom(A) = top(X)
    at switch inside(A, X) >= 0
}
rule lift(A: foot, X: tile) {
    pre   (stands A X), not exists B: foot { (lifted B) }
    post  not (stands A X), not [stable X A], not [set A X]
}
rule put(A: foot, X: tile) {
    pre   (lifted A), not exists B: foot { (stands B X) }
    where distance(A, X) <= 15 cm
    post  (stands A X), [stable X A], [set A X]
}
task steps {
TILES
    dog d: f0 on now[0]
FACTS
    goal  (stands d.f0 next[0]), (stands d.f3 next[3])
}
"""


def _ball(points: int = 300) -> str:
    """An OBJ of a ball: too many corners to be kept as they are."""
    turn = np.arange(points) * math.pi * (3 - math.sqrt(5))
    height = 1 - 2 * (np.arange(points) + 0.5) / points
    across = np.sqrt(1 - height**2)
    corners = RADIUS * np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
    made = ConvexHull(corners)
    lines = [f"v {x:.8f} {y:.8f} {z:.8f}" for x, y, z in corners]
    for (a, b, c), plane in zip(made.simplices, made.equations, strict=True):
        outward = np.cross(corners[b] - corners[a], corners[c] - corners[a]) @ plane[:3] > 0
        lines.append("f {} {} {}".format(*(k + 1 for k in ((a, b, c) if outward else (a, c, b)))))
    return "\n".join(lines)


def _revolute(name: str, parent: str, child: str, at: tuple[float, float, float], axis: str) -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at[0]} {at[1]} {at[2]}"/><axis xyz="{axis}"/>'
        '<limit lower="-2.5" upper="2.5" effort="9" velocity="5"/></joint>'
    )


def _dog(folder: Path) -> Problem:
    """A body of 40 cm, with feet below its hips at a height of 2 THIGH cos HIP, on four tiles; two lie further on."""
    (folder / "ball.obj").write_text(_ball())
    box = f'<geometry><box size="0.02 0.02 {THIGH - 0.05}"/></geometry>'
    bar = f'<collision><origin xyz="0 0 {-THIGH / 2}"/>{box}</collision>'
    ball = '<collision><geometry><mesh filename="ball.obj"/></geometry></collision>'
    parts = ['<link name="body"><collision><geometry><box size="0.3 0.12 0.06"/></geometry></collision></link>']
    ends, tiles, facts = [], [], []
    for k, (x, y) in enumerate(FEET):
        parts += [f'<link name="hip{k}"/><link name="thigh{k}">{bar}</link><link name="shank{k}">{bar}</link>',
                  f'<link name="foot{k}">{ball}</link>',
                  _revolute(f"haa{k}", "body", f"hip{k}", (0.2 * x, 0.08 * y, 0.0), "1 0 0"),
                  _revolute(f"hfe{k}", f"hip{k}", f"thigh{k}", (0.0, 0.04 * y, 0.0), "0 1 0"),
                  _revolute(f"kfe{k}", f"thigh{k}", f"shank{k}", (0.0, 0.0, -THIGH), "0 1 0"),
                  f'<joint name="ankle{k}" type="fixed"><parent link="shank{k}"/><child link="foot{k}"/>'
                  f'<origin xyz="0 0 {-THIGH}"/></joint>']  # fmt: skip
        ends += [f'effector f{k}: foot "foot{k}" sphere({RADIUS} m) normal ({-math.sin(HIP)}, 0, {-math.cos(HIP)})',
                 f"joint hfe{k} home {HIP} rad", f"joint kfe{k} home {-2 * HIP} rad"]  # fmt: skip
        tiles += [f"tile {n}[{k}]: box(7 cm, 8 cm, 2 cm) at ({0.2 * x + ahead} m, {0.12 * y} m, 0)"
                  for n, ahead in (("now", 0.0), ("next", 0.08))[: 1 + (k in (0, 3))]]  # fmt: skip
        facts += [f"fact (stands d.f{k} now[{k}])\n    fact [stable now[{k}] d.f{k}]"] if k else []
    (folder / "dog.urdf").write_text(f'<robot name="dog">{"".join(parts)}</robot>')
    text = TASK.replace("ENDS", "\n".join(ends)).replace("TILES", "\n".join(tiles)).replace("FACTS", "\n".join(facts))
    (folder / "dog.tamp").write_text(text)
    return compile_problem(folder / "dog.tamp", "steps")[0]


def test_legs_step_while_three_feet_stand(tmp_path: Path) -> None:
    """The body around the mesh of a foot is larger than the ball that the program states: the ball counts alone. Three
    feet that stand leave the body no room: only the fourth leg moves."""
    problem = _dog(tmp_path)
    assert len(problem.world.modules["d"].type.links) == 9
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "solved" and len(outcome.plans[0].phases) == 4
    assert outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
