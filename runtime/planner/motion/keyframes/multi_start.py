"""P_seq of some successive phases, with restarts."""

from __future__ import annotations

import time
from collections.abc import Sequence
from copy import deepcopy
from itertools import pairwise

import numpy as np

from ....budget import Budget
from ....geometry.attachments import looped
from ....geometry.drives import ringed
from ....skeleton import LOADS, Array, Bound, BoundResult, Configuration, Skeleton, Violation
from ...statics import exceeded_switches
from ..nlp.augmented_lagrangian import SolverOptions, project
from ..nlp.settings import SOLVER
from ..settings import MotionSettings
from .initial_guesses import guess
from .keyframe_program import POLISH, SwitchProgram, run
from .ring_walks import passive_rings, walked
from .settings import KEYFRAMES

SEQUENCE = SolverOptions(inner_tolerance=3e-2, projected=SOLVER.nearly)
SINGLE = SolverOptions(projected=SOLVER.nearly)
"""For several phases and for one. Multipliers that are taken up soon save a fifth of the steps of several; one phase
has them lead astray more often: grasps from unknown postures are then refused in 10 % of draws instead of none. What is
nearly feasible is projected, as switches are in the end: multipliers at large weights took up to 100 steps for it."""
ACCURATE = 1e-9
"""Metres and radians by which a row may be missed: poses are chained from phase to phase, and 1e-6 added up past the
tolerance over some 250 of them, so that whole draws were thrown away. What is aimed at …"""
ACCEPTED = 1e-6
"""… and what is accepted: distances of boxes and hulls are themselves known to some 1e-7 only."""


def solve_span(
    skeleton: Skeleton,
    first: int,
    last: int,
    settings: MotionSettings,
    random: np.random.Generator,
    budget: Budget,
    start: Configuration,
    warm: Sequence[Configuration] | None = None,
    free: bool = False,
    tries: int | None = None,
    end: Configuration | None = None,
) -> BoundResult:
    """P_seq of phases `first` … `last`, with restarts. `configurations` begins with the state before `first`: `start`,
    or with `free` an unknown one, and `start` is then the scene at time 0. With `end` it leads there."""
    began = time.monotonic()
    span = SpanSolver(skeleton, first, last, settings, random, budget, start, free, end)
    best = span.search(warm, tries or min(KEYFRAMES.tries, 4 + last - first))
    best.iterations, best.seconds = span.iterations, time.monotonic() - began
    return best


def _worst(result: BoundResult) -> float:
    """The greatest miss. A load counts as a small one: a pose that can be done but for it is the better explanation."""
    if not result.violations:
        return 0.0
    worst = result.violations[0]
    return KEYFRAMES.load_violation if worst.kind in LOADS else worst.amount


def _alike(amounts: list[float], factor: float) -> int:
    """How many starts ended at the least violation, within a factor."""
    return sum(a <= factor * min(amounts) for a in amounts)


def _hopeless(amounts: list[float]) -> bool:
    """Whether independent starts without collisions ended far from feasible, or at the same least violation."""
    if len(amounts) < 2:
        return False
    least = min(amounts)
    if least > KEYFRAMES.hopeless or _alike(amounts, KEYFRAMES.alike) >= 3:
        return True
    return least > KEYFRAMES.far and _alike(amounts, KEYFRAMES.far_alike) >= 2


