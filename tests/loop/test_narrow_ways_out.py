"""Things that come out of narrow places straight: trees of samples seldom find such ways."""

from __future__ import annotations

from pathlib import Path

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import SolveOptions, solve

RING = """
import std.rules
module hoist {
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    link (0, 0, 1 m)
    joint dx: prismatic(x) in 0 m .. 1.6 m
    joint dy: prismatic(y) in -80 cm .. 80 cm
    joint dz: prismatic(z) in -95 cm .. 0 cm
    joint yaw: revolute(z) in -180 deg .. 180 deg
    link (0, 0, -6 cm): capsule(1 cm)
    effector B: gripper sphere(8 mm) at (0, 0, -1 cm) normal (0, 0, -1)
    fact (linked A B)
}
task t {
    base foot: box(20 cm, 20 cm, 5 cm) at (0, 0, -2.5 cm)
    for i in 0 .. 1 {
        object plate[i]: box(14 cm, 14 cm, 2 cm) at (60 cm + 50 cm * i, 10 cm * i, 1 cm)
        object post[i]: cylinder(1.5 cm, 12 cm) on plate[i]
    }
    fact (tray plate[1])
    object ring: union(box(12 cm, 3 cm, 2 cm) at (0, 4.5 cm, 0), box(12 cm, 3 cm, 2 cm) at (0, -4.5 cm, 0),
        box(3 cm, 6 cm, 2 cm) at (4.5 cm, 0, 0), box(3 cm, 6 cm, 2 cm) at (-4.5 cm, 0, 0)) on plate[0]
    fact (grippable ring)
    hoist h: A on foot
    goal (on plate[1] ring)
}
"""


def test_a_ring_is_lifted_off_a_post_and_put_over_another(tmp_path: Path) -> None:
    """The parts of a ring that moves, small as they are, are seen, and edges of trees do not pass through posts."""
    (tmp_path / "ring.tamp").write_text(RING)
    outcome = solve(compile_problem(tmp_path / "ring.tamp", "t", seed=1)[0], SolveOptions(seed=1, time=120.0))
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
