"""Rows that bind all along: ways around walls on them, phases in which nothing moves, and what contradicts them."""

from __future__ import annotations

import pytest

import tamplang

HOIST = """
import std.motion
type claw < effector
predicate (holding H: claw, X: object) functional in H
predicate (lies X Y: object)
predicate (noted X: object)
module hoist {
    joint x: prismatic(x) in -1 m .. 1 m home -80 cm
    joint z: prismatic(z) in -1.2 m .. 0 m home -40 cm
    link (0, 0, -0.3 m): capsule(2 cm)
    joint w: revolute(y) in -150 deg .. 150 deg
    link (0, 0, -10 cm): capsule(1 cm)
    effector tip: claw sphere(1 cm) normal (0, 0, -1)
}
placement (X: object) on (Y: object) { (lies X Y), [stable Y X] }
motion [grasp H: claw, X: object] {
    at switch gap(H, X) = 0
    at switch axis(H, z) + axis(X, z) = 0
    keep pose(X, H)
}
motion [upright X: object] {
    during ROW
}
motion [tilted X: object] {
    at switch dot(axis(X, z), (0, 0, 1)) <= 0.2
}
motion [set X Y: object] {
    at switch bottom(X) = top(Y)
    at switch inside(X, Y) >= 0
}
rule take(H: claw, X Y: object) {
    pre not exists O: object { (holding H O) }, (lies X Y)
    post (holding H X), not (lies X Y), not [stable Y X], [grasp H X], [upright X]
}
rule put(H: claw, X Y: object) {
    pre (holding H X)
    where Y != X
    post not (holding H X), not [grasp H X], not [upright X], (lies X Y), [stable Y X], [set X Y]
}
rule note(H: claw, X: object) {
    pre (holding H X)
    post (noted X), DELETED [EXTRA X]
}
task over() {
    object floor: box(3 m, 1 m, 4 cm) at (0, 0, -2 cm)
    object wall: box(20 cm, 1 m, 60 cm) at (0, 0, 30 cm)
    object there: box(20 cm, 20 cm, 4 cm) on floor at (60 cm, 0)
    object cup: cylinder(3 cm, 10 cm) on floor at (-50 cm, 0)
    hoist h: at (0, 0, 1.6 m)
    goal (GOAL)
}
"""


def _solved(
    goal: str, row: str = "axis(X, z) = (0, 0, 1)", deleted: str = "not [upright X],", extra: str = "tilted"
) -> tamplang.Result:  # fmt: skip
    words = {"GOAL": goal, "ROW": row, "DELETED": deleted, "[EXTRA X]": f"[{extra} X]" if extra else "not [tilted X]"}
    text = HOIST
    for word, stands_for in words.items():
        text = text.replace(word, stands_for)
    return tamplang.loads(text).solve(time=60.0)


def test_a_way_over_a_wall_keeps_what_binds_all_along() -> None:
    result = _solved("lies cup there")
    assert result.plan is not None and result.plan.verified
    assert result.plan.poses("cup")[:, 2].max() > 0.6
    assert not result.plan.verify().failures


def test_a_phase_in_which_nothing_moves_needs_no_motion() -> None:
    result = _solved("noted cup", extra="")
    assert result.status == "solved" and result.plan is not None
    assert [(bound.bound, bound.refused) for bound in result.statistics.bounds][1] == ("seq-path", 0)


@pytest.mark.parametrize(
    ("deleted", "told"),
    [("not [upright X],", "until the switch of note"), ("", "and after note(h.tip, cup) still")],
)
def test_a_literal_that_does_not_go_with_what_an_action_asks_is_named(deleted: str, told: str) -> None:
    result = _solved("noted cup", deleted=deleted)
    assert result.plan is None
    refusal = result.explanation[0]
    assert "[tilted cup] is missed by 0.8: [upright cup] does not go with it" in refusal.message
    assert told in (refusal.note or "")
