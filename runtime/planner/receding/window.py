"""One window of a receding horizon (thesis, section 3.5): actions to the goal, motion for the first of them.

`plan_window` looks for actions from the reached state to the goal, or to its next parts where that is long, and judges
the motion of the first `horizon` of them. P_seq looks some phases farther ahead, so that a window seldom ends where it
cannot go on. Conditions that measure the scene are read as it is when the window is planned; assembler and verifier do
the same at every window.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from enum import StrEnum
from functools import partial

from ....compiler import ir
from ....compiler.symbolic.successors import Successors
from ....langs.frozen import dataclass
from ...budget import Budget, OutOfTime, Status
from ...plan import SearchNode
from ...seeds import Seed
from ...skeleton import Bound, Configuration, PhasePath, Skeleton, beginning
from ..bounds.multi_bound import MultiBound
from ..bounds.verdicts import Judgement
from ..candidate_loop import CandidateLoop
from ..conflicts.infeasibility import Refusals
from ..lgp import SolveOptions, motion_settings
from ..schedule.clocked_search import ClockedSearch, Clocks, Pace, clocks_along
from ..search.best_first import Candidate, SkeletonSearch
from ..search.learned_penalties import LearnedPenalties
from ..search.skeleton_replay import build_skeleton
from .mid_run_state import Reached, after, reached_problem
from .settings import RECEDING
from .subgoals import ordered, parts_of, told, unmet


class WindowStatus(StrEnum):
    """Done: the goal holds; stuck: every way was refused; infeasible: proved that no actions lead to the goal."""

    PLANNED = "planned"
    DONE = "done"
    STUCK = "stuck"
    INFEASIBLE = "infeasible"


@dataclass(frozen=True, slots=True)
class Window:
    """What planning from one state gave. `actions` is the way to the goal, or to
    its next parts, as seen now; `skeleton`, which begins at `problem`, and `paths` are its first `len(paths)` phases;
    `reached` is the state after them. `unmet` tells the parts of the goal that do not hold at the start of the window,
    in the order in which they are planned for; `cost` is that of the phases with motion; `refused` counts refused
    candidates, `tree` holds the nodes of the last search."""

    status: WindowStatus
    problem: ir.Problem
    actions: tuple[ir.Action, ...]
    skeleton: Skeleton
    paths: tuple[PhasePath, ...]
    reached: Reached
    seconds: float
    unmet: tuple[str, ...]
    refused: int
    cost: float = 0.0
    tree_nodes: int = 0
    expanded_nodes: int = 0
    tree: tuple[SearchNode, ...] = ()
    ahead: tuple[Configuration, ...] = ()
    """The switches behind those of `paths`, as far as P_seq looked."""
    clocks: Clocks = ()
    """Where seconds count, when modules are done with the motions so far, those of other windows included."""

    @property
    def rest(self) -> tuple[ir.Action, ...]:
        """The way on, as seen now."""
        return self.actions[len(self.paths) :]


@dataclass(slots=True)
class Memory:
    """What windows hand on to later ones; of a size that does not grow with the number of windows."""

    bounds: MultiBound
    refusals: Refusals
    order: list[ir.Formula] = field(default_factory=list)
    """The parts of the goal, in the order in which they should be reached."""
    penalties: LearnedPenalties | None = None
    """How close to their limits actions were refused so far."""
    seconds: dict[str, float] = field(default_factory=dict)
    """The least of each rule's motions so far."""
    group: int = 1
    """How many parts of the goal make a plan that is long enough."""


def remember(
    problem: ir.Problem, options: SolveOptions, budget: Budget, tell: Callable[[str, str], None] | None = None
) -> Memory:
    """The memory of a new run. Make a new one when a module has failed: what motion can do is another thing then."""
    told_to = tell or (lambda stage, message: None)
    settings = motion_settings(problem, options)
    options.ahead.prepare(problem)
    bounds = MultiBound(problem, settings, options.bound, Seed(options.seed), budget, told_to, options.ahead)
    return Memory(bounds, Refusals(problem, bounds.cause))


