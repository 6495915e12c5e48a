"""The LGP loop (thesis, algorithm 1): candidate skeletons from the symbolic search, bounds from coarse to fine,
refusals fed back to the search, and the verifier's word on every plan before it is called solved.

    search ──candidate──▶ single actions ──▶ P_seq ──▶ P_seqPath ──▶ (P_path) ──▶ verifier ──▶ plan
       ▲                        │               │            │            │
       └────────── conflict ────┴───────────────┴────────────┴────────────┘
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from functools import partial
from typing import Any

import msgspec

from ...compiler.ir import Problem
from ...compiler.objective_terms import spelled
from ...compiler.objectives import ACTIONS, Objective, check_energy
from ...compiler.options import OPTIONS, given_at
from ...langs.counting import counted
from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ..budget import ASIDE, SECONDS, Budget, OutOfTime, Status, ending
from ..geometry.start_contacts import pressed_in, touching
from ..machine import this_machine
from ..plan import ObjectiveRecord, Plan, StatisticsRecord, TimingRecord
from ..seeds import Seed
from ..skeleton import Bound, NearestMiss, PhasePath, Skeleton
from .anytime import Steps, better, cheaper
from .bounds.length_unit import length_unit
from .bounds.multi_bound import MultiBound
from .bounds.speculation import Speculation
from .bounds.verdicts import Judgement
from .candidate_loop import CandidateLoop
from .conflicts.infeasibility import Refusals, distrust, fewer, unverified, wider
from .motion.settings import MotionSettings
from .schedule.at_once import AtOnce
from .schedule.clocked_search import Clocked
from .schedule.distinct_plans import DistinctPlans
from .schedule.improvement import Improvement
from .schedule.objective_value import bounded, valued
from .schedule.settings import SCHEDULE
from .search.best_first import EQUAL, Candidate, SkeletonSearch
from .search.slack_maximisation import maximise_slack

FINEST = Bound(OPTIONS["bound"].default)


@dataclass(frozen=True, slots=True)
class SolveOptions:
    """What a user may set; `time` in seconds, None without limit. `bound` is the finest bound that is tried."""

    bound: Bound = FINEST
    search: str = OPTIONS["search"].default
    time: float | None = SECONDS
    nodes: int | None = None
    solutions: int = OPTIONS["solutions"].default
    solver: str = OPTIONS["solver"].default
    seed: int = 0
    slices: int | None = None
    minimise: Objective = ACTIONS
    gap: float | None = None
    ahead: Speculation = field(default_factory=Speculation, compare=False, repr=False)


def options_of(problem: Problem, chosen: Mapping[str, Any], otherwise: float = SECONDS) -> SolveOptions:
    """What is `chosen` by name and not None, else what the task's `options` block says, else the defaults. `time` may
    be infinite; `otherwise` is the time in seconds where neither says one. Raises UsageError for an objective that
    makes no sense here."""
    values: dict[str, Any] = {}
    for name in given_at("python"):
        value = chosen.get(name)
        value = getattr(problem.options, name, None) if value is None else value
        if value is not None:
            values[name] = spelled(value) if name == "minimise" and isinstance(value, str) else value
    if "minimise" in values:
        check_energy(values["minimise"], problem.options.physics)
    seconds = values.pop("time", otherwise)
    values["bound"] = Bound(values.get("bound", FINEST))
    return SolveOptions(**values, time=None if math.isinf(seconds) else seconds, seed=problem.seed)


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a run stands, for a progress bar; seconds."""

    stage: str
    message: str
    elapsed: float
    limit: float | None
    tree_nodes: int
    candidates: int
    solutions: int


@dataclass(slots=True)
class Outcome:
    """What a run found. `status` is solved, infeasible (proved), exhausted (every candidate refused), budget,
    interrupted or refused (by the verifier). `plans` are best first, all of them verified; `refused` is one that the
    verifier does not believe, or had no time for, where there is no other.

    `misses` are the postures that came nearest to what the explanation says is missing.

    With bound "seq" there is no motion, hence no plan: `actions` and `cost` tell the skeleton that P_seq accepts.
    """

    status: Status
    plans: list[Plan] = field(default_factory=list)
    statistics: StatisticsRecord = field(default_factory=StatisticsRecord)
    timing: TimingRecord = field(default_factory=TimingRecord)
    explanation: list[Diagnostic] = field(default_factory=list)
    actions: list[str] = field(default_factory=list)
    cost: float = 0.0
    refused: Plan | None = None
    misses: list[NearestMiss] = field(default_factory=list)


