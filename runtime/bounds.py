"""Multi-bound judgement of one skeleton (thesis, section 3.2): cheap bounds first, conflicts when one refuses."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from ..compiler.ir import Action, Problem
from .assemble import assemble
from .budget import Budget, OutOfTime
from .experience import Experience
from .motion.path import solve_path
from .motion.phases import UnsupportedPhase, solve_sequence_path
from .motion.sequence import LONGEST, judged_alone, solve_sequence, window_feasible
from .motion.settings import MotionSettings
from .plan import BoundRecord, Plan, StatisticsRecord
from .skeleton import BoundResult, Configuration, PhasePath, Skeleton, Violation
from .verify import verify

RESAMPLES = 4
"""How often the switch poses are drawn anew when a phase between them finds no path."""
EXPECTED = "expected"
"""The bound of conflicts that similar windows make likely, without a solve."""
PATH_SECONDS, PATH_SHARE = 30.0, 0.4
"""What P_path of one skeleton may take: seconds, and share of the time that is left."""
ALWAYS = 3
"""Between how many pairs of poses a phase must fail before it is refused wherever it starts."""
LONGEST_WINDOW = 5
"""How many phases a conflict that may start anywhere has at most."""
WIDER = 0.01
"""Metres by which margins grow for a plan that the verifier refused."""
AGAIN = 1000
QUICK = 3
"""Starts of a span before a skeleton is refused for the first time."""
SPAN = 4
"""How far from the phases that P_seq blames a conflict of a long skeleton is looked for."""


@dataclass(frozen=True, slots=True)
class Conflict:
    """Phases `first` … `last` of a skeleton cannot be done one after the other; with `from_start` only when they begin
    in the start configuration (then `first` is 0)."""

    bound: str
    first: int
    last: int
    from_start: bool
    violations: tuple[Violation, ...]


@dataclass(slots=True)
class Judgement:
    """Either accepted, with the motion of every phase unless only P_seq was asked for, or refused with conflicts."""

    accepted: bool
    paths: list[PhasePath] | None = None
    conflicts: list[Conflict] = field(default_factory=list)


class Clock:
    """Wall-clock seconds per stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        started = time.monotonic()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.monotonic() - started


