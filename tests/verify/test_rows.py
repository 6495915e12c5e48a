"""Rows of motion predicates, measured on motions whose figures are known."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tamplang.compiler import ir
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.plan import Plan
from tamplang.runtime.verify import check
from tamplang.runtime.verify.constraints import shapes_of
from tamplang.runtime.verify.kinematics import Kinematics, motion_of
from tamplang.runtime.verify.rows import Evaluator, MeaninglessRow

from .conftest import PAIR
from .motions import Maker

X, Y = ir.Var("X"), ir.Var("Y")


def call(name: str, *arguments: ir.Term) -> ir.Function:
    return ir.Function(name, arguments)


def axis(subject: ir.Term, letter: str) -> ir.Function:
    return call("axis", subject, ir.Letter(letter))


@pytest.fixture(scope="module")
def evaluate(pair: Plan) -> Callable[[ir.Term], list[float]]:
    """Terms of X = c[1].A, which stands on Y = slab at (0, -0.4), at the start."""
    problem, _ = compile_text(PAIR, "wave.tamp", "wave")
    motion = motion_of(pair, {m.name: Kinematics(m) for m in pair.modules})
    evaluator = Evaluator(shapes_of(problem), motion)
    names = {"X": "c[1].A", "Y": "slab"}
    return lambda node: evaluator.value(node, names, np.array([0]))


@pytest.mark.parametrize(
    ("node", "values", "unit"),
    [
        (call("position", X), [0.0, -0.4, 0.075], "m"),
        (axis(X, "z"), [0.0, 0.0, -1.0], ""),
        (call("gap", X, Y), [0.0], "m"),
        (call("top", Y), [0.025], "m"),
        (call("top", X), [0.125], "m"),
        (call("bottom", X), [0.025], "m"),
        (call("radius", X), [0.05], "m"),
        (call("radius", Y), [0.5 * math.hypot(2, 2, 0.05)], "m"),
        (call("inside", X, Y), [1.0, 1.0, 1.4, 0.6], "m"),
        (call("dot", axis(X, "z"), axis(Y, "z")), [-1.0], ""),
        (call("cross", axis(Y, "x"), axis(Y, "y")), [0.0, 0.0, 1.0], ""),
        (call("norm", ir.Arith("-", (call("position", X), call("position", Y)))), [math.hypot(0.4, 0.075)], "m"),
        (ir.Arith("*", (ir.Number(2.0), axis(Y, "y"))), [0.0, 2.0, 0.0], ""),
        (ir.Arith("/", (call("top", Y), ir.Number(5.0))), [0.005], "m"),
        (ir.Arith("neg", (call("top", Y),)), [-0.025], "m"),
        (ir.Vector((ir.Number(1.0), call("top", Y), ir.Number(0.0))), [1.0, 0.025, 0.0], "m"),
        (call("sqrt", ir.Number(4.0)), [2.0], ""),
        (call("cos", ir.Number(0.0)), [1.0], ""),
        (call("abs", ir.Number(-3.0)), [3.0], ""),
        (call("least", call("top", Y), ir.Number(1.0)), [0.025], "m"),
        (call("least", call("inside", X, Y), call("top", Y)), [0.025] * 4, "m"),
    ],
)
def test_terms(evaluate: Callable[..., object], node: ir.Term, values: list[float], unit: str) -> None:
    quantity = evaluate(node)
    assert quantity.values[0] == pytest.approx(values, abs=1e-9)
    assert quantity.unit == unit


def test_meaningless_terms_are_told(evaluate: Callable[..., object]) -> None:
    for node in (ir.Prune(), call("pose", X, Y), ir.Arith("%", (X, Y)), call("position", ir.Var("Z"))):
        with pytest.raises(MeaninglessRow):
            evaluate(node)


# --- whole predicates --------------------------------------------------------------------------------------------

ROWS = """
import std.crawler
import std.motion

predicate (waved c: module)

motion [checked X Y: object] {
    ROW
}

rule wave(c: module, X: effector, Y: object) {
    post  (waved c), [checked X Y]
}

task wave() {
    object slab: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    crawler c: A on slab
    goal (waved c)
}
"""


def waves(row: str) -> Plan:
    """Twice the same action: its literal is added at 4 s and holds from there to 8 s."""
    maker = Maker(ROWS.replace("ROW", row), "wave")
    bend = 0.4 * np.eye(7)[3]
    maker.phase("wave", ("c", "c.B", "slab"), [np.zeros(7)])
    maker.phase("wave", ("c", "c.B", "slab"), [bend])
    return maker.plan()


def failures(row: str) -> list[tuple[str, float, float | None]]:
    plan = waves(row)
    problem, _ = compile_text(plan.task.sources[0].text, "wave.tamp", "wave")
    return [(f.kind, f.amount, f.time) for f in check(plan, problem).failures]


TIP = 0.075 + 1.0
"""Height of c.B over the origin when all joints are at zero."""
BENT = 0.075 + 0.5 + 0.5 * math.cos(0.4)


def test_switch_rows_bind_at_every_switch_that_adds_them() -> None:
    assert failures(f"at switch bottom(X) <= {TIP - 0.05 + 1e-6} m") == []
    found = failures(f"at switch bottom(X) = {TIP - 0.05 - 0.01:.6f} m")
    assert [kind for kind, _, _ in found] == ["position_m", "position_m"]
    assert found[0][1:] == pytest.approx((0.01, 4.0), abs=1e-6)
    assert found[1][1:] == pytest.approx((TIP - 0.01 - BENT, 8.0), abs=1e-6)


def test_during_rows_bind_while_the_literal_holds() -> None:
    assert failures(f"during bottom(X) >= {BENT - 0.05 - 1e-6} m") == []
    ((kind, amount, time),) = failures(f"during bottom(X) >= {TIP - 0.05:.6f} m")
    assert (kind, time) == ("during_m", pytest.approx(8.0))
    assert amount == pytest.approx(TIP - BENT, abs=1e-6)


def test_keep_rows_of_any_value_are_measured() -> None:
    assert failures("keep dot(axis(X, y), axis(Y, y))") == []
    ((kind, amount, time),) = failures("keep dot(axis(X, z), axis(Y, z))")
    assert (kind, time) == ("slip_rad", pytest.approx(8.0))
    assert amount == pytest.approx(1 - math.cos(0.4), abs=1e-6)


def test_direction_rows_are_called_orientation() -> None:
    found = failures("at switch axis(X, z) = (0, 0, 1)")
    ((kind, amount, _),) = found
    assert kind == "orientation_rad" and amount == pytest.approx(math.sin(0.4), abs=1e-6)


def test_row_without_meaning_is_refused(pair: Plan) -> None:
    problem, _ = compile_text(PAIR, "wave.tamp", "wave")
    stand = problem.motions["stable"]
    rows = (ir.Row("keep", ir.Prune(), "", None, 1),)
    motions = {**problem.motions, "stable": replace(stand, rows=rows)}
    assert "constraint" in {f.kind for f in check(pair, replace(problem, motions=motions)).failures}
