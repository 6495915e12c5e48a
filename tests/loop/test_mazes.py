"""Narrow ways, which samples find where nothing else does."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import SolveOptions, solve

SERPENT = """
import std.motion
type hand < effector
predicate (holds H: hand, X: object) functional in H
predicate (lies X Y: object) functional in X
predicate (loose X: object) static
placement (X: object) on (Y: object) { (lies X Y), [stable Y X] }
motion [pick H: hand, X: object] {
    at switch gap(H, X) = 0
    keep pose(X, H)
}
rule take(H: hand, X Y: object) {
    pre  not (holds H ANY), (lies X Y), (loose X)
    post (holds H X), not (lies X Y), not [stable Y X], [pick H X]
}
module rover {
    joint drive: planar(x, y) in (-4 m, -4 m) .. (4 m, 4 m) speed 0.5 m/s
    link 10 cm: cylinder(12 cm)
    joint lift: prismatic(z) in 0 m .. 30 cm
    link 8 cm: capsule(2 cm)
    effector tip: hand sphere(2 cm) at (20 cm, 0, 0) normal (1, 0, 0)
}
task serpent(gap: length = 50 cm) {
    object floor: box(4 m, 4 m, 4 cm) at (0, 0, -2.1 cm)
    object n: box(4 m, 4 cm, 40 cm) at (0, 2 m, 20 cm)
    object s: box(4 m, 4 cm, 40 cm) at (0, -2 m, 20 cm)
    object e: box(4 cm, 4 m, 40 cm) at (2 m, 0, 20 cm)
    object w: box(4 cm, 4 m, 40 cm) at (-2 m, 0, 20 cm)
    object w1: box(4 cm, 4 m - gap, 40 cm) at (-1 m, -gap / 2, 20 cm)
    object w2: box(4 cm, 4 m - gap, 40 cm) at (0, gap / 2, 20 cm)
    object w3: box(4 cm, 4 m - gap, 40 cm) at (1 m, -gap / 2, 20 cm)
    object t: box(20 cm, 20 cm, 12 cm) at (1.5 m, -1.5 m, 6 cm)
    object cup: cylinder(3 cm, 10 cm) on t
    fact (loose cup)
    rover a: at (-1.5 m, -1.5 m, 0)
    goal (holds a.tip cup)
}
"""
MAZES = Path(__file__).parents[1] / "programs" / "good" / "mazes.tamp"


@pytest.mark.parametrize(("task", "seed"), [("gate", 3), ("pipe", 4), ("window", 0)])
def test_a_way_through_is_found(task: str, seed: int) -> None:
    outcome = solve(compile_problem(MAZES, task, seed=seed)[0], SolveOptions(seed=seed, time=120.0))
    assert outcome.status == "solved" and outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified


def test_a_long_way_is_looked_for_in_more_slices_unasked(tmp_path: Path) -> None:
    """13 m around six corners, which 20 slices cannot follow."""
    (tmp_path / "serpent.tamp").write_text(SERPENT)
    outcome = solve(compile_problem(tmp_path / "serpent.tamp", "serpent")[0], SolveOptions(time=120.0))
    assert outcome.status == "solved" and outcome.plans[0].verdict is not None and outcome.plans[0].verdict.verified
