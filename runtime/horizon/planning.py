"""One window of a run: the way to the goal, and motion for its first actions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...compiler import ir
from ...compiler.symbolic.successors import Successors
from ..bounds import Bounds
from ..budget import Budget
from ..lgp import SolveOptions, motion_settings
from ..motion.path import solve_path
from ..motion.phases import UnsupportedPhase, solve_sequence_path
from ..motion.sequence import solve_sequence
from ..motion.settings import MotionSettings
from ..refusals import Refusals
from ..search.best_first import SkeletonSearch
from ..search.roomy import Strain, roomier
from ..search.skeletons import build_skeleton
from ..skeleton import PhasePath, Skeleton
from ..verify.formulas import ReplayError
from ..verify.replay import Interpreter
from .foresight import concerned

TRIES = 2
"""Seeds with which the motion of a known way is tried before another way is searched."""


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
    """Plans windows for one run. `status` says, after a window was not found, why: "infeasible", "exhausted" or
    "budget"; `refusals` explain it."""

    def __init__(self, options: SolveOptions) -> None:
        self.options = options
        self.status = "running"
        self.refusals: Refusals | None = None

    def known_way(
        self, problem: ir.Problem, actions: Sequence[ir.Action], horizon: int, moving: frozenset[str], wider: float,
        budget: Budget,
    ) -> Window | None:  # fmt: skip
        """A window on a way that is known, without a search; None when it is not possible so. Raises OutOfTime."""
        skeleton = _replayed(problem, actions[:horizon])
        if skeleton is None:
            return None
        settings = _wider(motion_settings(problem, self.options), wider)
        moving = concerned(skeleton, moving)
        motions = 1 if moving else horizon
        for attempt in range(TRIES):
            paths = _motions(skeleton, motions, settings, self.options.seed + attempt, budget)
            if paths is not None:
                return Window(problem, tuple(actions), skeleton, paths, moving)
        return None

    def new_way(
        self, problem: ir.Problem, horizon: int, moving: frozenset[str], wider: float, budget: Budget
    ) -> Window | None:
        """Search a way to the goal of which the first `horizon` actions have motions. Raises OutOfTime."""
        successors = Successors(problem)
        search = SkeletonSearch(problem, successors, self.options.search, budget, self.options.nodes)
        strain = Strain(successors)
        settings = _wider(motion_settings(problem, self.options), wider)
        bounds = Bounds(problem, settings, self.options.bound, self.options.seed, budget, lambda *_: None)
        self.refusals = Refusals(problem)
        while True:
            candidate = search.next()
            if candidate is None:
                self.status = search.status
                return None
            candidate = roomier(search, strain, candidate)
            skeleton = _first(build_skeleton(problem, candidate.actions, successors), horizon)
            judgement = bounds.judge(skeleton, strain.along(candidate.numbers)[:horizon])
            if judgement.accepted:
                moving = concerned(skeleton, moving)
                paths = (judgement.paths or [])[: 1 if moving else horizon]
                return Window(problem, tuple(candidate.actions), skeleton, paths, moving)
            for conflict in judgement.conflicts:
                self.refusals.add(skeleton, conflict)
                search.forbid_actions(candidate, conflict.first, conflict.last, conflict.from_start)


def _wider(settings: MotionSettings, by: float) -> MotionSettings:
    return replace(settings, margin=settings.margin + by, switch_margin=settings.switch_margin + by)


def _first(skeleton: Skeleton, count: int) -> Skeleton:
    """The first `count` phases of a skeleton."""
    if len(skeleton) <= count:
        return skeleton
    return replace(skeleton, phases=skeleton.phases[:count], final_mode=skeleton.phases[count].mode)


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
) -> list[PhasePath] | None:
    """Switches of the whole skeleton, then motions of its first phases; None when there are none."""
    sequence = solve_sequence(skeleton, settings, seed, budget)
    if not sequence.feasible:
        return None
    first = _first(skeleton, motions)
    switches = sequence.configurations[: len(first) + 1]
    try:
        found = solve_sequence_path(first, switches, settings, seed, budget)
    except UnsupportedPhase:
        cut = replace(sequence, configurations=switches)
        found = solve_path(first, settings, seed, budget, cut, pinned=True)
    return found.paths if found.feasible else None
