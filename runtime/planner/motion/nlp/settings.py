"""The numbers that steer the solvers."""

from __future__ import annotations

from dataclasses import dataclass

from .....compiler.settings import setting


@dataclass(frozen=True)
class SolverSettings:
    """The numbers that steer the solvers."""

    hopeless: float = setting(4e-3, "m or rad", "A run that stalls above this violation will not become feasible.")
    nearly: float = setting(
        2e-2, "m or rad",
        "What a run leaves violated by less is projected onto its rows before it counts as refused. Seen to succeed"
        " from up to 17 mm: an arm of four joints at the ends of their ranges, 12 of 12 seeds in half the time instead"
        " of 11. Never seen from more.",
    )
    load_difference: float = setting(
        1e-6, "m or rad", "By how much poses and joints are varied to see how fast loads in closed loops change."
    )
    ipopt_iterations: int = setting(300, "iterations", "The most that IPOPT takes.")
    limit_wish: float = setting(
        3.0, "1", "The scale of the wish to keep away from joint limits.",
        "against homing at 0.1 it is then missed by a thousandth",
    )
    batched_products: int = setting(
        100_000, "products",
        "Of a group with no more products of rows, all their places are found at once.",
    )



SOLVER = SolverSettings()
