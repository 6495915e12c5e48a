"""One window of a run: the way to the goal, and motion for its first actions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from ...compiler import ir
from ...langs.frozen import dataclass
from ..budget import Budget
from ..geometry.attachments import carrier
from ..planner.bounds.length_unit import LengthUnit
from ..planner.bounds.requests import sequence_path
from ..planner.conflicts.infeasibility import Refusals
from ..planner.lgp import SolveOptions, motion_settings
from ..planner.motion.end_conditions import eased
from ..planner.motion.keyframes.sequence import solve_sequence
from ..planner.motion.settings import MotionSettings
from ..planner.receding.mid_run_state import start
from ..planner.receding.settings import RECEDING
from ..planner.receding.window import WindowStatus, plan_window, remember
from ..planner.search.stepper import Inapplicable, Stepper
from ..seeds import Seed
from ..skeleton import BoundResult, Breach, Phase, PhasePath, Skeleton, beginning
from .scene_prediction import concerned
from .settings import SIMULATION

Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class Window:
    """`actions` lead to the goal as it is seen now; `skeleton` holds the first of them, `paths` the motions of the
    first of these. `problem` is the scene that it was planned in, begun from the state reached; `moving` are the bodies
    that its phases come near and that move: then only the first phase has a motion."""

    problem: ir.Problem
    actions: tuple[ir.Action, ...]
    skeleton: Skeleton
    paths: list[PhasePath]
    moving: frozenset[str]


class Planner:
    """Plans windows for one run. `status` says, after no way was found, why; `refusals`
    explain it. `failures` counts windows that were not found, one after the other: the next tries are others, and
    `redraws` those among them after which nothing else could be done. `hasty` searches judge few ways. `returns` says
    how often the run has been in the present state before: the more often, the farther P_seq looks. `blamed` maps
    bodies that were in the way of the first phase of the last one to the modules that they stopped."""

    def __init__(self, options: SolveOptions) -> None:
        self.options = options
        self.status: WindowStatus | None = None
        self.failures = self.redraws = 0
        self.returns = 0
        self.hasty = False
        self.blamed: dict[str, str] = {}
        self.refusals: Refusals | None = None

    def succeeded(self) -> None:
        """A window was found: the next failure is a first one."""
        self.failures = self.redraws = 0

    def may_redraw(self) -> bool:
        """Whether a window that was not found is to be drawn anew, with other numbers."""
        if self.status == WindowStatus.INFEASIBLE or self.redraws == SIMULATION.redraws:
            return False
        self.redraws += 1
        self.failures += 1
        return True

    def known_way(
        self, problem: ir.Problem, actions: Sequence[ir.Action], horizon: int, moving: frozenset[str], wider: float,
        budget: Budget,
    ) -> Window | None:  # fmt: skip
        """A window on a way that is known, without a search; None when it is not possible so. Raises OutOfTime."""
        skeleton = self.skeleton(problem, actions[: horizon + RECEDING.lookahead + self.returns * SIMULATION.farther])
        if skeleton is None:
            return None
        moving = concerned(beginning(skeleton, horizon), moving)
        motions = 1 if moving else horizon
        far = horizon + self.returns * SIMULATION.farther
        shorter = [(far if self.returns else min(horizon, count), margin) for count, margin in SIMULATION.shorter]
        shorter += [(1, SIMULATION.shorter[-1][1])] if self.failures and not self.returns else []
        seen = far if moving else horizon + RECEDING.lookahead
        tries = [(seen, 0.0), *(shorter if moving else [(horizon, SIMULATION.shorter[0][1])])]
        for attempt, (count, margin) in enumerate(tries):
            settings = motion_settings(problem, self.options).wider(wider + margin)
            seed = Seed(self.options.seed).child("failures", self.failures, attempt)
            found = _motions(beginning(skeleton, count), motions, settings, seed, budget)
            if found.feasible:
                return Window(problem, tuple(actions), skeleton, eased(problem.world, found.paths), moving)
            self.blamed = _in_the_way(problem, found)
        return None

    def skeleton(self, problem: ir.Problem, actions: Sequence[ir.Action]) -> Skeleton | None:
        """The skeleton of actions; None when one of them cannot be done."""
        try:
            return replayed(problem, actions, lambda stepper, facts, action: action)
        except Inapplicable:
            return None

    def new_way(
        self, problem: ir.Problem, horizon: int, moving: frozenset[str], wider: float, budget: Budget
    ) -> Window | None:
        """Search a way to the goal of which the first `horizon` actions have motions. Raises OutOfTime."""
        short = bool(self.failures) and not self.returns
        seen = RECEDING.lookahead if not moving else SIMULATION.farther * self.returns + (0 if short else 1)
        memory = remember(problem, self.options, budget)
        memory.bounds.settings = memory.bounds.settings.wider(wider + (SIMULATION.shorter[-1][1] if moving else 0.0))
        count = SIMULATION.shorter[0][0] if moving else horizon
        found = plan_window(
            problem, start(problem), self.options, count, budget, memory, lookahead=seen,
            seed=Seed(self.options.seed).child("search", self.failures),
            candidates=SIMULATION.hasty_candidates if self.hasty else RECEDING.candidates,
        )  # fmt: skip
        if found.status != WindowStatus.PLANNED:
            self.status, self.refusals = found.status, memory.refusals
            return None
        moving = concerned(found.skeleton, moving)
        paths = list(found.paths[: 1 if moving else horizon])
        return Window(problem, found.actions, found.skeleton, paths, moving)


def replayed(
    problem: ir.Problem, items: Iterable[Item], action_of: Callable[[Stepper, frozenset[ir.Fact], Item], ir.Action]
) -> Skeleton:
    """The skeleton of actions; `action_of` tells the action that an item is in a state. Raises Inapplicable when one of
    them cannot be done."""
    stepper = Stepper(problem)
    facts, mode = problem.init, stepper.canonical(problem.init_motion)
    phases = []
    for item in items:
        action = action_of(stepper, facts, item)
        step = stepper.step(facts, mode, action)
        phases.append(Phase(action, mode, step.added))
        facts, mode = step.facts, step.motion
    return Skeleton(problem, tuple(phases), mode)


def _motions(
    skeleton: Skeleton, motions: int, settings: MotionSettings, seed: Seed, budget: Budget
) -> BoundResult:
    """Switches of the whole skeleton, then motions of its first phases."""
    unit = LengthUnit(skeleton.problem)
    skeleton = unit.skeleton(skeleton)
    sequence = solve_sequence(skeleton, settings, seed, budget)
    if not sequence.feasible:
        return unit.result(sequence)
    first = beginning(skeleton, motions)
    cut = replace(sequence, configurations=sequence.configurations[: len(first) + 1])
    return unit.result(sequence_path(first, cut, settings, seed, budget))


def _in_the_way(problem: ir.Problem, refused: BoundResult) -> dict[str, str]:
    """Bodies that the first phase collides with, and the module that does."""
    found = {}
    for violation in refused.violations:
        if violation.kind == Breach.COLLISION and violation.phase == 0:
            pair = violation.names
            for body, other in (pair, pair[::-1]):
                module = carrier(problem, other)
                if body in problem.world.bodies and module in problem.world.modules:
                    found[body] = module
    return found