def solve(
    problem: Problem,
    options: SolveOptions,
    progress: Callable[[Progress], None] | None = None,
    found: Callable[[Plan], None] | None = None,
) -> Outcome:
    """Search until `options.solutions` verified plans stand or the budget is spent; Ctrl-C ends with what was found.
    `found` gets every verified plan as soon as it stands."""
    begun = replace(problem, touching=touching(problem.world), pressed=frozenset(pressed_in(problem.world)))
    return _SolveRun(begun, options, progress, found).run()


class _SolveRun:
    def __init__(
        self, problem: Problem, options: SolveOptions, progress: Callable[[Progress], None] | None,
        found: Callable[[Plan], None] | None,
    ) -> None:  # fmt: skip
        self.problem = problem
        self.options = options
        self.report = progress
        self.found = found
        self.budget = Budget(options.time, options.nodes, ASIDE)
        self.candidates = 0
        self.plans: list[Plan] = []
        self.accepted: list[Candidate] = []
        self.distrusted: Plan | None = None
        self.first_bound: float | None = None
        settings, seed = motion_settings(problem, options), Seed(options.seed)
        self.bounds = MultiBound(problem, settings, options.bound, seed, self.budget, self._tell, options.ahead)
        self.refusals = Refusals(problem, self.bounds.cause)
        self.improvement = Improvement(problem, options.minimise)
        self.at_once = AtOnce(problem, settings, seed, self.budget, self._tell)
        self.search: SkeletonSearch | None = None
        self.distinct: DistinctPlans | None = None
        self.least: float | None = None
        """What no plan of any actions falls below, as far as is known, once better ones were searched for."""

    def run(self) -> Outcome:
        return self._outcome(ending(self._loop))

    def _loop(self) -> Status:
        self.options.ahead.prepare(self.problem)
        self._tell("compile", "compiling the rules")
        loop = CandidateLoop(self.problem, self.options.search, self.budget, self.bounds, self.refusals)
        self.search = loop.search
        self.distinct = DistinctPlans(loop.search)
        for candidate in loop.proposals(partial(self._propose, loop), loop.readmit):
            if candidate is not None:
                self._take(loop, candidate)
            if len(self.accepted) >= self.options.solutions:
                break
        self._improve(loop)
        return Status.SOLVED if len(self.accepted) >= self.options.solutions else loop.search.status

    def _improve(self, loop: CandidateLoop) -> None:
        """Look for better plans behind those that stand, and tell below what none falls."""
        if not self.accepted:
            return
        take = partial(self._take, loop, brisk=self.options.gap is None)
        steps = Steps(partial(self._propose, loop), take, self._repeats, self._best_worth,
                      partial(self._promising, loop), partial(self._nearer, loop))  # fmt: skip
        try:
            with suppress(OutOfTime):
                if self.options.minimise == ACTIONS:
                    cheaper(steps, self.options.gap, self.first_bound or 0.0)
                elif self.plans:
                    better(steps, self.options.gap, self.budget)
        finally:
            if self.least is not None:
                self.plans = [bounded(plan, self.least) for plan in self.plans]

    def _promising(self, loop: CandidateLoop, below: float | None, nodes: int) -> Clocked:
        self._tell("search", "searching for what is better")
        with self.bounds.clock("search"):
            clocked = self.improvement.better(loop.search, below, nodes)
        self.least = clocked.bound
        return clocked

    def _nearer(self, loop: CandidateLoop, nodes: int) -> Clocked:
        with self.bounds.clock("search"):
            return self.improvement.nearer(loop.search, nodes)

    def _repeats(self, candidate: Candidate) -> bool:
        return self.distinct is not None and self.distinct.repeats(candidate, self.accepted)

    def _best_worth(self) -> float:
        return min(self._worth(k) for k in range(len(self.accepted)))

    def _gap(self) -> float:
        """By how much a plan of any actions may be better than the best one, as far as is known."""
        known = self.first_bound if self.options.minimise == ACTIONS else self.least
        return self._best_worth() - (known or 0.0)

    def _propose(self, loop: CandidateLoop) -> Candidate | None:
        self._tell("search", "searching for a skeleton")
        for _ in range(SCHEDULE.detours):
            candidate = loop.next()
            if candidate is None:
                return None
            candidate = maximise_slack(loop.search, loop.strain, candidate)
            if not self._repeats(candidate):
                return candidate
        loop.search.status = Status.EXHAUSTED
        return None

    def _take(self, loop: CandidateLoop, candidate: Candidate, brisk: bool = False) -> bool:
        """Take one candidate through the bounds; whatever comes of it, the search will not propose it again. Whether it
        is accepted. `brisk`: why it is not is not asked."""
        self.candidates += 1
        if self.first_bound is None:
            self.first_bound = candidate.lower_bound
        skeleton = loop.skeleton(candidate)
        judgement = loop.judge(candidate, skeleton, brisk=brisk)
        if judgement.accepted:
            paths = None if judgement.paths is None else self._believed(skeleton, candidate, judgement)
            if judgement.paths is None or paths is not None:
                self.accepted.append(candidate)
                if paths is not None:
                    self._hand_on(skeleton, candidate, paths)
                self._tell("solved", f"plan {len(self.accepted)}: {counted(len(candidate.actions), 'action')}")
                self._keep_distinct(candidate)
            else:
                loop.search.forbid_plan(candidate)
        elif not judgement.conflicts:
            loop.search.forbid_plan(candidate)
        return candidate in self.accepted[-1:]

    def _keep_distinct(self, candidate: Candidate) -> None:
        """Drop what turns out to be a detour of the candidate that was accepted last, and forbid that in all its
        orders."""
        alone = self.options.solutions == 1 and (self.options.minimise == ACTIONS or self.options.gap is None)
        if self.distinct is None or alone:
            return
        self.distinct.found(candidate)
        for k in reversed(range(len(self.accepted) - 1)):
            if self.distinct.detours(self.accepted[k], (candidate,)):
                del self.accepted[k], self.plans[k : k + 1]

    def _believed(
        self, skeleton: Skeleton, candidate: Candidate, judgement: Judgement
    ) -> Sequence[PhasePath] | None:  # fmt: skip
        """The motion that the verifier believes, whose plan is kept; None where it does not. Raises OutOfTime."""
        statistics = self._statistics([*self.accepted, candidate])
        plan, paths = self.bounds.believe(skeleton, candidate.actions, judgement, statistics, self._timing())
        if plan.verdict is None:
            self.distrusted = plan
            raise OutOfTime
        if not plan.verdict.verified:
            self.distrusted = self.distrusted or plan
            return None
        self.plans.append(plan)
        return paths

    def _hand_on(self, skeleton: Skeleton, candidate: Candidate, paths: Sequence[PhasePath]) -> None:
        """Make the plan that was kept last what the objective wants, and hand it on, whatever comes in between."""
        try:
            self.plans[-1] = self._valued(skeleton, candidate, paths, self.plans[-1])
        finally:
            if self.found is not None:
                self.found(self.plans[-1])

    def _valued(self, skeleton: Skeleton, candidate: Candidate, paths: Sequence[PhasePath], plan: Plan) -> Plan:
        """The plan as the objective wants it, with its value: where seconds count, one that is as short as its motions
        allow. The very first one is handed on before that, too."""
        objective = self.options.minimise
        if objective == ACTIONS:
            return plan
        critical: float | None = None
        sequence = plan
        taken: Sequence[float] = [path.duration for path in paths]
        if objective.timed:
            if self.found is not None and len(self.plans) == 1:
                self.found(self._worthy(plan, candidate, None))
            with self.bounds.clock("schedule"):
                known = None if self.search is None else self.search.successors
                plan, critical, taken = self.at_once.shorter(skeleton, candidate.actions, paths, plan, known)
        self.improvement.learn(candidate, sequence, taken)
        return self._worthy(plan, candidate, critical)

    def _worthy(self, plan: Plan, candidate: Candidate, critical: float | None) -> Plan:
        """The plan with its value."""
        objective, least = self.options.minimise, self.first_bound or 0.0
        value = valued(self.problem, objective, plan, candidate.cost, least, critical)
        statistics = msgspec.structs.replace(plan.statistics, objective=value)
        return msgspec.structs.replace(plan, statistics=statistics)

    def _statistics(self, accepted: list[Candidate] | None = None) -> StatisticsRecord:
        search = self.search
        accepted = self.accepted if accepted is None else accepted
        cost = min((c.cost for c in accepted), default=0.0)
        gap = None if self.first_bound is None or not accepted else max(0.0, cost - self.first_bound)
        return StatisticsRecord(
            tree_nodes=search.tree_nodes if search else 0,
            expanded_nodes=search.expanded_nodes if search else 0,
            optimal=gap == 0.0,
            gap=gap,
            cost=cost,
            bounds=self.bounds.records(),
            refusals=self.refusals.records(),
            tree=list(search.tree) if search else [],
        )

    def _timing(self) -> TimingRecord:
        return TimingRecord({"total": self.budget.elapsed, **self.bounds.clock.seconds}, machine=this_machine())

    def _outcome(self, status: Status) -> Outcome:
        statistics, timing, apart = self._statistics(), self._timing(), self._apart(status)
        order = sorted(range(len(self.accepted)), key=self._worth)[: self.options.solutions]
        self.accepted = [self.accepted[i] for i in order]
        plans = [_with_statistics(self.plans[i], statistics, timing, self.accepted[k].cost)
                 for k, i in enumerate(order) if i < len(self.plans)]  # fmt: skip
        if plans:
            statistics = plans[0].statistics
        explanation = self.refusals.explain(status) if not self.accepted else []
        if self.accepted:
            missing = self.options.solutions - len(self.accepted)
            explanation = [fewer(status, len(self.accepted), self.options.solutions)] if missing else []
            explanation += apart
            status = Status.INTERRUPTED if status == Status.INTERRUPTED else Status.SOLVED
        elif self.distrusted is not None and self.distrusted.verdict is None:
            explanation = [unverified()]
        elif self.distrusted is not None:
            status, explanation = Status.REFUSED, distrust(self.distrusted.verdict)
        actions = [str(a) for a in self.accepted[0].actions] if self.accepted else []
        if plans:
            actions = [phase.action for phase in plans[0].phases]
        if self.distrusted is not None and not self.accepted:
            actions = [phase.action for phase in self.distrusted.phases]
        refused = None if self.accepted else self.distrusted
        misses = [] if self.accepted or refused is not None else self.refusals.misses
        return Outcome(status, plans, statistics, timing, explanation, actions, statistics.cost, refused, misses)

    def _apart(self, status: Status) -> list[Diagnostic]:
        """What is told where the gap stayed wider than was asked for."""
        asked = self.options.gap
        if asked is None or not self.accepted or self._gap() <= asked + EQUAL:
            return []
        if status == Status.SOLVED:
            status = Status.BUDGET if self.budget.remaining <= 0.0 or self.budget.full else Status.EXHAUSTED
        return [wider(status, self._gap(), asked, self.options.minimise.unit)]

    def _worth(self, index: int) -> float:
        """What the plan, or without motion the candidate, of this number is worth: less is better."""
        told = self.plans[index].statistics.objective if index < len(self.plans) else None
        return told.value if isinstance(told, ObjectiveRecord) else self.accepted[index].cost

    def _tell(self, stage: str, message: str) -> None:
        if self.report is None:
            return
        nodes = self.search.tree_nodes if self.search else 0
        self.report(
            Progress(
                stage, message, self.budget.elapsed, self.options.time, nodes, self.candidates, len(self.accepted)
            )
        )


def motion_settings(problem: Problem, options: SolveOptions) -> MotionSettings:
    settings = MotionSettings(solver=options.solver, objective=options.minimise)
    slices = options.slices or problem.options.slices
    if slices is not None:
        settings = replace(settings, slices=slices)
    if problem.options.margin is not None:
        margin = problem.options.margin / length_unit(problem)
        settings = replace(settings, margin=margin, switch_margin=margin + 0.005)
    return settings


def _with_statistics(plan: Plan, statistics: StatisticsRecord, timing: TimingRecord, cost: float) -> Plan:
    """The plan with the figures of the whole run, but its own costs and gap."""
    gap = None if statistics.gap is None else statistics.gap + cost - statistics.cost
    told = plan.statistics
    own = msgspec.structs.replace(
        statistics, cost=cost, gap=gap, optimal=gap == 0.0, path_cost=told.path_cost,
        path_cost_before=told.path_cost_before, objective=told.objective,
    )  # fmt: skip
    return msgspec.structs.replace(plan, statistics=own, timing=timing)
