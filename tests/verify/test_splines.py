"""The verifier's splines against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tamplang.runtime.verify.splines import Spline

RANDOM = np.random.default_rng(5)


@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize("pieces", [1, 2, 3, 4, 40, 400])
def test_values_and_derivatives_are_those_of_scipy(pieces: int, even: bool) -> None:
    knots = np.linspace(5.0, 7.0, pieces + 1) if even else 5.0 + np.cumsum(RANDOM.uniform(0.1, 1.0, pieces + 1))
    values, times = RANDOM.normal(size=(pieces + 1, 3)), np.linspace(knots[0] - 0.1, knots[-1] + 0.1, 60)
    spline, expected = Spline(knots, values), CubicSpline(knots, values, bc_type="clamped")
    for derivative in (0, 1, 2):
        wanted = expected(times, derivative)
        assert np.allclose(spline(times, derivative), wanted, rtol=1e-8, atol=1e-8 * abs(wanted).max())


def test_leading_coefficients() -> None:
    knots, values = np.cumsum(RANDOM.uniform(0.1, 1.0, 8)), RANDOM.normal(size=(8, 2))
    spline, expected = Spline(knots, values), CubicSpline(knots, values, bc_type="clamped")
    assert np.allclose(spline.cubic, expected.c[0])
    assert np.allclose(spline.square, expected.c[1])


@pytest.mark.parametrize("pieces", [1, 2, 7])
def test_extrema_are_those_of_many_values(pieces: int) -> None:
    values = RANDOM.normal(size=(pieces + 1, 3))
    values[:, 2] = 0.5
    spline = Spline(np.linspace(1.0, 2.0, pieces + 1), values)
    times, found = spline.extrema()
    fine = spline(np.linspace(1.0, 2.0, 20_001))
    assert np.allclose(found.max(axis=0), fine.max(axis=0), atol=1e-6)
    assert np.allclose(found.min(axis=0), fine.min(axis=0), atol=1e-6)
    for joint in range(3):
        assert np.allclose(spline(times[:, joint])[:, joint], found[:, joint])


BAD = [([0.0, 1.0, 1.0], 2.0), ([0.0, 2.0, 1.0], 2.0), ([0.0, 1.0, 2.0], float("nan"))]


@pytest.mark.parametrize(("knots", "last"), BAD)
def test_knots_that_do_not_increase_and_numbers_that_are_none(knots: list[float], last: float) -> None:
    with pytest.raises(ValueError, match="increasing knots"):
        Spline(knots, [[0.0], [1.0], [last]])
