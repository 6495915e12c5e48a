"""An arm whose shoulder is beside its axis brings a thing behind a wall, for which it has to turn over: descent from a
posture in which the upper arm goes through the wall does not find that."""

from __future__ import annotations

import tamplang

OVER = """
import std.logic
import std.motion
type flange < effector
module arm(aside: length = 14 cm) {
    effector foot: flange cylinder(8 cm, 2 cm) at (0, 0, 1 cm) normal (0, 0, -1)
    link 9 cm: cylinder(6 cm)
    joint pan: revolute(z) in -360 deg .. 360 deg
    link (0, aside, 0): capsule(5 cm)
    joint lift: revolute(y) in -360 deg .. 360 deg
    link 43 cm: capsule(45 mm)
    joint elbow: revolute(y) in -180 deg .. 180 deg home 90 deg
    link (0, -3 cm, 39 cm): capsule(4 cm)
    joint w1: revolute(y) in -360 deg .. 360 deg
    link (0, 9 cm, 0): capsule(4 cm)
    joint w2: revolute(z) in -360 deg .. 360 deg
    link 9 cm: capsule(4 cm)
    joint w3: revolute(y) in -360 deg .. 360 deg
    link (0, 6 cm, 0): capsule(3 cm)
    effector tool: gripper sphere(1 cm) at (0, 25 mm, 0) normal (0, 1, 0)
}
placement (A: flange) on (Y: object) { (support A), (on Y A), [stable Y A] }
rule pick(A: gripper, X: object) {
    pre  (grippable X), not exists Z: object { (grasped A Z) }
    post (grasped A X), not (on ANY X), not [stable ANY X], not [rest X ANY], [touch A X], [stable A X]
}
rule put(A: gripper, X Y: object) {
    pre  (grasped A X), (tray Y)
    post not (grasped A X), not [stable A X], not [touch A X], (on Y X), [stable Y X], [rest X Y]
}
task over() {
    base floor: box(3 m, 3 m, 4 cm) at (0, 0, -2 cm)
    object pedestal: cylinder(10 cm, 30 cm) at (0, 0, 15 cm)
    object left: box(40 cm, 40 cm, 20 cm) at (45 cm, 40 cm, 10 cm)
    object right: box(40 cm, 40 cm, 20 cm) at (45 cm, -40 cm, 10 cm)
    object barrier: box(80 cm, 2 cm, 50 cm) at (55 cm, 0, 25 cm)
    object brick: box(6 cm, 6 cm, 10 cm) on left
    fact (grippable brick)
    fact (tray right)
    arm a: foot on pedestal
    goal (on right brick)
}
"""


def test_an_arm_turns_over_to_put_something_behind_a_wall() -> None:
    result = tamplang.loads(OVER, seed=2).solve(time=120.0)
    assert result.plan is not None, result.explanation
    assert result.plan.verify().verified
