"""Receding horizon with backtracking and sub-goals: RH-LGP (thesis, section 3.5) without its dead ends.

The planner of one window, for whoever runs it, is

    windows.remember(problem, options, budget, tell) -> Memory
    windows.plan_window(problem, reached, options, horizon, budget, memory, *, seed, forbidden, lookahead) -> Window

with `state.start(problem)` as the first `reached`, and `Window.reached` after what was planned. `solve_receding` plans
window after window until the goal holds. A window from which nothing leads on undoes the one before it, which is only
planned yet: first it gets another motion, then its actions are forbidden there, then the window before it is undone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace

from ....compiler import ir
from ....compiler.objectives import ACTIONS
from ....langs.counting import counted
from ....langs.diagnostics import Diagnostic
from ....langs.frozen import dataclass
from ...budget import ASIDE, Budget, Status, ending, unless_spent
from ...machine import this_machine
from ...plan import Plan, StatisticsRecord, TimingRecord, WindowRecord
from ...seeds import Seed
from ...skeleton import PhasePath, Skeleton
from ...verify import verify
from ..bounds.settings import BOUNDS
from ..conflicts.infeasibility import ENDINGS, distrust, unverified
from ..lgp import Outcome, Progress, SolveOptions, motion_settings
from ..plan_assembly import assemble
from ..schedule.at_once import AtOnce
from ..schedule.objective_value import valued
from .horizon_length import horizon_of
from .mid_run_state import Reached, start
from .run_tree import grown
from .settings import RECEDING
from .window import Memory, Window, WindowStatus, plan_window, remember


@dataclass(slots=True)
class _Level:
    """A state that windows have reached: what must not follow it, and how often what followed failed."""

    reached: Reached
    forbidden: list[tuple[ir.Action, ...]] = field(default_factory=list)
    failures: int = 0


@dataclass(frozen=True, slots=True)
class _Kept:
    """A planned window, and why it was planned."""

    window: Window
    reason: str


def solve_receding(
    problem: ir.Problem,
    options: SolveOptions,
    horizon: int | None,
    progress: Callable[[Progress], None] | None = None,
    found: Callable[[Plan], None] | None = None,
    *,
    lookahead: int = RECEDING.lookahead,
    backtracks: int | None = None,
) -> Outcome:
    """Plan `horizon` actions at a time (None: as many as seem wise) until the goal holds, and undo at most `backtracks`
    windows (None: any number). The plan is one, verified as a whole; when time or Ctrl-C end the run early, it holds
    what was planned so far and is not `complete`."""
    return _HorizonRun(problem, options, horizon, progress, found, lookahead, backtracks).run()


class _HorizonRun:
    def __init__(
        self, problem: ir.Problem, options: SolveOptions, horizon: int | None,
        progress: Callable[[Progress], None] | None, found: Callable[[Plan], None] | None,
        lookahead: int, backtracks: int | None,
    ) -> None:  # fmt: skip
        self.problem, self.options = problem, options
        self.horizon = horizon_of(horizon)
        self.report, self.found = progress, found
        self.lookahead, self.backtracks = lookahead, backtracks
        self.budget = Budget(options.time, options.nodes, ASIDE)
        self.memory: Memory = remember(problem, options, self.budget, self._tell)
        self.at_once = AtOnce(
            problem, motion_settings(problem, options), Seed(options.seed), self.budget, self._tell
        )
        self.levels = [_Level(start(problem))]
        self.kept: list[_Kept] = []
        self.plan: Plan | None = None
        self.done = False
        """Whether the goal holds after the windows that stand."""
        self.deepest = self.setbacks = 0
        self.undone = self.doubts = self.tree_nodes = self.expanded_nodes = self.candidates = 0
        self.reason = "start"
        self.first_motion: float | None = None

    def run(self) -> Outcome:
        return self._outcome(ending(self._loop))

    # --- window after window -------------------------------------------------------------------------------------

    def _loop(self) -> Status:
        while True:
            window = self._plan()
            if window.status == WindowStatus.DONE:
                self.done = True
                plan = self._verified()
                if plan.verdict is None or plan.verdict.verified:
                    self.plan = plan
                    return Status.BUDGET if plan.verdict is None else Status.SOLVED
                if not self._doubt(plan):
                    self.plan = plan
                    return Status.REFUSED
            elif window.status == WindowStatus.PLANNED:
                self._keep(window)
            elif not self.kept and window.status == WindowStatus.INFEASIBLE:
                return Status.INFEASIBLE
            elif not self._backtrack():
                return Status.EXHAUSTED

    def _plan(self) -> Window:
        """The window from the present state. Where what followed it failed, P_seq looks one more window ahead for each
        time: what failed there then has a say in the motion here."""
        level = self.levels[-1]
        lookahead = self.lookahead + self.horizon.length * level.failures
        window = plan_window(
            self.problem, level.reached, self.options, self.horizon.length, self.budget, self.memory,
            seed=Seed(self.options.seed).child("failures", level.failures), forbidden=tuple(level.forbidden),
            lookahead=lookahead, before=self.kept[-1].window if self.kept and not level.failures else None,
            clocks=self.kept[-1].window.clocks if self.kept else (), undoable=bool(self.kept),
        )  # fmt: skip
        self.tree_nodes += window.tree_nodes
        self.expanded_nodes += window.expanded_nodes
        self.candidates += window.refused + (window.status == WindowStatus.PLANNED)
        return window

    def _keep(self, window: Window) -> None:
        self.horizon.adapt(window.refused > RECEDING.hard)
        if self._seen(window.reached) >= RECEDING.visits:
            self.levels[-1].forbidden.append(_beginning(window))
            self.reason = "loop"
            return
        if self.first_motion is None:
            self.first_motion = self.budget.elapsed
        skeleton = replace(window.skeleton, problem=self.problem)
        slim = replace(window, problem=self.problem, skeleton=skeleton, tree=window.tree[:RECEDING.shown_nodes])
        self.kept.append(_Kept(slim, self.reason))
        self.levels.append(_Level(window.reached))
        self.reason = "horizon"

    def _seen(self, reached: Reached) -> int:
        return sum(level.reached.facts == reached.facts for level in self.levels)

    # --- dead ends -----------------------------------------------------------------------------------------------

    def _backtrack(self) -> bool:
        """Undo windows so that one can be planned otherwise: one at first, more when the same depth stays a dead end.
        The window gets other motions, and other actions in turn. Where nothing is left at the start, everything is
        allowed again, with other motions. False when nothing is left to try or too many were undone."""
        self.horizon.adapt(True)
        self.reason = "dead end"
        if self.backtracks is not None and self.undone >= self.backtracks:
            return False
        depth = len(self.kept)
        if depth == 0:
            level = self.levels[0]
            forgotten, level.forbidden = bool(level.forbidden), []
            self.deepest = self.setbacks = 0
            level.failures += 1
            return forgotten or level.failures < RECEDING.beginnings
        self.undone += 1
        if depth > self.deepest:
            self.deepest, self.setbacks = depth, 0
        back = min(1 + self.setbacks // RECEDING.motions, depth)
        self.setbacks += 1
        window = self.kept[-back].window
        del self.kept[-back:], self.levels[-back:]
        level = self.levels[-1]
        level.failures += 1
        if level.failures % RECEDING.motions == 0:
            level.forbidden.append(_beginning(window))
        return True

    def _doubt(self, plan: Plan) -> bool:
        """Undo the windows from the one on that the verifier blames, and keep larger margins from now on; False when
        that was tried before."""
        if self.doubts >= RECEDING.doubts or plan.verdict is None or not self.kept:
            return False
        self.doubts += 1
        self.done = False
        first = min((f.time for f in plan.verdict.failures if f.time is not None), default=0.0)
        begins = first + 1.0
        while self.kept and begins > first:
            begins = sum(path.duration for kept in self.kept[:-1] for path in kept.window.paths)
            self.kept.pop()
            self.levels.pop()
        self.levels[-1].failures += 1
        self.memory.bounds.settings = self.memory.bounds.settings.wider(BOUNDS.wider_margin)
        self.reason = "verifier"
        return True

    # --- what was found ------------------------------------------------------------------------------------------

    def _verified(self) -> Plan:
        """The plan of all windows that stand, with the verifier's verdict on it as a whole; without one where it has
        no time for it."""
        import msgspec

        self._tell("verify", f"verifying {counted(len(self.kept), 'window')}")
        phases = tuple(phase for kept in self.kept for phase in kept.window.skeleton.phases)
        paths: list[PhasePath] = [path for kept in self.kept for path in kept.window.paths]
        skeleton = Skeleton(self.problem, phases, self.levels[-1].reached.mode)
        plan = assemble(self.problem, [phase.action for phase in phases], skeleton, paths, self._statistics())
        plan = self._dressed(plan, range(len(phases)))
        with self.memory.bounds.clock("verify"):
            verdict = unless_spent(lambda: verify(plan, self.budget.whole))
        plan = msgspec.structs.replace(plan, verdict=verdict, statistics=self._statistics(), timing=self._timing())
        return self._valued(plan, skeleton, paths) if verdict is not None and verdict.verified else plan

    def _valued(self, plan: Plan, skeleton: Skeleton, paths: Sequence[PhasePath]) -> Plan:
        """The verified plan with what it is worth by the objective: where seconds count and nothing is left to plan,
        one whose robots work at once, those of one window through the others too."""
        import msgspec

        objective, critical = self.options.minimise, None
        if objective == ACTIONS:
            return plan
        if objective.timed and self.done:
            actions = [phase.action for phase in skeleton.phases]
            with self.memory.bounds.clock("schedule"):
                plan, critical, _ = self.at_once.shorter(skeleton, actions, paths, plan, finish=self._dressed)
        told = valued(self.problem, objective, plan, plan.statistics.cost, 0.0, critical)
        return msgspec.structs.replace(plan, statistics=msgspec.structs.replace(plan.statistics, objective=told))

    def _dressed(self, plan: Plan, order: Sequence[int]) -> Plan:
        """The plan with its windows; `order` tells the numbers that its phases had when they were planned."""
        import msgspec

        return msgspec.structs.replace(plan, windows=self._records(plan, order), complete=self.done)

    def _records(self, plan: Plan, order: Sequence[int]) -> list[WindowRecord]:
        """The windows, each before the first phase that it or a later one planned."""
        records, first = [], 0
        for kept in self.kept:
            window = kept.window
            phase = next(place for place, number in enumerate(order) if number >= first)
            records.append(
                WindowRecord(
                    plan.phases[phase].start, phase, kept.reason, [str(action) for action in window.actions],
                    len(window.paths), list(window.unmet),
                )
            )  # fmt: skip
            first += len(window.paths)
        return records

    def _timing(self) -> TimingRecord:
        first = {} if self.first_motion is None else {"first_motion": self.first_motion}
        seconds = {"total": self.budget.elapsed, **self.memory.bounds.clock.seconds, **first}
        return TimingRecord(seconds, [round(kept.window.seconds, 4) for kept in self.kept], this_machine())

    def _statistics(self) -> StatisticsRecord:
        return StatisticsRecord(
            tree_nodes=self.budget.grown,
            expanded_nodes=self.expanded_nodes,
            cost=sum(kept.window.cost for kept in self.kept),
            bounds=self.memory.bounds.records(),
            refusals=self.memory.refusals.records(),
            tree=grown([kept.window for kept in self.kept]),
        )

    def _outcome(self, status: Status) -> Outcome:
        self.report = None
        if self.plan is None and self.kept:
            self.plan = self._verified()
            believed = self.plan.verdict is not None and self.plan.verdict.verified
            status = Status.SOLVED if self.done and believed else status
        explanation = [] if status in (Status.SOLVED, Status.REFUSED) else self._explanation(status)
        plan, statistics, timing = self.plan, self._statistics(), self._timing()
        refused: Plan | None = None
        if plan is not None and (plan.verdict is None or not plan.verdict.verified):
            told = [unverified()] if plan.verdict is None else distrust(plan.verdict)
            explanation = told if plan.complete else [*explanation, *told]
            plan, refused = None, plan
        if plan is not None and status == Status.SOLVED and self.found is not None:
            self.found(plan)
        actions = [phase.action for found in (plan or refused,) if found is not None for phase in found.phases]
        plans = [] if plan is None else [plan]
        misses = self.memory.refusals.misses if plan is None and refused is None else []
        return Outcome(status, plans, statistics, timing, explanation, actions, statistics.cost, refused, misses)

    def _explanation(self, status: Status) -> list[Diagnostic]:
        """Why the goal was not reached, what was tried, and what stands."""
        if status == Status.INFEASIBLE:
            return self.memory.refusals.explain(status)
        count = sum(len(kept.window.paths) for kept in self.kept)
        planned = f"{counted(count, 'action')} in {counted(len(self.kept), 'window')}"
        tried = f"{planned} were planned, and {counted(self.undone, 'window')} undone"
        code, _, help = ENDINGS.get(status, ("S0002", "", None))
        return [Diagnostic(code, f"the goal was not reached: {tried}", help=help), *self.memory.refusals.most_telling()]

    def _tell(self, stage: str, message: str) -> None:
        if self.report is None:
            return
        done = sum(len(kept.window.paths) for kept in self.kept)
        where = f"window {len(self.kept) + 1}, {counted(done, 'action')} done: {message}"
        self.report(
            Progress(stage, where, self.budget.elapsed, self.options.time, self.tree_nodes, self.candidates, 0)
        )


def _beginning(window: Window) -> tuple[ir.Action, ...]:
    return window.actions[: len(window.paths)]
