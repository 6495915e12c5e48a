"""Things in the only way that some action can move: they are moved before what lies behind them is fetched."""

from __future__ import annotations

import tamplang

TEXT = """
import std.motion
type hand < effector
predicate (holding H: hand, X: object) functional in H
predicate (lies X Y: object)
predicate (light X: object) static
predicate (shelf Y: object) static
module cart {
    joint drive: planar(x, y) in (-1.2 m, -60 cm) .. (1.5 m, 60 cm) speed 0.5 m/s acceleration 0.5 m/s^2
    link 10 cm: cylinder(18 cm)
    joint lift: prismatic(z) in 0 m .. 40 cm
    link 10 cm: capsule(3 cm)
    link 4 cm
    effector tip: hand sphere(15 mm) at (36 cm, 0, 0) normal (1, 0, 0)
}
placement (X: object) on (Y: object) { (lies X Y), [stable Y X] }
motion [grasp H: hand, X: object] {
    at switch gap(H, X) = 0
    keep pose(X, H)
}
motion [set X Y: object] {
    at switch bottom(X) = top(Y)
    at switch axis(X, z) = (0, 0, 1)
    at switch inside(X, Y) >= 0
}
rule take(H: hand, X Y: object) {
    pre not (holding H ANY), (lies X Y), (light X)
    post (holding H X), not (lies X Y), not [stable Y X], [grasp H X]
}
rule put(H: hand, X Y: object) {
    pre (holding H X), (shelf Y)
    post not (holding H X), not [grasp H X], (lies X Y), [stable Y X], [set X Y]
}
task t() {
    object floor: box(4 m, 2 m, 4 cm) at (0.3 m, 0, -2.1 cm)
    for side in 1 .. 2 {
        object wall[side]: box(6 cm, 60 cm, 60 cm) at (60 cm, (2 * side - 3) * 65 cm, 30 cm)
    }
    object crate: box(20 cm, 55 cm, 30 cm) at (45 cm, 0, 15 cm)
    object table: box(30 cm, 30 cm, 15 cm) at (-80 cm, 40 cm, 7.5 cm)
    object pad: box(50 cm, 50 cm, 15 cm) at (-80 cm, -40 cm, 7.5 cm)
    object desk: box(30 cm, 30 cm, 15 cm) at (1.4 m, 0, 7.5 cm)
    object parcel: box(12 cm, 12 cm, 12 cm) on desk
    cart r: at (-30 cm, 0, 0)
    fact (lies crate floor)
    fact (light crate)
    fact (light parcel)
    fact (shelf table)
    fact (shelf pad)
    goal (lies parcel table)
}
"""


def test_what_blocks_the_only_way_is_moved_first() -> None:
    result = tamplang.loads(TEXT).solve(time=100.0)
    assert result.plan is not None and result.status == "solved"
    first = str(result.plan.actions[0])
    assert first == "take(r.tip, crate, floor)" and len(result.plan.actions) == 4


SWAP = """
import std.crawler
import std.rules
task swap() {
    base pedestal: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    for k in 1 .. 3 {
        object spot[k]: box(0.12 m, 0.12 m, 0.04 m) at (0.5 m, 0.2 m * (k - 2), 0.02 m)
        fact (tray spot[k])
    }
    for k in 1 .. 2 {
        object cup[k]: cylinder(0.035 m, 0.1 m) on spot[k]
        fact (grippable cup[k])
    }
    crawler arm: A on pedestal
    goal (on spot[2] cup[1]), (on spot[1] cup[2])
}
"""
"""Each cup stands where the other one shall be, and there is one free place."""


def test_a_place_that_is_taken_is_not_forbidden_once_it_is_free() -> None:
    result = tamplang.loads(SWAP).solve(time=100.0)
    assert result.plan is not None and result.status == "solved"
    assert len(result.plan.actions) == 6


def test_what_stands_in_the_way_is_named() -> None:
    result = tamplang.loads(SWAP.replace("1 .. 3", "1 .. 2").replace("0.035 m", "0.058 m")).solve(time=100.0)
    assert result.plan is None
    told = " ".join(str(d.note) for d in result.explanation)
    assert "without cup[1] there it can be done" in told or "without cup[2] there it can be done" in told
