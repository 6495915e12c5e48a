"""One refusal is none of what only looks like it; switches are drawn often before ways are looked for by sampling."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.lgp import Outcome, SolveOptions, solve

FACES = """
import std.logic
import std.motion
type face < object
module worm(size: length = 25 cm) {
    effector A: gripper cylinder(4 cm, 2 cm) normal (0, 0, -1)
    joint t1: revolute(z) in -170 deg .. 170 deg
    link 6 cm
    joint a: revolute(y) in -120 deg .. 120 deg home 30 deg
    link size: capsule(2 cm)
    joint b: revolute(y) in -150 deg .. 150 deg home -60 deg
    link size: capsule(2 cm)
    joint c: revolute(y) in -120 deg .. 120 deg home 30 deg
    link 6 cm
    joint t2: revolute(z) in -170 deg .. 170 deg
    effector B: gripper cylinder(4 cm, 2 cm)
    fact (linked A B)
}
motion [sticks A: effector, Y: face] borne pad {
    at switch gap(A, Y) = 0
    at switch axis(A, z) + axis(Y, x) = 0
    at switch abs(dot(position(A) - position(Y), axis(Y, y))) <= 8 cm
    at switch abs(dot(position(A) - position(Y), axis(Y, z))) <= 8 cm
}
rule step(A B: gripper, X: object, Y: face) {
    pre   (support A), (linked A B), (free B), (on X A)
    post  not (support A), not (on X A), not [stable X A], not [stand A X], not [sticks A ANY],
          (support B), (on Y B), [stable Y B], [sticks B Y]
}
task up(n: int = 4, above: length = 0 m) {
    base floor: box(1 m, 1 m, 2 cm) at (0, 0, -1 cm)
    object wall: box(4 cm, 1 m, 5 m) at (40 cm, 0, 2.5 m)
    for k in 1 .. n {
        face f[k]: box(4 mm, 24 cm, 24 cm)
            at (37.7 cm, 0, 30 cm * k - 10 cm + (if k = n then above else 0 m)) heading 180 deg
    }
    worm w: A on floor
    goal exists A: gripper { (on f[n] A) }
}
"""

BEAM = """
import std.crawler
import std.logic
import std.motion
type beam < object
type rack < object
predicate (holding A: gripper, X: beam)
motion [end_of A: gripper, X: beam] {
    at switch gap(A, X) = 0
    at switch axis(A, z) + axis(X, z) = 0
    at switch abs(dot(position(A) - position(X), axis(X, x))) >= 30 cm
}
rule take(A B: gripper, X: beam, Y: object) {
    pre   (free A), (free B), A != B, (on Y X), not (linked A B)
    post  (holding A X), (holding B X), not (on Y X), not [stable Y X], [stable A X], [stable B X],
          [end_of A X], [end_of B X]
}
rule put(A B: gripper, X: beam, Y: rack) {
    pre   (holding A X), (holding B X), A != B
    post  not (holding A X), not (holding B X), (on Y X), not [stable A X], not [stable B X],
          not [end_of A X], not [end_of B X], [stable Y X], [rest X Y]
}
task carry() {
    base p1: box(30 cm, 30 cm, 5 cm) at (0, -45 cm, 0)
    base p2: box(30 cm, 30 cm, 5 cm) at (0, 45 cm, 0)
    object low: box(20 cm, 100 cm, 4 cm) at (45 cm, 0, 2 cm)
    rack high: box(20 cm, 100 cm, 4 cm) at (-45 cm, 0, 20 cm)
    beam b: box(90 cm, 6 cm, 6 cm) on low heading 90 deg
    crawler a: A on p1
    crawler c: A on p2
    goal (on high b)
}
"""


def _outcome(folder: Path, text: str, seed: int, parameters: dict[str, str] | None = None) -> Outcome:
    (folder / "own.tamp").write_text(text)
    problem = compile_problem(folder / "own.tamp", None, parameters or {}, seed=seed)[0]
    return solve(problem, SolveOptions(seed=seed, time=30.0))


@pytest.mark.parametrize(("faces", "seed"), [(4, 0), (4, 2), (6, 1)])
def test_faces_that_are_alike_are_not_equally_far(tmp_path: Path, faces: int, seed: int) -> None:
    """The rule has no condition on lengths: that the highest face is too far from the first says nothing of others."""
    outcome = _outcome(tmp_path, FACES, seed, {"n": str(faces)})
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified


def test_a_face_that_none_is_near_to_is_told_after_all_were_asked(tmp_path: Path) -> None:
    outcome = _outcome(tmp_path, FACES, 0, {"above": "1 m"})
    assert outcome.status == "exhausted"
    assert any("f[4]" in d.message and "f[3]" in d.message for d in outcome.explanation)


@pytest.mark.parametrize("seed", [7, 8])
def test_two_arms_carry_a_beam_over_their_heads(tmp_path: Path, seed: int) -> None:
    outcome = _outcome(tmp_path, BEAM, seed)
    assert outcome.status == "solved"
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified
