"""The solvers on small programs with known answers."""

from __future__ import annotations

import numpy as np
import pytest

from tamplang.runtime.budget import Budget, OutOfTime
from tamplang.runtime.planner.motion.nlp.augmented_lagrangian import SolverOptions, project, solve
from tamplang.runtime.planner.motion.nlp.ipopt import solve_ipopt
from tamplang.runtime.planner.motion.nlp.program import DIVERGED, Program
from tamplang.runtime.planner.motion.nlp.row_groups import LinearGroup, LinearWish, NormGroup, RowLabel
from tamplang.runtime.planner.motion.nlp.systems import BandedSystem, DenseSystem
from tamplang.runtime.skeleton import Breach

EXACT = SolverOptions(tolerance=1e-8, step_tolerance=1e-6, iterations=300)


def linear(kind: str, rows: list[list[float]], targets: list[float], places: list[list[int]]) -> LinearGroup:
    labels = [RowLabel(i, Breach.JOINT_LIMIT, ("x", str(i)), ("m",)) for i in range(len(rows))]
    return LinearGroup(kind, np.array(places), np.array(rows), np.array(targets), labels)


def quadratic() -> Program:
    """Nearest point to (3, 4, 0) with x0 + x1 = 5 and x1 <= 2.5; place 0 of z is a constant."""
    cost = linear("cost", [[1.0]] * 3, [3.0, 4.0, 0.0], [[1], [2], [3]])
    equality = linear("equality", [[1.0, 1.0]], [5.0], [[1, 2]])
    bound = linear("inequality", [[1.0]], [2.5], [[2]])
    return Program(np.array([7.0]), 3, [cost, equality, bound])


def test_quadratic_program() -> None:
    outcome = solve(quadratic(), np.zeros(3), EXACT, Budget(None))
    assert outcome.status == "feasible"
    assert outcome.x == pytest.approx([2.5, 2.5, 0.0], abs=1e-4)


def test_ipopt_agrees() -> None:
    outcome = solve_ipopt(quadratic(), np.zeros(3), EXACT, Budget(None))
    assert outcome.status == "feasible"
    assert outcome.x == pytest.approx([2.5, 2.5, 0.0], abs=1e-4)


def test_nonlinear_equality() -> None:
    """The nearest unit vector to (1, 2, 3, 4)."""
    wish = np.array([1.0, 2.0, 3.0, 4.0])
    cost = linear("cost", [[1.0]] * 4, wish.tolist(), [[0], [1], [2], [3]])
    program = Program(np.zeros(0), 4, [cost, NormGroup(np.arange(4).reshape(1, 4))])
    for outcome in (
        solve(program, np.array([0.5, 0.1, 0.2, 0.3]), EXACT, Budget(None)),
        solve_ipopt(program, np.array([0.5, 0.1, 0.2, 0.3]), EXACT, Budget(None)),
    ):
        assert outcome.x == pytest.approx(wish / np.linalg.norm(wish), abs=1e-4)


def test_costs_are_linear() -> None:
    norm = NormGroup(np.arange(4).reshape(1, 4))
    norm.kind = "cost"
    with pytest.raises(TypeError, match="linear"):
        Program(np.zeros(0), 4, [norm])


def test_costs_of_different_widths_add_up() -> None:
    """The gradient and band at x of two costs in one program are the sums of those in two."""
    one = linear("cost", [[2.0], [3.0]], [1.0, -1.0], [[1], [3]])
    other = linear("cost", [[1.0, -2.0, 1.0]], [0.5], [[1, 2, 3]])
    x, none = np.array([0.3, -0.2, 0.9]), (np.zeros(0), np.zeros(0))
    systems = []
    for costs in ([one, other], [one], [other]):
        program = Program(np.array([7.0]), 3, costs)
        gradient, band = program.normal(x, program.residuals(x), none, 1.0)
        systems.append((gradient, np.pad(band, ((0, 0), (0, 3 - program.width)))))
    (gradient, band), *parts = systems
    assert gradient == pytest.approx(sum(g for g, _ in parts))
    assert band == pytest.approx(sum(b for _, b in parts))


class NoNumber(LinearGroup):
    """Rows that are no number where x0 is above 0.1, as the logarithm of something negative."""

    def residuals(self, z: np.ndarray) -> np.ndarray:
        return np.where(z[1] > 0.1, np.nan, super().residuals(z))


@pytest.mark.parametrize("kind", ["equality", "inequality"])
@pytest.mark.parametrize("start", [0.5, np.nan])
def test_what_is_no_number_is_never_feasible(kind: str, start: float) -> None:
    rows = linear(kind, [[1.0, 1.0]], [-5.0], [[1, 2]])
    bad = NoNumber(kind, rows.places, rows.coefficients, rows.targets, rows.labels)
    program = Program(np.array([7.0]), 3, [linear("cost", [[1.0]] * 3, [3.0, 4.0, 0.0], [[1], [2], [3]]), bad])
    for outcome in (
        solve(program, np.full(3, start), SolverOptions(), Budget(20.0)),
        solve_ipopt(program, np.full(3, start), SolverOptions(), Budget(20.0)),
    ):
        assert outcome.status == "stalled"
        assert program.largest(outcome.x) == DIVERGED
        assert [v.amount for v in program.violations(outcome.x, 1e-3)] == [DIVERGED]
    lost = project(program, np.full(3, 0.5), 1e-6, Budget(20.0))
    assert program.largest(lost) == DIVERGED


def test_contradiction_stalls() -> None:
    equality = linear("equality", [[1.0], [1.0]], [0.0, 1.0], [[0], [0]])
    program = Program(np.zeros(0), 1, [equality])
    outcome = solve(program, np.zeros(1), SolverOptions(), Budget(None))
    assert outcome.status == "stalled"
    assert outcome.iterations < 60
    worst = program.violations(outcome.x, 1e-3)
    assert [v.names for v in worst] == [("x", "0"), ("x", "1")] or len(worst) == 2
    assert worst[0].amount == pytest.approx(0.5, abs=0.1)


def test_what_cannot_come_nearer_is_given_up_soon() -> None:
    """A sphere and a plane that do not meet: between them both rows are missed, and no step changes that."""
    sphere = NormGroup(np.array([[0, 1, 2, 3]]))
    away = linear("equality", [[1.0]], [1.5], [[0]])
    pull = linear("cost", [[0.3]] * 4, [0.0, 0.3, 0.2, 0.0], [[0], [1], [2], [3]])
    outcome = solve(Program(np.zeros(0), 4, [sphere, away, pull]), np.full(4, 0.4), SolverOptions(), Budget(None))
    assert outcome.status == "stalled"
    assert outcome.iterations < 15  # 24 until all penalties have grown
    assert outcome.x[0] == pytest.approx(1.09, abs=0.01)


def test_what_costs_hold_off_at_first_is_not_given_up() -> None:
    """A cost that weighs as much as rows at first keeps a unit quaternion from being one."""
    norm = NormGroup(np.arange(4).reshape(1, 4))
    costly = linear("cost", [[10.0]] * 4, [10.0 * x for x in (0.9, 1.2, 0.0, 0.0)], [[0], [1], [2], [3]])
    held = solve(Program(np.zeros(0), 4, [norm, costly]), np.full(4, 0.5), SolverOptions(), Budget(None))
    assert held.status == "feasible"
    assert held.x == pytest.approx([0.6, 0.8, 0.0, 0.0], abs=1e-3)


