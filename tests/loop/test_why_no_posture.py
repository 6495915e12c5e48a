"""Where no posture does what an action asks, the cause is told: too far, a joint's limit, or what is in the way."""

from __future__ import annotations

import pytest

import tamplang

ARM = """
import std.rules
module arm(q: angle) {
    effector A: gripper cylinder(6 cm, 2 cm) at (0, 0, 1 cm) normal (0, 0, -1)
    link 30 cm: cylinder(4 cm)
    joint j1: revolute(z) in -170 deg .. 170 deg
    joint j2: revolute(y) in -q .. q
    link 30 cm: cylinder(3 cm)
    joint j3: revolute(y) in -q .. q
    link 31 cm
    effector B: gripper sphere(3 cm)
    fact (linked A B)
}
module slide() {
    effector A: gripper box(10 cm, 10 cm, 2 cm) at (0, 0, 1 cm) normal (0, 0, -1)
    link (0, 0, 40 cm)
    joint a: prismatic(x) in 0 m .. 1 m
    joint c: prismatic(z) in -0.3 m .. 0 m
    effector B: gripper sphere(3 cm) normal (0, 0, -1)
    fact (linked A B)
}
task reach(q: angle = 120 deg, x: length, z: length) {
    object table: box(20 cm, 20 cm, 40 cm) at (0, 0, 0)
    arm(q = q) a: A on table
    object ball: sphere(4 cm) at (x, 0, z)
    fact (grippable ball)
    goal (held ball)
    MORE
}
task down(z: length) {
    object table: box(20 cm, 20 cm, 10 cm) at (0, 0, -5 cm)
    object ball: box(4 cm, 4 cm, 4 cm) at (0.3 m, 0, z)
    fact (grippable ball)
    slide s: A on table
    goal (held ball)
}
"""
SHELL = " ".join(
    f"object w{axis}{side}: box({size}) at ({place})"
    for side, sign in ((0, -1), (1, 1))
    for axis, size, place in (
        ("x", "2 cm, 14 cm, 14 cm", f"{40 + 6 * sign} cm, 0, 60 cm"),
        ("y", "10 cm, 2 cm, 14 cm", f"40 cm, {6 * sign} cm, 60 cm"),
        ("z", "10 cm, 10 cm, 2 cm", f"40 cm, 0, {60 + 6 * sign} cm"),
    )
)


@pytest.mark.parametrize(
    ("task", "parameters", "more", "told"),
    [
        ("reach", {"x": "1 m", "z": "50 cm"}, "", "out of reach, even with nothing in the way"),
        ("reach", {"q": "15 deg", "x": "45 cm", "z": "40 cm"}, "", "joint j3 of a would have to go"),
        ("reach", {"x": "40 cm", "z": "60 cm"}, SHELL, "m, else a.B and w"),
        ("down", {"z": "3 cm"}, "", "joint c of s would have to go 20"),
    ],
)
def test_why_nothing_reaches_is_told(task: str, parameters: dict[str, str], more: str, told: str) -> None:
    result = tamplang.loads(ARM.replace("MORE", more), task, **parameters).solve(time=60.0)
    assert result.plan is None
    assert told in result.explanation[0].message, result.explanation[0].message
    assert "[touch" in result.explanation[0].message
    put = [label.text for label in result.explanation[0].labels if "put here" in label.text]
    assert put == (["`ball` is put here"] if "out of reach" in told else [])


def test_what_is_reached_at_a_limit_alone_is_reached() -> None:
    result = tamplang.loads(ARM.replace("MORE", ""), "down", z="5 cm").solve(time=60.0)
    assert result.plan is not None


