"""One window of a run: the way to the goal, and motion for its first actions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...compiler import ir
from ..budget import Budget
from ..lgp import SolveOptions, motion_settings
from ..motion.movement import carrier
from ..motion.path import solve_path
from ..motion.phases import UnsupportedPhase, solve_sequence_path
from ..motion.sequence import solve_sequence
from ..motion.settings import MotionSettings
from ..refusals import Refusals
from ..skeleton import BoundResult, PhasePath, Skeleton, beginning
from ..verify.formulas import ReplayError
from ..verify.replay import Interpreter
from .foresight import concerned
from .state import start
from .windows import PLANNED, plan_window, remember

SHORTER = ((2, -0.005), (2, -0.01))
"""After a first try while things move: so many actions, as what comes later may be in reach by then, and so
many metres added to margins, as a robot that stands a little off may be nearer to things than it should."""
FRESH = 100
"""Between the seeds of one failure and the next."""


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
    """Plans windows for one run. `status` says, after no way was found, why: "stuck" or "infeasible"; `refusals`
    explain it. `failures` counts windows that were not found, one after the other: the next tries are others.
    `blamed` maps bodies that were in the way of the first phase of the last one to the modules that they stopped."""

    def __init__(self, options: SolveOptions) -> None:
        self.options = options
        self.status = "running"
        self.failures = 0
        self.blamed: dict[str, str] = {}
        self.refusals: Refusals | None = None

    def known_way(
        self, problem: ir.Problem, actions: Sequence[ir.Action], horizon: int, moving: frozenset[str], wider: float,
        budget: Budget,
    ) -> Window | None:  # fmt: skip
        """A window on a way that is known, without a search; None when it is not possible so. Raises OutOfTime."""
        skeleton = _replayed(problem, actions[:horizon])
        if skeleton is None:
            return None
        moving = concerned(skeleton, moving)
        motions = 1 if moving else horizon
        shorter = [(min(horizon, count), margin) for count, margin in SHORTER]
        shorter += [(1, SHORTER[-1][1])] if self.failures else []
        tries = [(horizon, 0.0), *(shorter if moving else [(horizon, SHORTER[0][1])])]
        for attempt, (count, margin) in enumerate(tries):
            settings = _wider(motion_settings(problem, self.options), wider + margin)
            seed = self.options.seed + FRESH * self.failures + attempt
            found = _motions(beginning(skeleton, count), motions, settings, seed, budget)
            if found.feasible:
                return Window(problem, tuple(actions), skeleton, found.paths, moving)
            self.blamed = _in_the_way(problem, found)
        return None

    def new_way(
        self, problem: ir.Problem, previous: ir.Action | None, horizon: int, moving: frozenset[str], wider: float,
        budget: Budget,
    ) -> Window | None:  # fmt: skip
        """Search a way to the goal of which the first `horizon` actions have motions. Raises OutOfTime."""
        memory = remember(problem, self.options, budget)
        memory.bounds.settings = _wider(memory.bounds.settings, wider + (SHORTER[-1][1] if moving else 0.0))
        begin = replace(start(problem), previous=previous)
        if moving:
            beyond = 0 if self.failures else 1
            found = plan_window(problem, begin, self.options, SHORTER[0][0], budget, memory, lookahead=beyond)
        else:
            found = plan_window(problem, begin, self.options, horizon, budget, memory)
        if found.status != PLANNED:
            self.status, self.refusals = found.status, memory.refusals
            return None
        moving = concerned(found.skeleton, moving)
        paths = list(found.paths[: 1 if moving else horizon])
        return Window(problem, found.actions, found.skeleton, paths, moving)


def _wider(settings: MotionSettings, by: float) -> MotionSettings:
    return replace(settings, margin=settings.margin + by, switch_margin=settings.switch_margin + by)


def _replayed(problem: ir.Problem, actions: Sequence[ir.Action]) -> Skeleton | None:
    """The skeleton of actions, by a plain replay; None when one of them cannot be done."""
    from ..skeleton import Phase

    interpreter = Interpreter(problem)
    facts, mode = problem.init, interpreter.canonical(problem.init_motion)
    previous: ir.Action | None = None
    phases = []
    for action in actions:
        try:
            outcome = interpreter.apply(facts, mode, action, previous)
        except ReplayError:
            return None
        phases.append(Phase(action, mode, outcome.added_motion))
        facts, mode, previous = outcome.facts, outcome.motion, action
    return Skeleton(problem, tuple(phases), mode)


def _motions(
    skeleton: Skeleton, motions: int, settings: MotionSettings, seed: int, budget: Budget
) -> BoundResult:
    """Switches of the whole skeleton, then motions of its first phases."""
    sequence = solve_sequence(skeleton, settings, seed, budget)
    if not sequence.feasible:
        return sequence
    first = beginning(skeleton, motions)
    switches = sequence.configurations[: len(first) + 1]
    try:
        return solve_sequence_path(first, switches, settings, seed, budget)
    except UnsupportedPhase:
        cut = replace(sequence, configurations=switches)
        return solve_path(first, settings, seed, budget, cut, pinned=True)


def _in_the_way(problem: ir.Problem, refused: BoundResult) -> dict[str, str]:
    """Bodies that the first phase collides with, and the module that does."""
    found = {}
    for violation in refused.violations:
        if violation.literal[0] == "collision" and violation.phase == 0:
            _, *pair = violation.literal
            for body, other in (pair, pair[::-1]):
                module = carrier(problem, other)
                if body in problem.world.bodies and module in problem.world.modules:
                    found[body] = module
    return found
