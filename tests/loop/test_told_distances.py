"""What is told of clearances: overlaps of overlaps alone, both parts by name, and what robots could do about them."""

from __future__ import annotations

import pytest

import tamplang
from tamplang.compiler.part_names import part_names
from tamplang.compiler.pipeline import check_sources
from tamplang.langs.source import Source
from tamplang.runtime.planner.conflicts.infeasibility import describe
from tamplang.runtime.skeleton import Breach, Violation

GANTRY = """
import std.rules
module gantry(low: length = 0 m) {
    effector A: gripper sphere(5 cm) normal (0, 0, -1)
    link (0, 0, 1 m)
    joint dx: prismatic(x) in low .. 2 m
    joint dy: prismatic(y) in -1 m .. 1 m
    branch { link 0.1 m: box(4 cm, 4 cm) }
    joint dz: prismatic(z) in -0.95 m .. 0 m home -0.2 m
    effector B: gripper sphere(2 cm) normal (0, 0, -1)
    fact (linked A B)
}
task t() {
    base foot: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, -0.025 m)
    object item: box(4 cm, 4 cm, 4 cm) at (1.5 m, 0, 0.1 m)
    fact (grippable item)
    gantry g: A on foot
    MORE
    goal (held item)
}
"""
LID = " ".join(
    f"base wall{k}: box({a} cm, {b} cm, 20 cm) at ({x} m, {y} m, 0.1 m)"
    for k, (a, b, x, y) in enumerate([(1, 8, 1.465, 0), (1, 8, 1.535, 0), (6, 1, 1.5, 0.035), (6, 1, 1.5, -0.035)])
) + " base lid: box(10 cm, 10 cm, 2 cm) at (1.5 m, 0, 0.21 m) base floor: box(10 cm, 10 cm, 2 cm) at (1.5 m, 0, -1 cm)"


def test_a_margin_is_told_apart_from_an_overlap() -> None:
    near = Violation(0, Breach.COLLISION, ("c", "wall"), 0.014, "m", asked=0.02, parts=("c link 2", "wall"))
    assert describe(near) == "c link 2 comes within 6 mm of wall, 20 mm wished for"
    deep = Violation(0, Breach.SELF_COLLISION, ("c", "c"), 0.25, "m", asked=0.02, parts=("c link 1", "c link 4"))
    assert describe(deep) == "c link 1 and c link 4 would overlap by 0.23 m"
    assert describe(Violation(0, Breach.COLLISION, ("c", "x"), 0.0123, "m")) == "c and x would overlap by 12.3 mm"


def test_links_are_numbered_and_effectors_have_their_names() -> None:
    assert part_names("c", ["c.A", "c.B", "c", "c"]) == ["c.A", "c.B", "c link 1", "c link 2"]
    assert part_names("table", ["table"]) == ["table"]


def test_what_overlaps_is_named_also_where_time_runs_out() -> None:
    result = tamplang.loads(GANTRY.replace("MORE", LID)).solve(time=12.0)
    told = " ".join(d.message for d in result.explanation)
    assert result.plan is None and "overlap by" in told and "g.B" in told and "wished for" not in told


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("base post: box(0.1 m, 0.1 m, 0.2 m) at (0, 0, 0.8 m)", ("`post` and `g.B` overlap", "dx, dy, dz")),
        ("base post: box(0.1 m, 0.1 m, 0.04 m) at (0, 0.04 m, 1.12 m)", ("`post` and `g link", "never moves")),
    ],
)
def test_a_robot_in_something_at_its_start_is_told_what_could_move(more: str, words: tuple[str, ...]) -> None:
    found = check_sources([Source("t.tamp", GANTRY.replace("MORE", more))])
    told = [f"{d.message} {d.note}" for d in found if d.code == "E0502"]
    assert len(told) == 1 and all(word in told[0] for word in words), told


def test_a_robot_that_starts_in_itself_is_told_which_parts() -> None:
    joint = "joint j{}: revolute(y) in -150 deg .. 150 deg home ANGLE\n link 20 cm: box(3 cm, 3 cm)\n"
    folds = "".join(joint.format(k) for k in range(3))
    text = f"""import std.rules
    module arm() {{
        effector A: gripper sphere(5 cm)
        link (0, 0, 1 m)
        {folds} effector B: gripper sphere(1 cm)
        fact (linked A B)
    }}
    task t() {{ base foot: box(1 m, 1 m, 5 cm) at (0, 0, -2.5 cm) arm a: A on foot goal (on foot a.B) }}"""
    found = {}
    for angle in ("120 deg", "0 deg"):
        said = check_sources([Source("t.tamp", text.replace("ANGLE", angle))])
        found[angle] = [f"{d.message} {d.note}" for d in said if d.code == "E0502"]
    assert found["0 deg"] == [] and len(found["120 deg"]) == 1
    assert "`a link 1` and `a link 3` overlap" in found["120 deg"][0] and "j0, j1, j2" in found["120 deg"][0]