class Bounds:
    """The bounds of one run: their settings, their counters, and what single actions were already found to allow."""

    def __init__(
        self,
        problem: Problem,
        settings: MotionSettings,
        finest: str,
        seed: int,
        budget: Budget,
        tell: Callable[[str, str], None],
    ) -> None:
        self.problem = problem
        self.settings = settings
        self.finest = finest
        self.seed = seed
        self.budget = budget
        self.tell = tell
        self.clock = Clock()
        self._counts: dict[str, list[int]] = {"seq": [0, 0], "seq-path": [0, 0], "path": [0, 0]}
        self._windows: dict[tuple[object, ...], BoundResult] = {}
        self.experience = Experience(problem)
        self.tries: int | None = QUICK

    def restart(self, problem: Problem, seed: int, budget: Budget) -> None:
        """Go on with the same task begun from another state (`horizon.state`): what was learnt of phases wherever they
        start stays."""
        self.problem, self.seed, self.budget = problem, seed, budget
        self.tries = QUICK
        self._windows.clear()
        self.experience.leave_start()

    def judge(self, skeleton: Skeleton, strains: Sequence[float], motions: int | None = None) -> Judgement:
        """Take a skeleton through the bounds; `strains` tells how close the conditions of each action are to their
        limits (`search.roomy`). With `motions` only so many phases get their motion, and P_seq looks farther ahead.
        Raises OutOfTime."""
        expected = self.experience.expected_refusals(skeleton.phases, strains)
        if expected:
            return Judgement(False, conflicts=[Conflict(EXPECTED, *window, ()) for window in expected])
        conflicts = self._refused_actions(skeleton, strains)
        if not conflicts:
            sequence = self._sequence(skeleton, self.seed, None)
            if sequence.feasible:
                if self.finest == "seq":
                    return Judgement(True)
                if motions is not None and motions < len(skeleton):
                    skeleton = beginning(skeleton, motions)
                    sequence = replace(sequence, configurations=sequence.configurations[: motions + 1])
                if not skeleton.phases:
                    return Judgement(True, paths=[])
                return self._paths(skeleton, sequence)
            conflicts = [self._shrink(skeleton, sequence)]
        for c in conflicts:
            window = slice(c.first, c.last + 1)
            if not (c.from_start and self.tries is None):
                self.experience.refuse(skeleton.phases[window], strains[window], c.from_start)
        return Judgement(False, conflicts=conflicts)

    def try_harder(self) -> None:
        """Forget every refusal; from now on each span gets all its starts, and others than before."""
        self.experience.forget()
        self._windows = {key: result for key, result in self._windows.items() if result.feasible}
        self.seed += 1
        self.tries = None

    def believe(
        self, skeleton: Skeleton, actions: Sequence[Action], paths: Sequence[PhasePath], statistics: StatisticsRecord
    ) -> Plan:
        """The plan with the verifier's verdict in it. One that is refused gets a second motion, with larger margins and
        from another seed. Raises OutOfTime."""
        plan = self._verified(skeleton, actions, paths, statistics)
        if plan.verdict is not None and plan.verdict.verified:
            return plan
        careful, seed = self.settings, self.seed
        try:
            self.settings = replace(careful, margin=careful.margin + WIDER, switch_margin=careful.switch_margin + WIDER)
            self.seed = seed + AGAIN
            sequence = self._sequence(skeleton, self.seed, None)
            judgement = self._paths(skeleton, sequence) if sequence.feasible else Judgement(False)
        finally:
            self.settings, self.seed = careful, seed
        if judgement.paths is None:
            return plan
        again = self._verified(skeleton, actions, judgement.paths, statistics)
        return again if again.verdict is not None and again.verdict.verified else plan

    def _verified(
        self, skeleton: Skeleton, actions: Sequence[Action], paths: Sequence[PhasePath], statistics: StatisticsRecord
    ) -> Plan:
        import msgspec

        self.tell("verify", f"verifying a plan of {len(actions)} actions")
        plan = assemble(self.problem, actions, skeleton, paths, statistics)
        with self.clock("verify"):
            verdict = verify(plan)
        return msgspec.structs.replace(plan, verdict=verdict)

    def records(self) -> list[BoundRecord]:
        stages = {"seq": "seq", "seq-path": "seq_path", "path": "path"}
        return [
            BoundRecord(bound, solved, refused, self.clock.seconds.get(stages[bound], 0.0))
            for bound, (solved, refused) in self._counts.items()
        ]

    def _refused_actions(self, skeleton: Skeleton, strains: Sequence[float]) -> list[Conflict]:
        """Conflicts of all single actions that P_seq refuses, wherever they start. The most strained go first: those
        that are less so then need no solve."""
        conflicts = []
        for k in sorted(range(len(skeleton)), key=lambda k: (-strains[k], k)):
            phase = skeleton.phases[k]
            if k and (self.experience.expects_success(phase, strains[k]) or not judged_alone(skeleton, k)):
                continue
            result = self._window(skeleton, k, k)
            if not result.feasible:
                conflicts.append(Conflict("seq", k, k, k == 0, tuple(result.violations)))
            elif k:
                self.experience.accept(phase, strains[k])
        return sorted(conflicts, key=lambda conflict: conflict.first)

    def _window(self, skeleton: Skeleton, first: int, last: int) -> BoundResult:
        """P_seq of some phases alone. From the start itself names matter, elsewhere interchangeable ones do not."""
        phases = skeleton.phases[first : last + 1]
        key = self.experience.lifted(phases) if first else tuple(phase.action for phase in phases)
        if key not in self._windows:
            self.tell("seq", f"P_seq of {phases[-1].action}")
            with self.clock("seq"):
                result = window_feasible(skeleton, first, last, self.settings, self.seed, self.budget)
            self._count("seq", result.feasible)
            self._windows[key] = result
        return self._windows[key]

    def _sequence(self, skeleton: Skeleton, seed: int, warm: Sequence[Configuration] | None) -> BoundResult:
        self.tell("seq", f"P_seq of {len(skeleton)} actions")
        with self.clock("seq"):
            result = solve_sequence(skeleton, self.settings, seed, self.budget, warm=warm, tries=self.tries)
        self._count("seq", result.feasible)
        return result

    def _prefix(self, skeleton: Skeleton, length: int) -> BoundResult:
        return self._sequence(beginning(skeleton, length), self.seed, None)

    def _shrink(self, skeleton: Skeleton, refused: BoundResult) -> Conflict:
        """A minimal contiguous conflict behind a refused P_seq, by deletion: first phases from the end, halving, then
        from the front as long as what is left is refused wherever it starts."""
        known, end, violations = 0, len(skeleton), refused.violations
        if end > LONGEST:
            worst = max((v.phase for v in violations), default=end - 1)
            known, end = max(0, worst - SPAN), min(end, worst + SPAN)
        while end - known > 1:
            middle = (known + end) // 2
            result = self._prefix(skeleton, middle)
            if result.feasible:
                known = middle
            else:
                end, violations = middle, result.violations
        for first in range(end - 1, max(0, end - LONGEST_WINDOW - 1), -1):
            if not judged_alone(skeleton, first):
                continue
            window = self._window(skeleton, first, end - 1)
            if not window.feasible:
                return Conflict("seq", first, end - 1, False, tuple(window.violations))
        return Conflict("seq", 0, end - 1, True, tuple(violations))

    def _paths(self, skeleton: Skeleton, sequence: BoundResult) -> Judgement:
        """P_seqPath between the switch poses, drawn anew around phases that fail; then P_path."""
        result: BoundResult | None = None
        blamed: list[set[int]] = []
        for attempt in range(RESAMPLES + 1):
            if attempt and result is not None:
                failed = sorted({v.phase for v in result.violations})
                if attempt == 1:
                    warm = _unmoved(sequence.configurations, failed)[1:]
                else:
                    warm = _resample(sequence.configurations, failed, self.seed + attempt)[1:]
                again = self._sequence(skeleton, self.seed + attempt, warm)
                if not again.feasible:
                    continue
                sequence = again
            result = self._sequence_path(skeleton, sequence)
            if result.feasible:
                return Judgement(True, result.paths)
            blamed.append({v.phase for v in result.violations})
        assert result is not None
        bound = "seq-path"
        if self.finest == "path":
            free = self._path(skeleton, sequence)
            if free is not None and free.feasible:
                return Judgement(True, free.paths)
            bound = "path"
        return Judgement(False, conflicts=[_blame(bound, result, blamed, len(skeleton))])

    def _path(self, skeleton: Skeleton, sequence: BoundResult) -> BoundResult | None:
        """P_path, with a share of the time that is left; None when that is spent."""
        self.tell("path", f"P_path of {len(skeleton)} actions")
        share = Budget(min(PATH_SECONDS, PATH_SHARE * self.budget.remaining))
        try:
            with self.clock("path"):
                result = solve_path(skeleton, self.settings, self.seed, share, sequence)
        except OutOfTime:
            self.budget.check()
            self._count("path", False)
            return None
        self._count("path", result.feasible)
        return result

    def _sequence_path(self, skeleton: Skeleton, sequence: BoundResult) -> BoundResult:
        self.tell("seq-path", f"P_seqPath of {len(skeleton)} phases")
        with self.clock("seq_path"):
            try:
                result = solve_sequence_path(
                    skeleton, sequence.configurations, self.settings, self.seed, self.budget
                )
            except UnsupportedPhase:
                result = solve_path(skeleton, self.settings, self.seed, self.budget, sequence, pinned=True)
        self._count("seq-path", result.feasible)
        return result

    def _count(self, bound: str, feasible: bool) -> None:
        self._counts[bound][0 if feasible else 1] += 1