def plan_window(
    problem: ir.Problem,
    reached: Reached,
    options: SolveOptions,
    horizon: int,
    budget: Budget,
    memory: Memory,
    *,
    seed: Seed | None = None,
    forbidden: Sequence[tuple[ir.Action, ...]] = (),
    lookahead: int = RECEDING.lookahead,
    before: Window | None = None,
    candidates: int = RECEDING.candidates,
    clocks: Clocks = (),
    undoable: bool = False,
) -> Window:
    """Plan from `reached` on: actions that do not begin with one of `forbidden`, motion for the first `horizon` of
    them. `problem` is the task; its own start does not matter. Another `seed` gives other motions. `before` is
    the window that led here, if things went as it said: its way on is tried first. At most so many `candidates` are
    judged for one goal. `clocks` are those at the start. From an `undoable` state motion is soon given up.
    Raises OutOfTime, Inapplicable, MissingLibrary."""
    here = reached_problem(problem, reached)
    memory.bounds.restart(here, Seed(options.seed) if seed is None else seed, budget, undoable)
    planner = _Planner(
        here, reached, options, horizon, budget, memory, tuple(forbidden), lookahead, before, candidates, clocks
    )  # fmt: skip
    return planner.run()


class _Planner:
    """The planning of one window."""

    def __init__(
        self, problem: ir.Problem, reached: Reached, options: SolveOptions, horizon: int, budget: Budget,
        memory: Memory, forbidden: tuple[tuple[ir.Action, ...], ...], lookahead: int, before: Window | None,
        candidates: int, clocks: Clocks,
    ) -> None:  # fmt: skip
        self.problem, self.reached, self.options = problem, reached, options
        self.horizon, self.budget, self.memory = horizon, budget, memory
        self.forbidden = list(forbidden)
        self.lookahead = lookahead
        self.before, self.candidates, self.clocks = before, candidates, clocks
        self.timed = options.minimise.timed and len(problem.world.modules) > 1
        self.asked = False
        self.began = time.monotonic()
        self.refused = self.tree_nodes = self.expanded_nodes = 0
        self.tree: tuple[SearchNode, ...] = ()
        self.proved = False
        self.alike = 0
        self.first: tuple[Candidate, int | None] | None = None
        self.unmet: list[ir.Formula] = []

    def run(self) -> Window:
        if not self.memory.order:
            with self.memory.bounds.clock("compile"):
                self.memory.order = ordered(Successors(self.problem), parts_of(self.problem))
        self.unmet = unmet(self.problem, self.reached.facts, self.memory.order)
        if not self.unmet:
            return self._window(WindowStatus.DONE)
        on = self._go_on()
        if on is not None:
            return on
        for goal, parts in self._goals():
            found = self._try(goal, parts)
            if found is not None:
                return replace(
                    found, tree_nodes=self.tree_nodes, expanded_nodes=self.expanded_nodes, tree=self.tree,
                    seconds=time.monotonic() - self.began,
                )  # fmt: skip
            if self.proved:
                return self._window(WindowStatus.INFEASIBLE)
        return self._window(WindowStatus.STUCK)

    def _go_on(self) -> Window | None:
        """The way that the window before has seen, where that is long enough, from the switches that it expected."""
        before = self.before
        if before is None or not before.rest or not before.ahead:
            return None
        actions = before.rest
        if any(actions[: len(begin)] == begin for begin in self.forbidden):
            return None
        successors = Successors(self.problem)
        numbers = numbers_of(successors, actions)
        long = len(actions) >= self.horizon + self.lookahead
        if numbers is None or not (long or successors.is_goal(end_of(successors, numbers))):
            return None
        seen, count = self._seen(build_skeleton(self.problem, actions, successors))
        judgement = self.memory.bounds.go_on(seen, count, before.ahead)
        if not judgement.accepted:
            return None
        cost = sum(successors.cost(number) for number in numbers[:count])
        return self._planned(actions, cost, beginning(seen, count), judgement)

    def _seen(self, skeleton: Skeleton) -> tuple[Skeleton, int]:
        """The phases that P_seq looks at, and how many of them get their motion."""
        seen = beginning(skeleton, self.horizon + self.lookahead)
        return replace(seen, coming=self._coming()), min(self.horizon, len(skeleton))

    def _goals(self) -> Iterator[tuple[ir.Formula, int]]:
        """What is planned for, and how many unmet parts that are: the whole goal where that is short, else what holds
        already and the next parts of it, in growing groups."""
        count = len(self.unmet)
        if count <= RECEDING.few_parts:
            yield self.problem.goal, count
        size = min(self.memory.group, count)
        while size < count:
            yield self._protected(self.unmet[:size]), size
            size = min(2 * size, count)
        if count > RECEDING.few_parts:
            yield self._protected(self.unmet), count

    def _protected(self, parts: Sequence[ir.Formula]) -> ir.Formula:
        """The parts of the goal that hold, and some that do not yet."""
        held = [part for part in self.memory.order if part not in self.unmet]
        return ir.And((*held, *parts))

    def _try(self, goal: ir.Formula, parts: int) -> Window | None:
        """Candidates for a goal of so many unmet parts until one gets its motion; hurried ones once the cheapest takes
        long."""
        loop = CandidateLoop(
            replace(self.problem, goal=goal), self.options.search, self.budget, self.memory.bounds,
            self.memory.refusals, RECEDING.search_nodes, RECEDING.most_remembered,
        )  # fmt: skip
        search, penalties = loop.search, loop.penalties
        if self.memory.penalties is not None:
            penalties.inherit(self.memory.penalties)
        penalties.weight = max(penalties.weight, RECEDING.least_penalty)
        self.memory.penalties = penalties
        search.charge(penalties)
        for actions in self.forbidden:
            forbid(search, actions)
        self.first, self.alike, self.asked = None, 0, False
        try:
            for candidate in loop.proposals(partial(self._next, search), partial(self._widen, loop), self.candidates):
                found = None
                if self.first is not None and (candidate is None or self.alike >= RECEDING.alike):
                    found = self._once_more(loop, *self.first)
                if candidate is not None and found is None:
                    if self._too_short(candidate, parts):
                        return None
                    found = self._judge(loop, candidate)
                if found is not None:
                    return found
        finally:
            self.tree = tuple(search.tree)
            self.tree_nodes += search.tree_nodes
            self.expanded_nodes += search.expanded_nodes
        return None

    def _next(self, search: SkeletonSearch) -> Candidate | None:
        """The next candidate, if it takes few nodes or the search is hurried already."""
        self.budget.check()
        if self.budget.full:
            raise OutOfTime
        self.memory.bounds.tell("search", f"searching for a way, with {len(self.unmet)} parts of the goal to come")
        quick = self._quick(search)
        if quick is not None:
            return quick
        if search.node_limit != RECEDING.hurried_nodes:
            search.node_limit = search.expanded_nodes + RECEDING.search_nodes
        return search.next()

    def _quick(self, search: SkeletonSearch) -> Candidate | None:
        """Where seconds count, at first what is done soonest, by the clocks and the motions of earlier windows."""
        if not self.timed or self.asked:
            return None
        self.asked = True
        known, weights = self.memory.seconds, dict(self.options.minimise.weights)
        usual = sum(known.values()) / len(known) if known else 1.0
        seconds = {rule: known.get(rule, usual) for rule in self.problem.rules}
        busy = weights.get("duration", 0.0)
        more = {rule: busy * own for rule, own in seconds.items()}
        pace = Pace(seconds, more, weights.get("makespan", 0.0), weights.get("actions", 0.0))
        return ClockedSearch(search, pace).best(most=RECEDING.clocked_nodes, clocks=self.clocks or None).candidate

    def _widen(self, loop: CandidateLoop) -> bool:
        """Let a search that has found nothing go on: hurried, with more nodes; or once with all that was refused
        allowed again, and tried harder. Whether there is more to find."""
        search = loop.search
        if search.status == Status.BUDGET and search.node_limit != RECEDING.hurried_nodes:
            search.node_limit = RECEDING.hurried_nodes
            search.method = "wastar" if search.method == "astar" else search.method
            return True
        self.proved = search.status == Status.INFEASIBLE and not self.forbidden
        return loop.readmit()

    def _once_more(self, loop: CandidateLoop, candidate: Candidate, length: int | None) -> Window | None:
        """The first candidate that was refused from the start only, with more starts of P_seq; or as far as P_seq could
        follow it, where that is beyond the window."""
        self.first, self.alike = None, 0
        seen, count = self._seen(loop.skeleton(candidate))
        judgement = self.memory.bounds.retry(seen if length is None else beginning(seen, length), count)
        return self._accepted(loop, candidate, seen, count, judgement) if judgement.accepted else None

    def _too_short(self, candidate: Candidate, parts: int) -> bool:
        """Whether a plan for some parts of the goal is so short that more parts are planned for."""
        if parts == len(self.unmet) or len(candidate.actions) >= RECEDING.plan_length * self.horizon + self.lookahead:
            return False
        self.memory.group = max(self.memory.group, 2 * parts)
        return True

    def _judge(self, loop: CandidateLoop, candidate: Candidate) -> Window | None:
        seen, count = self._seen(loop.skeleton(candidate))
        judgement = loop.judge(candidate, seen, count)
        if judgement.accepted:
            return self._accepted(loop, candidate, seen, count, judgement)
        self.refused += 1
        expected = all(conflict.bound == Bound.EXPECTED for conflict in judgement.conflicts)
        self.alike = self.alike + 1 if expected else 0
        if self.refused == 1 and all(conflict.from_start and conflict.last for conflict in judgement.conflicts):
            least = min(conflict.last for conflict in judgement.conflicts)
            self.first = candidate, least if least >= count else None
        return None

    def _accepted(
        self, loop: CandidateLoop, candidate: Candidate, seen: Skeleton, count: int, judgement: Judgement
    ) -> Window:
        loop.penalties.accepted(candidate.numbers[:count])
        cost = sum(loop.search.successors.cost(number) for number in candidate.numbers[:count])
        return self._planned(candidate.actions, cost, beginning(seen, count), judgement)

    def _coming(self) -> tuple[tuple[str, str], ...]:
        """Bodies of unmet parts of the goal with what may have to be put down on them."""
        bodies = self.problem.world.bodies
        found = []
        for part in self.unmet:
            if isinstance(part, ir.Literal):
                named = [a.name for a in part.args if isinstance(a, ir.Object) and a.name in bodies]
                still = [n for n in named if not bodies[n].movable]
                found += [(base, thing) for base in still for thing in named if bodies[thing].movable]
        return tuple(found)

    def _planned(
        self, actions: tuple[ir.Action, ...], cost: float, skeleton: Skeleton, judgement: Judgement
    ) -> Window:
        paths = tuple(judgement.paths or ())
        self.memory.bounds.tell("state", "following the motion to its end")
        reached = after(self.problem, skeleton, paths, begin=self.reached)
        plain = self._window(WindowStatus.PLANNED)
        clocks = clocks_along(skeleton, paths, self.clocks) if self.timed else ()
        for phase, path in zip(skeleton.phases, paths, strict=False) if self.timed else ():
            rule = phase.action.rule
            self.memory.seconds[rule] = min(path.duration, self.memory.seconds.get(rule, path.duration))
        return replace(
            plain, clocks=clocks, actions=actions, cost=cost, skeleton=skeleton, paths=paths, reached=reached,
            ahead=tuple(judgement.ahead), seconds=time.monotonic() - self.began,
        )  # fmt: skip

    def _window(self, status: WindowStatus) -> Window:
        return Window(
            status, self.problem, (), Skeleton(self.problem, (), self.problem.init_motion), (), self.reached,
            time.monotonic() - self.began, tuple(told(self.unmet)), self.refused, 0.0,
            self.tree_nodes, self.expanded_nodes, self.tree,
        )  # fmt: skip


def forbid(search: SkeletonSearch, actions: Sequence[ir.Action]) -> None:
    """Forbid plans that begin with these actions, if they can be done at all."""
    numbers = numbers_of(search.successors, actions)
    if numbers is not None:
        search.no_goods.forbid_prefix(numbers)


def numbers_of(successors: Successors, actions: Sequence[ir.Action]) -> list[int] | None:
    """The numbers of actions done one after the other from the start; None when they cannot be."""
    state, numbers = successors.initial, []
    for action in actions:
        found = next(((t, n) for t, n in successors.expand(state) if successors.action(n) == action), None)
        if found is None:
            return None
        state = found[0]
        numbers.append(found[1])
    return numbers


def end_of(successors: Successors, numbers: Sequence[int]) -> int:
    """The state after actions that can be done from the start."""
    state = successors.initial
    for number in numbers:
        state = successors.after(state, number)
    return state
