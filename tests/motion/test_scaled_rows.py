"""Rows in another unit of length keep their form; only numbers that are lengths change."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tamplang.compiler import ir
from tamplang.compiler.motion.lasting import lasting
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.planner.bounds.length_unit import LengthUnit
from tamplang.runtime.planner.bounds.scaled_rows import in_unit

TEXT = """
motion [m X Y: object] {{
    {row}
}}
predicate (done)
rule r(X Y: object) {{ post (done), [m X Y] }}
task t {{
    object a: box(1 m, 1 m, 1 m) at (0, 0, 0)
    object b: box(1 m, 1 m, 1 m) at (2 m, 0, 0)
    goal (done)
}}
"""


def _problem(row: str) -> ir.Problem:
    return compile_text(TEXT.format(row=row), "rows.tamp", None, {})[0]


def _row(text: str) -> ir.Row:
    return _bare(_problem(text).motions["m"].rows[0])


def _bare(row: ir.Row) -> ir.Row:
    return replace(row, span=None)


@pytest.mark.parametrize(
    ("metres", "halved"),
    [
        ("during bottom(X) = top(Y)", "during bottom(X) = top(Y)"),
        ("at switch gap(X, Y) <= 4 cm", "at switch gap(X, Y) <= 2 cm"),
        ("at switch gap(X, Y) = 0", "at switch gap(X, Y) = 0"),
        ("at switch position(X) - position(Y) = 4 cm * axis(Y, z)",
         "at switch position(X) - position(Y) = 2 cm * axis(Y, z)"),
        ("at switch position(X) = (1 m, 2 m, 4 m)", "at switch position(X) = (50 cm, 1 m, 2 m)"),
        ("at switch inside(X, Y) >= least(4 cm, inside(Y, Y) / 2)",
         "at switch inside(X, Y) >= least(2 cm, inside(Y, Y) / 2)"),
        ("during norm(position(X) - position(Y)) <= 1 m", "during norm(position(X) - position(Y)) <= 0.5 m"),
        ("at switch dot(axis(X, z), (0, 0, 1)) >= 0.97", "at switch dot(axis(X, z), (0, 0, 1)) >= 0.97"),
        ("at switch abs(dot(position(X) - position(Y), axis(Y, x))) >= 4 cm",
         "at switch abs(dot(position(X) - position(Y), axis(Y, x))) >= 2 cm"),
        ("at switch 2 * dot(position(X), axis(Y, x)) >= 4 cm", "at switch 2 * dot(position(X), axis(Y, x)) >= 2 cm"),
        ("at switch bottom(X) >= top(Y) + radius(X) + 4 cm", "at switch bottom(X) >= top(Y) + radius(X) + 2 cm"),
        ("keep gap(X, Y)", "keep gap(X, Y)"),
        ("at switch sqrt(dot(position(X), position(X))) <= 4 cm",
         "at switch sqrt(dot(position(X), position(X))) <= 2 cm"),
    ],
)  # fmt: skip
def test_lengths_are_turned_and_the_form_stays(metres: str, halved: str) -> None:
    row = in_unit(_row(metres), 2.0)
    assert row is not None and _bare(row) == _row(halved)


def test_squares_of_lengths_are_turned_otherwise() -> None:
    assert in_unit(_row("at switch dot(position(X), position(X)) <= 0.04"), 2.0) is None


@pytest.mark.parametrize("side", ["axis(Y, z) / 2", "(axis(Y, z) + axis(X, z)) / 4"])
def test_parts_of_axes_are_not_taken_for_lengths_in_the_unit(side: str) -> None:
    assert in_unit(_row(f"at switch position(X) - position(Y) = {side}"), 2.0) is None


def test_contacts_that_last_are_known_in_any_unit() -> None:
    problem = LengthUnit(_problem("during bottom(X) = top(Y)"), 0.05).problem
    assert lasting(problem, ("m", "a", "b")) == [("a", "b")]
