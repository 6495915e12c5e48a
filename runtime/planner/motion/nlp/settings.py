"""The numbers that steer the solvers."""

from __future__ import annotations

from dataclasses import dataclass

from .....compiler.settings import setting


@dataclass(frozen=True)
class SolverSettings:
    """The numbers that steer the solvers."""

    hopeless: float = setting(4e-3, "m or rad", "A run that stalls above this violation will not become feasible.")


SOLVER = SolverSettings()
