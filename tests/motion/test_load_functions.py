"""`load`, `torque` and `wrench` in rules and rows: planner and verifier agree on them, and plans keep them."""

from pathlib import Path

import pytest

from tamplang.compiler.ir import Chain
from tamplang.compiler.physics.scene_loads import SceneLoads
from tamplang.compiler.pipeline import check, compile_text
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.verify.check import check as judge
from tamplang.runtime.verify.guards import Guards

TEXT = """import std.logic
import std.motion

predicate (reached B: gripper, X: object)
predicate (back B: gripper)
rule reachOut(B: gripper, X: object) {
    pre   (free B), not (reached B X)
    where GUARD
    post  (reached B X), [near B X]
}
rule pullBack(B: gripper, X: object) {
    pre   (reached B X), not (back B)
    post  (back B), [aside B]
}
motion [near X: effector, Y: object] borne nothing {
    at switch bottom(X) >= top(Y)
    at switch norm(position(X) - position(Y)) <= 0.9 m
    ROWS
}
motion [aside X: effector] { at switch dot(position(X), (0, 1, 0)) >= 0.3 }
module arm {
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 2 kg holds pad(force 3 kN, moment 300 N m)
        holds dock(force 200 N, moment 20 N m)
    joint j1: revolute(z) in -3 rad .. 3 rad torque 50 N m mass 1 kg
    joint j2: revolute(y) in -2 rad .. 2 rad home 0.3 rad torque 50 N m mass 1 kg
    link 0.4 m: capsule(0.04 m) mass 1 kg
    joint j3: revolute(y) in -2.6 rad .. 2.6 rad home 0.6 rad torque 50 N m mass 1 kg
    link 0.4 m: capsule(0.04 m) mass 1 kg
    joint j4: prismatic(z) in 0 m .. 0.1 m torque 50 N mass 500 g
    link 0.1 m: capsule(0.03 m) mass 200 g
    effector B: gripper sphere(0.05 m) mass 300 g holds dock(force 300 N, moment 30 N m)
    fact (linked A B)
}
task t {
    base ground: box(4 m, 4 m, 5 cm) at (0, 0, 0)
    object item: box(10 cm, 10 cm, 10 cm) on ground at (0.8 m, 0)
    arm a: A on ground at (0, 0)
    arm b: A on ground at (0, 1.5 m)
    goal (back a.B), (reached a.B item)
    options { physics = statics, time = 40 s, slices = 10 }
}
""".replace("torque 50 N mass", "force 50 N mass")


def text(rows: str = "during load(X) <= 0.4", guard: str = "load(B) <= 1") -> str:
    return TEXT.replace("ROWS", rows).replace("GUARD", guard)


def test_planner_and_verifier_agree_on_loads_that_rules_ask_about() -> None:
    problem, _ = compile_text(text())
    planner, verifier = SceneLoads(problem), Guards(problem)
    forth, back = ("a", "a.A", "a.B"), ("b", "b.B", "b.A")
    for chain in (Chain((forth,)), Chain((back,)), Chain((forth, back)), Chain((forth, ("b", "b.A", "b.B")))):
        assert planner.chain(chain) == pytest.approx(verifier.load(chain)) and planner.chain(chain) > 0.0
    assert planner.chain(Chain((forth, back))) > planner.chain(Chain((forth,)))
    assert planner.of("a.B") == pytest.approx(verifier.load("a.B"))
    for joint in ("j2", "j3", "j4", "none"):
        assert planner.torque("a.B", joint) == pytest.approx(verifier.torque("a.B", joint), abs=1e-9)
    assert abs(planner.torque("a.B", "j3")) > 1.0 and planner.torque("a.B", "none") == 0.0


@pytest.mark.parametrize(
    ("rows", "tighter"),
    [
        ("during load(X) <= 0.4", "during load(X) <= 0.05"),
        ("at switch abs(torque(X.j2)) <= 4 N m", "at switch abs(torque(X.j2)) >= 30 N m"),
    ],
)
def test_rows_about_loads_are_kept_and_measured(rows: str, tighter: str) -> None:
    outcome = solve(compile_text(text(rows))[0], SolveOptions(time=40.0))
    assert outcome.status == "solved", [d.message for d in outcome.explanation]
    verdict = outcome.plans[0].verdict
    assert verdict is not None and verdict.verified and verdict.worst["load_share"] <= 0.01
    assert {f.kind for f in judge(outcome.plans[0], compile_text(text(tighter))[0]).failures} == {"load_share"}


def test_a_guard_about_loads_decides_what_is_tried() -> None:
    outcome = solve(compile_text(text(guard="load(B) > 1"))[0], SolveOptions(time=20.0))
    assert outcome.status in ("infeasible", "exhausted")


@pytest.mark.parametrize(
    ("rows", "code"),
    [
        ("during torque(X) <= 3 N m", "E0208"),
        ("during torque(X.j2) <= 3", "E0203"),
        ("during torque(X.j9) <= 3 N m", "E0114"),
        ("during load(3) <= 1", "E0208"),
        ("during wrench(X, Y) <= (1 N, 2 N, 3 N)", "E0401"),
        ("during wrench(X, Y) <= (1 N, 1 N, 1 N, 1 N m)", "E0001"),
        ("during wrench(X) <= 0", "E0201"),
        ("during wrench(X, Y) <= (1 N, 2 N, 3 N, 1 N, 0, 0)", "E0203"),
        ("during wrench(X, Y) <= (0, 0, 3, 1 N m, 0, 0)", "E0203"),
        ("at switch position(X) = (1 m, 0, 2 kg)", "E0203"),
    ],
)
def test_misuse_is_told(tmp_path: Path, rows: str, code: str) -> None:
    path = tmp_path / "t.tamp"
    path.write_text(text(rows))
    assert code in {d.code for d in check(path)}