def test_what_is_nearly_feasible_is_projected() -> None:
    norm = NormGroup(np.arange(4).reshape(1, 4))
    pull = linear("cost", [[1.0]] * 4, [1.0, 1.0, 1.0, 1.0], [[0], [1], [2], [3]])
    program, start = Program(np.zeros(0), 4, [norm, pull]), np.full(4, 0.49)
    outcomes = [
        solve(program, start, SolverOptions(projected=projected, tolerance=1e-9), Budget(None))
        for projected in (0.0, 0.1)
    ]
    assert [outcome.status for outcome in outcomes] == ["feasible", "feasible"]
    assert outcomes[1].iterations < outcomes[0].iterations
    assert program.largest(outcomes[1].x) < 1e-9


def test_repeated_places_count_twice() -> None:
    """A row that names one unknown twice: (x + x − 2)² has its least value at x = 1."""
    program = Program(np.zeros(0), 1, [linear("equality", [[1.0, 1.0]], [2.0], [[0, 0]])])
    gradient, band = program.normal(np.zeros(1), program.residuals(np.zeros(1)), (np.zeros(1), np.zeros(0)), 1.0)
    assert gradient == pytest.approx([-4.0])
    assert band == pytest.approx(np.array([[4.0]]))
    assert solve(program, np.zeros(1), EXACT, Budget(None)).x == pytest.approx([1.0])


@pytest.mark.parametrize("costs", [False, True])
def test_dense_and_banded_systems_take_the_same_step(costs: bool) -> None:
    """With constants, rows of several widths, places named twice, and rows that push beside some that do not."""
    rows = [
        linear("cost", [[1.0, -1.0], [2.0, 1.0]], [0.5, 0.0], [[1, 2], [3, 4]]),
        linear("equality", [[1.0, 1.0]], [2.0], [[2, 2]]),
        linear("equality", [[1.0, 0.5, -1.0]], [0.1], [[0, 3, 4]]),
        NormGroup(np.array([[1, 2, 3, 4]])),
        linear("inequality", [[1.0], [-1.0], [1.0]], [-1.0, 5.0, 0.0], [[1], [2], [4]]),
        LinearWish(linear("inequality", [[1.0], [1.0]], [-2.0, 3.0], [[3], [4]]), 3.0),
    ]
    program, x = Program(np.array([7.0]), 4, rows), np.array([0.3, -0.2, 0.9, 0.4])
    residuals = program.residuals(x)
    given = residuals, (np.array([0.2, -0.1, 0.3]), np.array([0.0, 0.1, 0.4])), 20.0, costs
    dense, banded = program.system(x, *given), BandedSystem(*program.normal(x, *given))
    assert isinstance(dense, DenseSystem)
    assert dense.gradient == pytest.approx(banded.gradient)
    assert dense.step(0.1)[0] == pytest.approx(banded.step(0.1)[0])


def test_projection_is_exact_and_near() -> None:
    program = quadratic()
    x = project(program, np.array([2.0, 3.01, 1.0]), 1e-9, Budget(None))
    assert program.largest(x) < 1e-8
    assert x == pytest.approx([2.5, 2.5, 1.0], abs=0.02)


def test_band_of_a_chain_has_constant_width() -> None:
    size = 50
    places = np.stack([np.arange(size - 2), np.arange(1, size - 1), np.arange(2, size)], axis=1)
    bend = LinearGroup("cost", places, np.array([[1.0, -2.0, 1.0]]), np.zeros(size - 2), [])
    ends = linear("equality", [[1.0], [1.0]], [0.0, 1.0], [[0], [size - 1]])
    program = Program(np.zeros(0), size, [bend, ends])
    assert program.width == 3
    options = SolverOptions(tolerance=1e-6, step_tolerance=1e-5, iterations=500)
    outcome = solve(program, np.zeros(size), options, Budget(None))
    assert outcome.x == pytest.approx(np.linspace(0, 1, size), abs=1e-3)


def test_a_spent_budget_ends_the_run() -> None:
    with pytest.raises(OutOfTime):
        solve(quadratic(), np.zeros(3), EXACT, Budget(0.0))
