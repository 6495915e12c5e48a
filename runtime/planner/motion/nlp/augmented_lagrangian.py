"""Augmented-Lagrangian Gauss-Newton on banded or dense normal equations (thesis section 3.2; Toussaint 2014, "A novel
augmented Lagrangian approach for inequalities and convergent any-time non-central updates")."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from .....langs.frozen import dataclass
from ....budget import Budget
from ....skeleton import Array
from .program import Program
from .settings import SOLVER


@dataclass(frozen=True, slots=True)
class SolverOptions:
    """`mu` is the first penalty weight; the run stops once the scaled violation is below `tolerance` and the step
    below `step_tolerance`, or after `stall` iterations without progress. What violates by less than `projected` is
    projected onto the rows, where that is possible. Damping is Levenberg-Marquardt. A `persistent` run goes on where no
    step promises much or the largest weight leaves much, as it does where rows weigh unlike each other."""

    mu: float = 1e2
    largest_mu: float = 1e7
    growth: float = 3.0
    damping: float = 1.0
    least_damping: float = 1e-7
    tolerance: float = 1e-4
    step_tolerance: float = 1e-2
    largest_step: float = 0.3
    inner_tolerance: float = 1e-2
    iterations: int = 150
    stall: int = 20
    projected: float = 0.0
    persistent: bool = False


PATH = SolverOptions(mu=1e3, tolerance=1e-3)


class SolverStatus(StrEnum):
    """Why a solver ended: all rows hold; no step is worth taking; as many iterations as it may take."""

    FEASIBLE = "feasible"
    STALLED = "stalled"
    ITERATIONS = "iterations"


@dataclass(frozen=True, slots=True)
class SolverResult:
    """The last iterate `x`, iterations taken, and why it ended."""

    x: Array
    iterations: int
    status: SolverStatus


def _merit(residuals: tuple[Array, Array, Array], multipliers: tuple[Array, Array], mu: float) -> float:
    cost, equality, inequality = residuals
    pulled = equality + multipliers[0] / mu
    pushed = np.maximum(inequality + multipliers[1] / mu, 0.0)
    return 0.5 * float(cost @ cost) + 0.5 * mu * float(pulled @ pulled + pushed @ pushed)


def _violation(residuals: tuple[Array, Array, Array]) -> float:
    """The largest violation; infinite where one is no number, which no comparison would tell."""
    _, equality, inequality = residuals
    worst, other = float(np.abs(equality).max(initial=0.0)), float(inequality.max(initial=0.0))
    return max(worst, other) if worst < np.inf and other < np.inf else float("inf")


class _Descent:
    """State of one run: iterate, residuals, multipliers, penalty weight, damping."""

    def __init__(self, program: Program, start: Array, options: SolverOptions) -> None:
        self.program = program
        self.options = options
        self.x = start.copy()
        self.residuals = program.residuals(self.x)
        self.multipliers = (np.zeros_like(self.residuals[1]), np.zeros_like(self.residuals[2]))
        self.mu = options.mu
        self.damping = options.damping
        self.last = np.inf

    def step(self) -> float:
        """One accepted Gauss-Newton step; its largest component, or 0 when none was accepted."""
        merit = _merit(self.residuals, self.multipliers, self.mu)
        system = self.program.system(self.x, self.residuals, self.multipliers, self.mu)
        for _ in range(8):
            direction, self.damping = system.step(self.damping)
            largest = float(np.abs(direction).max(initial=0.0))
            length = min(1.0, self.options.largest_step / largest) if largest > 0 else 1.0
            slope = float(system.gradient @ direction)
            predicted = length * slope - 0.5 * length**2 * (slope + self.damping * float(direction @ direction))
            trial = self.x + length * direction
            residuals = self.program.residuals(trial)
            change = _merit(residuals, self.multipliers, self.mu) - merit
            ratio = change / predicted if predicted < 0 else -1.0
            if ratio > 0.05 or abs(change) <= 1e-10 * abs(merit) + 1e-14:
                self.x, self.residuals = trial, residuals
                self._relax(ratio, length)
                return length * largest
            self.damping = max(6.0 * self.damping, 1e-4)
        return 0.0

    def _relax(self, ratio: float, length: float) -> None:
        if ratio > 0.7:
            self.damping = max(0.2 * self.damping, self.options.least_damping)
        elif ratio < 0.25:
            self.damping *= 3.0
        if length < 1.0:
            self.damping = 1.5 * max(self.damping, 1e-3)

    def update_multipliers(self, violation: float) -> None:
        _, equality, inequality = self.residuals
        self.multipliers = (
            self.multipliers[0] + self.mu * equality,
            np.maximum(self.multipliers[1] + self.mu * inequality, 0.0),
        )
        if violation > 0.25 * self.last:
            self.mu = min(self.mu * self.options.growth, self.options.largest_mu)
        self.last = violation


def _promise(program: Program, x: Array, residuals: tuple[Array, Array, Array]) -> float:
    """The share of the squared violation that a damped step on violated rows alone would take away, to first order,
    where some are."""
    system = program.violated(x, residuals)
    missed = np.concatenate([residuals[1], np.maximum(residuals[2], 0.0)])
    return -float(system.gradient @ system.step(SOLVER.promise_damping)[0]) / float(missed @ missed)


def solve(program: Program, start: Array, options: SolverOptions, budget: Budget) -> SolverResult:
    """Minimise `program` from `start`. Stops feasible, not at an optimum. Raises OutOfTime."""
    run = _Descent(program, start, options)
    best, best_at = np.inf, 0
    near, poor = options.projected, 0
    for iteration in range(options.iterations):
        budget.check()
        step = run.step()
        violation = _violation(run.residuals)
        if violation < options.tolerance and step < options.step_tolerance:
            return SolverResult(run.x, iteration + 1, SolverStatus.FEASIBLE)
        if violation < 0.9 * best:
            best, best_at = violation, iteration
        if iteration - best_at > options.stall and best > SOLVER.hopeless:
            return SolverResult(run.x, iteration + 1, SolverStatus.STALLED)
        if run.mu >= options.largest_mu and violation > SOLVER.pressed and not options.persistent:
            return SolverResult(run.x, iteration + 1, SolverStatus.STALLED)
        if iteration % SOLVER.promise_period == 0 and not options.persistent:
            slow = violation > SOLVER.hopeless and step < SOLVER.promise_step
            poor = poor + 1 if slow and _promise(program, run.x, run.residuals) < SOLVER.promise else 0
            if poor == SOLVER.promises:
                return SolverResult(run.x, iteration + 1, SolverStatus.STALLED)
        if violation < near and step < SOLVER.settled * options.inner_tolerance:
            x = project(program, run.x, options.tolerance, budget, SOLVER.projections)
            if _violation(program.residuals(x)) < options.tolerance:
                return SolverResult(x, iteration + 1, SolverStatus.FEASIBLE)
            near = SOLVER.nearer * violation
        if step < options.inner_tolerance:
            run.update_multipliers(violation)
    return SolverResult(run.x, options.iterations, SolverStatus.ITERATIONS)


def project(program: Program, start: Array, tolerance: float, budget: Budget, iterations: int = 12) -> Array:
    """The nearest point, to first order, whose constraints hold within `tolerance`: Gauss-Newton on equalities and
    violated inequalities alone, with damping that vanishes with the violation. It ends where `SOLVER.projections` steps
    have not halved what is violated."""
    x = start
    best, least = x, np.inf
    seen: list[float] = []
    for _ in range(iterations):
        budget.check()
        residuals = program.residuals(x)
        violation = _violation(residuals)
        if violation < least:
            best, least = x, violation
        seen.append(violation)
        if violation < tolerance or violation > 0.5 * min(seen[: -SOLVER.projections], default=np.inf):
            break
        direction, _ = program.violated(x, residuals).step(max(1e-8, min(1e-2, 1e-2 * violation)))
        largest = float(np.abs(direction).max(initial=0.0))
        x = x + direction * min(1.0, 0.1 / largest if largest > 0 else 1.0)
    return best