def test_a_ring_that_cannot_close_is_told() -> None:
    """An arch whose both feet stand is to poke, with its knee, at what is too high for that."""
    text = """import std.logic
import std.motion
predicate (poked X: object)
type knee < gripper
module arch {
    effector A: gripper sphere(4 cm) normal (0, 0, -1)
    joint j1: revolute(y) in -90 deg .. 90 deg
    link 30 cm: capsule(2 cm)
    effector M: knee sphere(3 cm)
    joint j2: revolute(y) in -150 deg .. 150 deg home 60 deg
    link 30 cm: capsule(2 cm)
    joint j3: revolute(y) in -90 deg .. 90 deg home 60 deg
    effector B: gripper sphere(4 cm)
}
rule poke(M: knee, X: object) { post (poked X), [touch M X] }
task t {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    arch a: A on ground
    object ball: sphere(4 cm) at (0, 0, 70 cm)
    fact [stable ground a.B]
    goal (poked ball)
}"""
    result = tamplang.loads(text, "t").solve(time=60.0)
    assert result.plan is None
    assert "the ring that a is held in cannot close" in result.explanation[0].message


LABELS = """
import std.rules
import std.crawler
predicate (seen X: object)
motion [hover A: effector, X: object] {
    during gap(A, X) <= 20 cm
    at switch dot(axis(A, z), (0, 0, -1)) >= 0.9
}
rule look(A: gripper, X: object) {
    pre   (free A), (reachable A X), not (seen X)
    post  (seen X), [hover A X]DELETED
}
task labels() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    for k in 1 .. 2 {
        object tag[k]: box(6 cm, 6 cm, 2 cm) on ground at (0, 1.2 m * (k - 1.5))
    }
    crawler c: A on ground at (20 cm, 0)
    goal forall k in 1 .. 2 { (seen tag[k]) }
}
"""


@pytest.mark.parametrize(
    ("deleted", "told"),
    [
        ("", ", and no rule deletes it: its rows bind to the end, unless an action has the effect `not [hover …]`"),
        (", not [hover A ANY]", " until the switch of look(c.B, tag["),
    ],
)
def test_what_still_binds_is_told(deleted: str, told: str) -> None:
    """A `during` row that an action before began, and that nobody ends in time."""
    result = tamplang.loads(LABELS.replace("DELETED", deleted), "labels").solve(time=60.0)
    (note,) = {d.note for d in result.explanation if d.note and "holds since" in d.note}
    assert "holds since look(c.B, tag[" in note and told in note


def test_a_module_that_stands_head_down_is_told() -> None:
    text = LABELS.replace("DELETED", "").replace("import std.crawler", ARM.split("module slide")[0].replace(
        " at (0, 0, 1 cm) normal (0, 0, -1)", ""
    ))  # fmt: skip
    with pytest.raises(tamplang.SourceError) as found:
        tamplang.loads(text.replace("crawler c", "arm(1 rad) c"), "labels")
    (overlap,) = (d for d in found.value.diagnostics if d.code == "E0502")
    assert "hangs head down" in str(overlap.help)


def test_what_a_literal_keeps_till_the_switch_is_not_called_out_of_reach() -> None:
    """A cart lets go of where it is parked only at the switch at which it is to be elsewhere."""
    text = """import std.logic
type spot < object
type body < effector
module cart {
    joint go: planar(x, y) in (-3 m, -3 m) .. (3 m, 3 m)
    link 10 cm: cylinder(12 cm)
    effector E: body sphere(2 cm)
}
predicate (at B: body, Y: spot) functional in B
motion [parked B: body, Y: spot] {
    at switch inside(B, Y) >= 0
    keep pose(B, Y)
}
rule drive(B: body, X Y: spot) {
    pre (at B X)
    post not (at B X), not [parked B X], (at B Y), [parked B Y]
}
task t {
    for i in 1 .. 2 { spot s[i]: box(10 cm, 10 cm, 1 mm) at (i * 1 m, 0, -1 mm) }
    cart c: at (1 m, 0, 0)
    fact (at c.E s[1])
    fact [parked c.E s[1]]
    goal (at c.E s[2])
}"""
    result = tamplang.loads(text, "t").solve(time=60.0)
    assert result.plan is None
    assert "[parked c.E s[1]] keeps what would have to move where it is" in result.explanation[0].message
