"""The numbers that steer the solvers."""

from __future__ import annotations

from .....compiler.settings import setting
from .....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class SolverSettings:
    """The numbers that steer the solvers."""

    hopeless: float = setting(4e-3, "m or rad", "A run that stalls above this violation will not become feasible.")
    promise: float = setting(
        0.1, "1",
        "A run is given up where a step on its violated rows alone would take away no more of the squared violation, "
        "to first order …",
        "263 runs of nine examples and of an arm at the ends of its ranges take 7,200 steps so instead of 9,000, and "
        "all 166 that become feasible still do; without a bound on what one step may change, 0.1 saves a tenth",
    )
    promises: int = setting(2, "looks", "… so often, one look after the other.", "with one, some become feasible still")
    promise_period: int = setting(3, "iterations", "How often it is looked at.")
    promise_step: float = setting(0.1, "rad or m", "What moves by more in an iteration goes on.")
    promise_damping: float = setting(
        1e-2, "1", "What is added to the squares of the rows: it leaves out what only long ways would change."
    )
    pressed: float = setting(
        4e-2, "m or rad", "What the largest weight leaves violated by more is given up.",
        "rendezvous n=4 takes 17 % fewer steps so, in seeds 3 to 9, and 49 solves of seven tasks are as good; with "
        "2e-2, 2 of 880 runs that become feasible are lost, and real_choice takes half as long again",
    )
    nearly: float = setting(
        2e-2, "m or rad",
        "What a run leaves violated by less is projected onto its rows before it counts as refused. Seen to succeed"
        " from up to 17 mm: an arm of four joints at the ends of their ranges, 12 of 12 seeds in half the time instead"
        " of 11. Never seen from more.",
    )
    load_difference: float = setting(
        1e-6, "m or rad", "By how much poses and joints are varied to see how fast loads in closed loops change."
    )
    projections: int = setting(
        4, "iterations",
        "Within so many a point that is nearly feasible is projected, or the run goes on.",
        "from 2 cm it takes two or three",
    )
    settled: float = setting(
        3.0, "1",
        "How many times the step is allowed for that after which rows are weighted more: wishes have their say first.",
        "without a bound two tests met joints at their limits; how often is not measured",
    )
    nearer: float = setting(
        0.25, "1",
        "The share of its violation to which a run has to come before it is projected once more.",
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
    dense: int = setting(
        160, "unknowns",
        "A program with no more unknowns holds its rows as one dense matrix, a larger one adds up a band.",
        "the solves of climb n=12 and pick_and_place objects=8 take 0.22 and 0.34 CPU s so, with 60 unknowns 0.25 and "
        "0.44, with 400 0.25 and 0.37",
    )


SOLVER = SolverSettings()
