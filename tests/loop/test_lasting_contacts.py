"""Contact that lasts: things that are pushed and wiped along what bears them, and places that nothing collides with."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import tamplang
from tamplang.compiler.motion.lasting import lasting
from tamplang.compiler.pipeline import compile_text

PUSH = """
import std.crawler
import std.logic
import std.motion

type crate < object
predicate (pushing A: effector, X: crate)
predicate (marked X: crate)

motion [slides X Y: object] {
    ROWS
    during axis(X, z) = (0, 0, 1)
    during dot(position(X) - position(Y), axis(Y, y)) = 0
}
motion [behind A: effector, X: object] {
    at switch gap(A, X) = 0
    at switch dot(position(A) - position(X), axis(X, x)) <= 0
}
motion [over X Y: object] { at switch inside(X, Y) >= 0 }

rule contact(A: gripper, X: crate, Y: object) {
    pre   (free A), (on Y X)
    post  not [stable Y X], (pushing A X), [behind A X], [stable A X], [slides X Y]
}
rule letGo(A: gripper, X: crate, Y: object, G: object) {
    pre   (pushing A X), (on Y X), (tray G)
    post  not (pushing A X), not [stable A X], not [slides X Y], [stable Y X], [over X G], (marked X)
}
task push() {
    base pedestal: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    object table: TABLE at (0.65 m, 0, 0.02 m)
    MARK
    crate x: CRATE on table at (-0.2 m, 0)
    fact (tray mark)
    crawler c: A on pedestal
    goal (marked x)
}
"""
LEVEL, STATED = "during bottom(X) = top(Y)", "touching X Y keep bottom(X)"
BOX, FLAT = "box(0.8 m, 0.4 m, 0.04 m)", "object mark: box(0.15 m, 0.15 m, 1 mm) at (0.85 m, 0, 0.0405 m)"
REGION = "region mark: box(0.15 m, 0.15 m, 0.2 m) at (0.85 m, 0, 0.1 m)"
FRUSTUM = (
    "hull((0, 0, 0), (80 cm, 0, 0), (80 cm, 40 cm, 0), (0, 40 cm, 0),"
    " (2 cm, 2 cm, 4 cm), (78 cm, 2 cm, 4 cm), (78 cm, 38 cm, 4 cm), (2 cm, 38 cm, 4 cm))"
)


def program(rows: str = LEVEL, table: str = BOX, mark: str = FLAT, crate: str = "box(0.1 m, 0.1 m, 0.1 m)") -> str:
    return PUSH.replace("ROWS", rows).replace("TABLE", table).replace("MARK", mark).replace("CRATE", crate)


@pytest.mark.parametrize(
    ("text", "seed"),
    [
        (program(), 0), (program(), 3),
        (program("during bottom(X) - top(Y) = 0", crate="cylinder(6 cm, 8 cm)"), 1),
        (program("during gap(X, Y) = 0", FRUSTUM), 2),
        (program(STATED, mark=REGION), 0), (program(STATED, mark=REGION), 2),
    ],
)  # fmt: skip
def test_a_crate_is_pushed_along_a_table_over_a_mark(text: str, seed: int) -> None:
    result = tamplang.loads(text, seed=seed).solve(time=60.0)
    assert result.plan is not None and result.plan.verify().verified
    assert [action.partition("(")[0] for action in result.plan.actions] == ["contact", "letGo"]


def test_a_step_on_the_table_is_in_the_way() -> None:
    step = FLAT.replace("1 mm", "1 cm").replace("0.0405", "0.045")
    result = tamplang.loads(program(mark=step)).solve(time=12.0)
    assert result.plan is None
    assert any("P_seqPath refuses letGo" in d.message for d in result.explanation), result.explanation


def test_a_crate_is_pushed_around_a_post_of_the_table() -> None:
    """Rows hold the crate on the top of its table; the other part of the table is in the way like anything else."""
    table = "union(box(0.8 m, 0.6 m, 0.04 m), box(4 cm, 12 cm, 10 cm) at (5 cm, 0, 7 cm))"
    text = program(table=table, mark=REGION).replace("    during dot(position(X) - position(Y), axis(Y, y)) = 0\n", "")
    result = tamplang.loads(text).solve(time=60.0)
    assert result.plan is not None and result.plan.verify().verified
    assert len(result.plan.actions) == 2


@pytest.mark.parametrize(
    ("rows", "held"),
    [
        ("during gap(X, Y) = 0", True), ("during 0 = gap(Y, X)", True), ("during top(Y) = bottom(X)", True),
        ("during bottom(X) - top(Y) = 0", True), ("at switch bottom(X) = top(Y) keep bottom(X) - top(Y)", True),
        ("at switch gap(X, Y) = 0 keep gap(X, Y)", True), ("keep gap(X, Y)", False), ("during gap(X, Y) >= 0", False),
        ("at switch gap(X, Y) = 0", False), ("at switch gap(X, Y) = 0 keep bottom(X) - top(Y)", False),
        ("during bottom(X) = bottom(Y)", False), ("during bottom(X) = top(Y) + 1 mm", False),
        ("during bottom(X) + top(Y) = 0", False),
    ],
)  # fmt: skip
def test_contact_is_read_from_rows(rows: str, held: bool) -> None:
    problem, _ = compile_text(program(rows))
    assert [set(p) for p in lasting(problem, ("slides", "x", "table"))] == ([{"x", "table"}] if held else [])


def test_contact_is_stated() -> None:
    problem, _ = compile_text(program(STATED))
    assert lasting(problem, ("slides", "x", "table")) == [("x", "table")]


def test_what_is_a_place_collides_with_nothing_and_what_is_not_does() -> None:
    standing = FLAT.replace("box(0.15 m, 0.15 m, 1 mm) at (0.85 m, 0, 0.0405 m)", "box(1 mm, 0.3 m, 0.3 m)")
    kinds = {FLAT: False, REGION: False, f"{standing} on table at (0.2 m, 0)": True}
    for mark, collides in kinds.items():
        problem, _ = compile_text(program(mark=mark))
        assert problem.world.bodies["mark"].collides == collides, mark
        assert all(problem.world.bodies[name].collides for name in ("table", "pedestal", "x"))


def test_a_plan_cannot_say_that_nothing_collides_with_a_wall(tmp_path: Path) -> None:
    result = tamplang.loads(program()).solve(time=60.0)
    assert result.plan is not None
    result.plan.save(tmp_path / "plan.json")
    data = json.loads((tmp_path / "plan.json").read_text())
    assert "places" in data["needs"] and not next(b for b in data["bodies"] if b["name"] == "mark")["collides"]
    next(b for b in data["bodies"] if b["name"] == "table")["collides"] = False
    (tmp_path / "plan.json").write_text(json.dumps(data))
    verdict = tamplang.read_plan(tmp_path / "plan.json").verify()
    assert not verdict.verified and any("collided with" in f.message for f in verdict.failures)


def test_touching_names_two_objects() -> None:
    with pytest.raises(tamplang.SourceError) as raised:
        compile_text(program("touching X X"))
    assert "E0406" in [d.code for d in raised.value.diagnostics]