class SpanSolver:
    """Attempts at P_seq of some phases."""

    def __init__(
        self, skeleton: Skeleton, first: int, last: int, settings: MotionSettings, random: np.random.Generator,
        budget: Budget, start: Configuration, free: bool, end: Configuration | None = None,
    ) -> None:  # fmt: skip
        self.skeleton, self.first, self.last = skeleton, first, last
        self.settings, self.random, self.budget = settings, random, budget
        self.start, self.free, self.end = start, free, end
        self.options = SEQUENCE if last > first else SINGLE
        self.iterations = 0
        self.reached = False
        """Whether some attempt succeeded but for collisions."""
        self._programs: dict[bool, SwitchProgram] = {}
        modes = [p.mode for p in skeleton.phases[first : last + 1]]
        self._rings = any(ringed(skeleton.problem, mode) for mode in modes)
        self._walks = not free and any(passive_rings(skeleton.problem, mode) for mode in modes)

    def _at_rest(self) -> BoundResult | None:
        """An attempt in which the joints on closed rings keep their values: what stands on many feet can often do what
        it is to do with one limb alone, along paths that are soon found. It draws no numbers that others draw."""
        random, self.random = self.random, deepcopy(self.random)
        slices = self.guess(False, True)
        self.random = random
        switches = SwitchProgram(
            self.skeleton, self.first, self.last, self.start, self.settings, self.free, True, self.end, still=True
        )  # fmt: skip
        reached = self._solve_loose(switches, slices)
        if reached.violations:
            return None
        result = self.solve(switches, reached.configurations)
        return result if result.feasible else None

    def _after_walks(self) -> BoundResult | None:
        """Attempts from walks along closed rings with joints that have no drives, to the nearest postures in which all
        rows hold: such rings have few ways, and a minimum of the miss along them is often not 0. Of several that are
        found the one whose joints go the least."""
        found: list[tuple[float, BoundResult]] = []
        random = deepcopy(self.random)
        switches = self._program(True)
        phases = range(self.first, self.last + 1)
        for number in range(KEYFRAMES.walks):
            slices = [self.start, *guess(self.skeleton, phases, self.start, random, KEYFRAMES.noise, number > 1, True)]
            slices = walked(self.skeleton, self.first, slices, self.settings, random, self.budget)
            tolerance = self.settings.tolerance
            x = project(switches.loose, switches.pack(slices), tolerance, self.budget, KEYFRAMES.walk_projections)
            if switches.loose.largest(x) <= tolerance:
                result = self.solve(switches, switches.unpack(x), POLISH)
                if result.feasible:
                    found.append((_travel(result.configurations), result))
            if len(found) == KEYFRAMES.walks_found:
                break
        return min(found, key=lambda f: f[0])[1] if found else None

    def _program(self, frozen: bool) -> SwitchProgram:
        if frozen not in self._programs:
            self._programs[frozen] = SwitchProgram(
                self.skeleton, self.first, self.last, self.start, self.settings, self.free, frozen, self.end
            )  # fmt: skip
        return self._programs[frozen]

    def guess(self, wide: bool, steady: bool, clear: bool = False) -> list[Configuration]:
        """All slices, the state before included."""
        how = wide or clear, steady, clear
        if not self.free:
            phases = range(self.first, self.last + 1)
            return [self.start, *guess(self.skeleton, phases, self.start, self.random, KEYFRAMES.noise, *how)]
        phases = range(self.last + 1)
        return guess(self.skeleton, phases, self.start, self.random, KEYFRAMES.noise, *how)[self.first - 1 :]

    def search(self, warm: Sequence[Configuration] | None, tries: int) -> BoundResult:
        """Attempt after attempt, from `warm` first. Until one has succeeded so, a new guess is solved without
        collisions, which shows whether the span is out of reach, and from there with them. The first guess and its
        repair are steady. Once one has failed without collisions, guesses are no longer steady and take postures from
        anywhere: what fails from one kind of posture may be in reach from another."""
        best = nearest = None
        loose: list[float] = []
        full: list[float] = []
        if warm is None and self._rings:
            found = self._at_rest()
            if found is not None:
                return found
        for number in range(max(tries, KEYFRAMES.more_tries)):
            if number >= tries and (warm is not None or not self.reached):
                break
            switches = self._program(number % 2 == 0 or self.settings.still)
            given = warm is not None and number == 0
            period = KEYFRAMES.repair_period
            collided = self.reached and best is not None and number >= period
            steady = number < period and not loose
            slices = [self.start, *(warm or ())] if given else self.guess(bool(loose), steady, collided)
            if best is not None and number % period == 1:
                slices = _repair(switches, best.configurations, slices)
            elif (warm is None or number > 0) and not self.reached:
                reached = self._solve_loose(switches, slices)
                if reached.violations:
                    nearest = reached if nearest is None or _worst(reached) < _worst(nearest) else nearest
                    loose.append(_worst(reached))
                    found = self._after_walks() if len(loose) == 1 and self._walks else None
                    if found is not None:
                        return found
                    if _hopeless(loose):
                        return nearest
                    continue
                self.reached = True
                slices = reached.configurations
            result = self.solve(switches, slices)
            full.append(_worst(result))
            if best is None or full[-1] < _worst(best):
                best = result
            if result.feasible and self.settings.brief and number % 2 == 1:
                rested = self.solve(self._program(True), result.configurations)
                best = rested if rested.feasible else result
            if result.feasible or _alike(full, KEYFRAMES.alike) >= 3:
                return best
        found = best or nearest
        assert found is not None
        return found

    def _solve_loose(self, switches: SwitchProgram, slices: Sequence[Configuration]) -> BoundResult:
        """P_seq without collisions; feasible only if there are none to look at."""
        program = switches.loose
        outcome = run(program, switches.pack(slices), self.options, self.settings, self.budget)
        self.iterations += outcome.iterations
        tolerance = self.settings.tolerance
        violations = program.violations(outcome.x, tolerance) if program.largest(outcome.x) > tolerance else []
        configurations = switches.unpack(outcome.x)
        return BoundResult(Bound.SEQ, False, 0.0, 0.0, 0, configurations, [], violations, unobstructed=True)

    def solve(
        self, switches: SwitchProgram, slices: Sequence[Configuration], options: SolverOptions | None = None
    ) -> BoundResult:
        """P_seq, projected where it is nearly feasible; else with what is violated."""
        program, outcome = switches.solve(switches.pack(slices), options or self.options, self.budget)
        self.iterations += outcome.iterations
        x = outcome.x
        feasible = False
        if program.largest(x) <= self.settings.tolerance:
            program, x = switches.project(x, ACCURATE, self.budget)
            feasible = program.largest(x) <= ACCEPTED
        violations: list[Violation] = [] if feasible else program.violations(x, ACCEPTED)
        if feasible:
            x, violations = self._borne(switches, x)
            feasible = not violations
        return BoundResult(Bound.SEQ, feasible, program.cost(x), 0.0, 0, switches.unpack(x), [], violations)

    def _borne(self, switches: SwitchProgram, x: Array) -> tuple[Array, list[Violation]]:
        """Switch poses that can be done, changed where something there is too heavily loaded; and what still is. Rows
        of closed loops, which are dear, come in only where those of the rest leave something."""

        def exceeded(unknowns: Array) -> list[Violation]:
            return exceeded_switches(self.skeleton, self.first, switches.unpack(unknowns), self.free)

        violations, rows = exceeded(x), 0
        try:
            for loops in (False, True) if violations else ():
                before, rows = rows, switches.bear(loops)
                if not violations or rows == before:
                    continue
                _, outcome = switches.solve(x, self.options, self.budget)
                self.iterations += outcome.iterations
                program, changed = switches.project(outcome.x, ACCURATE, self.budget)
                if program.largest(changed) > ACCEPTED:
                    break
                x, violations = changed, exceeded(changed)
        finally:
            switches.bear(None)
        return x, violations


def _travel(configurations: Sequence[Configuration]) -> float:
    """How far all joints go from one to the next."""
    return sum(
        float(np.abs(other.modules[name][7:] - slot[7:]).sum())
        for one, other in pairwise(configurations) for name, slot in one.modules.items()
    )  # fmt: skip


def _repair(
    switches: SwitchProgram, previous: Sequence[Configuration], guesses: Sequence[Configuration]
) -> list[Configuration]:
    """All slices of the last attempt, but with new guesses next to the phases that were violated."""
    x = switches.pack(previous)
    switches.prepare(x)
    bad = {v.phase for v in switches.program().violations(x, 1e-3)}
    near = {phase + step for phase in bad for step in (-1, 0, 1)}
    phases = [switches.phases[0] - 1, *switches.phases]
    return [new if phase in near else old for phase, old, new in zip(phases, previous, guesses, strict=True)]


def judged_alone(skeleton: Skeleton, phase: int) -> bool:
    """Whether P_seq can be asked about phases from `phase` on alone, with an unknown state before. Not where a robot
    is fixed to the world more than once: starts at random seldom close its loops, and what holds looks refused."""
    if phase == 0:
        return True
    return not looped(skeleton.problem, skeleton.phases[phase].mode)
