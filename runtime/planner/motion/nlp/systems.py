"""Gauss-Newton systems that are ready to be solved."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from ....skeleton import Array
from .banded_cholesky import factored, solved, solved_dense

NO_STEP = 1e20
"""With this damping and more there is no step worth to be taken."""


class System(ABC):
    """A model ½dᵀMd + gᵀd of what is minimised, with `gradient` g and a positive semidefinite matrix M."""

    def __init__(self, gradient: Array, matrix: Array) -> None:
        self.gradient = gradient
        self._matrix = matrix

    @abstractmethod
    def _solution(self, damping: float) -> Array | None:
        """The d that solves (M + damping · I) d = −g; None where that matrix is not positive definite."""

    def step(self, damping: float) -> tuple[Array, float]:
        """What solves (M + damping · I) d = −g; damping grows until it is positive definite. No step where there is
        none, as the numbers are not finite."""
        while damping < NO_STEP:
            found = self._solution(damping)
            if found is not None:
                return found, damping
            damping = max(10.0 * damping, 1e-6)
        return np.zeros_like(self.gradient), damping


class BandedSystem(System):
    """Of a matrix whose lower band `(n, width)` is given."""

    def _solution(self, damping: float) -> Array | None:
        damped = self._matrix.copy()
        damped[:, 0] += damping
        factor = factored(damped)
        return None if factor is None else solved(factor, -self.gradient)


class DenseSystem(System):
    """Of a matrix `(n, n)`."""

    def _solution(self, damping: float) -> Array | None:
        damped = self._matrix.copy()
        damped.ravel()[:: len(damped) + 1] += damping
        return solved_dense(damped, -self.gradient)
