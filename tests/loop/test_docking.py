"""Modules of few joints that dock: their ends meet in few postures only."""

from __future__ import annotations

import msgspec
import pytest

from benchmarks.trust.checker import judge, read
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve

CUBES = """
import std.rules
## Two half cylinders on parallel hinges.
module halves {
    effector A: gripper sphere(2 cm) normal (0, 0, -1)
    link 3 cm
    link 5 cm: capsule(4.5 cm)
    joint j1: revolute(y) in -90 deg .. 90 deg
    link 10 cm
    joint j2: revolute(y) in -90 deg .. 90 deg
    link 5 cm: capsule(4.5 cm)
    link 3 cm
    effector B: gripper sphere(2 cm)
    fact (linked A B)
}
task docked() {
    base floor: box(1 m, 1 m, 2 cm) at (0, 0, 0)
    for k in 1 .. 2 { halves m[k]: A on floor at (24 cm * k, 0) }
    goal (connected m[1].B m[2].B)
}
"""


@pytest.mark.parametrize("seed", [0, 3, 6, 7])
def test_ends_of_modules_with_two_hinges_meet_with_every_seed(seed: int) -> None:
    problem, _ = compile_text(CUBES, seed=seed)
    outcome = solve(problem, SolveOptions(seed=seed, time=60.0, bound="seq"))
    assert outcome.status == "solved" and outcome.misses == []


ROW = """
import std.logic
import std.motion
## Two parallel hinges, square faces at both ends.
module cube {
    effector A: gripper box(6 cm, 6 cm, 4 mm) at (0, 0, 2 mm) normal (0, 0, -1)
    link 4 mm
    link 4 cm: box(6 cm, 6 cm)
    joint j1: revolute(y) in -90 deg .. 90 deg
    link 7 cm: capsule(2 cm)
    joint j2: revolute(y) in -90 deg .. 90 deg
    link 1 cm
    link 3 cm: box(6 cm, 6 cm)
    effector B: gripper box(6 cm, 6 cm, 4 mm) at (0, 0, 2 mm)
    fact (linked A B)
}
motion [mated X Y: effector] symmetric {
    at switch gap(X, Y) = 0
    at switch axis(X, z) + axis(Y, z) = 0
    at switch dot(position(Y) - position(X), axis(X, x)) = 0
    at switch dot(position(Y) - position(X), axis(X, y)) = 0
}
rule mate(X Y: gripper) {
    pre  (free X), (free Y)
    where X != Y
    post (connected X Y), [mated X Y], [stable Y X]
}
rule leave(A B: gripper, X: base) {
    pre  (support A), (linked A B), (on X A), exists C: gripper { (connected B C) }
    post not (support A), not (on X A), not [stable X A], not [stand A X]
}
task row() {
    base floor: box(2 m, 2 m, 2 cm) at (0, 0, -1 cm)
    cube m[1]: A on floor at (0, 0)
    cube m[2]: A on floor at (20 cm, 0)
    cube m[3]: A on floor at (36 cm, 0)
    goal (connected m[1].B m[2].B), (connected m[2].A m[3].B)
}
"""


def test_what_has_let_go_of_everything_stays_and_docks_on() -> None:
    """Rules may have a robot leave all it stands on: its first module stays, its joints move the others."""
    problem, _ = compile_text(ROW, seed=0)
    outcome = solve(problem, SolveOptions(time=60.0))
    assert outcome.status == "solved"
    plan = outcome.plans[0]
    assert plan.verdict is not None and plan.verdict.verified
    assert sum(phase.action.startswith("leave") for phase in plan.phases) == 2
    assert judge(read(msgspec.json.encode(plan).decode())) == []
