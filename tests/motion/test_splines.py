"""The planner's splines, quaternions and banded systems against SciPy's and NumPy's."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from tamplang.runtime.geometry.splines import ClampedSpline, spline_weights
from tamplang.runtime.geometry.transforms import quaternions
from tamplang.runtime.planner.motion.nlp.banded_cholesky import factored, solved

RANDOM = np.random.default_rng(4)


@pytest.mark.parametrize("derivative", range(4))
@pytest.mark.parametrize("pieces", [1, 2, 3, 20])
def test_splines_are_those_of_scipy(pieces: int, derivative: int) -> None:
    knots = 3.0 + np.cumsum(RANDOM.uniform(0.1, 1.0, pieces + 1))
    values = RANDOM.normal(size=(pieces + 1, 2, 3))
    times = np.linspace(knots[0] - 0.1, knots[-1] + 0.1, 50)
    expected = CubicSpline(knots, values, bc_type="clamped")(times, derivative)
    found = ClampedSpline(knots, values)(times, derivative)
    assert np.allclose(found, expected, rtol=1e-9, atol=1e-9 * abs(expected).max())


def test_splines_without_columns_and_of_single_numbers() -> None:
    assert ClampedSpline([0.0, 1.0], np.zeros((2, 0)))([0.2, 0.4]).shape == (2, 0)
    assert ClampedSpline([0.0, 1.0], [0.0, 2.0])([0.5]) == pytest.approx([1.0])


def test_weights_take_values_to_the_spline() -> None:
    values, times = RANDOM.normal(size=(11, 4)), np.linspace(0.0, 10.0, 31)
    assert np.allclose(spline_weights(10, times) @ values, CubicSpline(np.arange(11), values, bc_type="clamped")(times))


def test_quaternions_of_rotations_by_every_angle() -> None:
    turns = np.concatenate([RANDOM.normal(size=(40, 4)), np.eye(4), [[1.0, 1.0, 0.0, 0.0], [0.0, 1.0, -1.0, 1e-12]]])
    rotations = Rotation.from_quat(turns)
    found = quaternions(rotations.as_matrix().reshape(2, 23, 3, 3)).reshape(-1, 4)
    assert np.all(found[:, 3] >= 0)
    assert np.allclose(np.linalg.norm(found, axis=1), 1.0)
    assert np.allclose(Rotation.from_quat(found).as_matrix(), rotations.as_matrix(), atol=1e-12)


def test_banded_systems_are_solved_and_indefinite_ones_told() -> None:
    band = np.column_stack([RANDOM.uniform(4.0, 5.0, 9), RANDOM.uniform(-1.0, 1.0, 9), RANDOM.uniform(-1.0, 1.0, 9)])
    matrix = np.diag(band[:, 0])
    for off in (1, 2):
        matrix += np.diag(band[: 9 - off, off], -off) + np.diag(band[: 9 - off, off], off)
    right = RANDOM.normal(size=9)
    factor = factored(band.copy())
    assert factor is not None
    assert np.allclose(solved(factor, right), np.linalg.solve(matrix, right))
    band[4, 0] = -1.0
    assert factored(band) is None


def test_the_planner_and_the_verifier_load_little_of_scipy() -> None:
    code = (
        "import sys\n"
        "import tamplang.runtime.planner.lgp, tamplang.runtime.planner.motion.phases, tamplang.runtime.verify\n"
        "print([m for m in sys.modules if m in ('scipy.linalg', 'scipy.interpolate', 'scipy.spatial', 'numpy.f2py')])\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
