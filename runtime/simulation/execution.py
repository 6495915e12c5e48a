"""Carries a task or a plan out: run, verify, and follow it with simulated drives."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from ...compiler import ir
from ...langs.diagnostics import Diagnostic, Error
from ..budget import SECONDS_OF_RUN, Budget, Status, unless_spent
from ..engine.actor import Simulated
from ..plan import Plan
from ..planner.conflicts.infeasibility import distrust, unverified
from ..planner.lgp import options_of
from ..skeleton import Bound
from ..verify import verify
from .actuators import Noise
from .plan_import import window_of
from .results import RunOptions, RunProgress
from .run import Run
from .run_at_once import RunAtOnce, goes_at_once
from .settings import SIMULATION
from .tracking import Deviations, deviations, follow


class StillOnly(Error):
    """A scene in which things move by themselves, or modules fail, has no physics."""

    def __init__(self) -> None:
        super().__init__("things that move by themselves, and modules that fail, are not carried out by an engine")


NOTHING_FOLLOWED = Deviations((), 0.0, "", None, ())


def execute(
    problem: ir.Problem, plan: Plan | None, horizon: int | str | None, noise: Noise | None, seconds: float | None,
    seed: int, latency: float | None, tell: Callable[[RunProgress], None] | None, engine: str | None = None,
    minimise: str | None = None,
) -> tuple[Status, Plan, tuple[Diagnostic, ...], Deviations, Simulated | None]:  # fmt: skip
    """Status, record, explanation, deviations, and what a physics `engine` found; `minimise` is what plans are to be
    best at (None: what the task says). A plan that tells of the world as it
    moves, or whose scene rests, is followed as it is; else, and in an engine, it is the first window of a run. Raises
    MissingLibrary, StillOnly, UsageError."""
    if engine is not None and (problem.world.courses or problem.world.breakdowns):
        raise StillOnly
    noise = noise or Noise()
    moves = problem.world.courses or problem.world.breakdowns
    if engine is None and plan is not None and (plan.courses or plan.breakdowns or not moves):
        given = plan
        verdict = unless_spent(lambda: verify(given, Budget(seconds)))
        plan = msgspec.structs.replace(plan, verdict=verdict)
        if plan.verdict is None:
            return Status.BUDGET, plan, (unverified(),), NOTHING_FOLLOWED, None
        if not plan.verdict.verified:
            return Status.REFUSED, plan, tuple(distrust(plan.verdict)), NOTHING_FOLLOWED, None
        if plan.verdict.goal_reached:
            return Status.SOLVED, plan, (), follow(plan, problem, noise, seed), None
        short = Diagnostic("S0002", f"the plan does not reach the goal: {', '.join(plan.verdict.unmet)}")
        return Status.STUCK, plan, (short,), follow(plan, problem, noise, seed), None
    bound = Bound.PATH if problem.options.bound == Bound.SEQ else None
    options = options_of(problem, {"bound": bound, "time": seconds, "minimise": minimise}, SECONDS_OF_RUN)
    delay = SIMULATION.latency if latency is None else latency
    chosen = SIMULATION.horizon if horizon is None else None if horizon == "auto" else int(horizon)
    first = None if plan is None else window_of(problem, plan)
    wanted = RunOptions(options, chosen, noise, seed, delay, engine)
    kind = RunAtOnce if goes_at_once(problem, wanted) else Run
    outcome = kind(problem, wanted, tell, first).run()
    off = unless_spent(lambda: deviations(outcome.plan, problem, outcome.commanded, outcome.driven))
    followed = off or NOTHING_FOLLOWED
    return outcome.status, outcome.plan, tuple(outcome.explanation), followed, outcome.carried