def beginning(skeleton: Skeleton, length: int) -> Skeleton:
    """The first phases of a skeleton."""
    if length >= len(skeleton):
        return skeleton
    return replace(skeleton, phases=skeleton.phases[:length], final_mode=skeleton.phases[length].mode)


def _blame(bound: str, refused: BoundResult, blamed: Sequence[set[int]], phases: int) -> Conflict:
    """The one phase that failed between every pair of switch poses, wherever it starts; else all up to the phase that
    failed worst."""
    worst = refused.violations[0].phase if refused.violations else phases - 1
    always = set.intersection(*blamed) if len(blamed) >= ALWAYS else set()
    if worst in always and worst > 0:
        told = tuple(v for v in refused.violations if v.phase == worst)
        return Conflict(bound, worst, worst, False, told)
    return Conflict(bound, 0, worst, True, tuple(refused.violations))


def _unmoved(configurations: Sequence[Configuration], failed: Sequence[int]) -> list[Configuration]:
    """Switch configurations as a start in which the failed phases end where they begin."""
    result = [configuration.copy() for configuration in configurations]
    for phase in failed:
        result[phase + 1] = result[phase].copy()
    return result


def _resample(configurations: Sequence[Configuration], failed: Sequence[int], seed: int) -> list[Configuration]:
    """Switch configurations 1 … K as a start, with new joint values at both ends of the failed phases."""
    random = np.random.default_rng(seed)
    changed = {k for phase in failed for k in (phase, phase + 1)} - {0}
    result = []
    for k, configuration in enumerate(configurations):
        fresh = configuration.copy()
        if k in changed:
            for values in fresh.modules.values():
                values[7:] += random.normal(0.0, 0.4, len(values) - 7)
        result.append(fresh)
    return result
