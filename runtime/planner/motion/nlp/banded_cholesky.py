"""Cholesky factors of banded matrices, and systems with dense ones, by LAPACK.

The routines are SciPy's, taken from its compiled module alone: `scipy.linalg` around it takes longer to import than a
short task takes to solve, and SciPy itself a twentieth of that.
"""

from __future__ import annotations

from typing import Any

from ....native import load_part
from ....skeleton import Array


def _routines() -> Any:
    part = load_part("scipy", "linalg._flapack")
    if part is not None:
        return part
    from scipy.linalg import lapack

    return lapack


_LAPACK = _routines()


def factored(band: Array) -> Array | None:
    """The Cholesky factor of a symmetric matrix whose lower band is `band` `(n, width)`, which is overwritten; None
    where it is not positive definite."""
    factor, failed = _LAPACK.dpbtrf(band.T, lower=1, overwrite_ab=1)
    return None if failed else factor


def solved(factor: Array, right: Array) -> Array:
    """The solution `(n,)` of a system whose matrix has this factor."""
    solution: Array = _LAPACK.dpbtrs(factor, right, lower=1)[0]
    return solution


def solved_dense(matrix: Array, right: Array) -> Array | None:
    """The solution `(n,)` of a system with a symmetric `matrix` `(n, n)`, which is overwritten; None where it is not
    positive definite."""
    if not len(right):
        return right
    _, solution, failed = _LAPACK.dposv(matrix.T, right, lower=1, overwrite_a=1)
    return None if failed else solution
