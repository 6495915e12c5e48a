"""P_seq: switch configurations of a skeleton (thesis section 3.2.1; design section 6)."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from ..budget import Budget
from ..skeleton import Array, BoundResult, Configuration, Skeleton, Violation, start_configuration
from .program import Program
from .settings import MotionSettings
from .solver import Options
from .starts import guess
from .switches import SwitchProgram

SEQUENCE = Options()
NOISE = 0.3
TRIES = 8
SHORT = 3
"""Spans of up to so many phases start anew before an attempt is repaired."""
AGREE = 3
"""How many independent starts must fail alike before a span is refused."""
HOPELESS = 0.15
"""Refuse when all independent starts end with a largest row above this, in metres or radians …"""
ALIKE = 1.3
"""… or when so many are at the least violation within this factor; else take all tries."""
ACCURATE = 1e-6
LONGEST = 12
"""Phases up to which one program holds the whole skeleton."""


def solve_sequence(
    skeleton: Skeleton,
    settings: MotionSettings,
    seed: int,
    budget: Budget,
    start: Configuration | None = None,
    warm: Sequence[Configuration] | None = None,
    tries: int | None = None,
) -> BoundResult:
    """P_seq of the whole skeleton from `start` (default: the scene at time 0). `warm` gives the K switch
    configurations to start from; `tries` how many starts a span gets, and how often windows go back, at most. Raises
    OutOfTime."""
    from .windows import solve_windows

    began = time.monotonic()
    origin = start or start_configuration(skeleton.problem)
    last = len(skeleton) - 1
    if last < 0:
        return BoundResult("seq", True, 0.0, 0.0, 0, [origin], [], [])
    random = np.random.default_rng(seed)
    if len(skeleton) > LONGEST and warm is None:
        chained = solve_windows(skeleton, settings, random, budget, origin, tries)
        if not chained.feasible:
            chained.seconds = time.monotonic() - began
            return chained
        whole = solve_span(skeleton, 0, last, settings, random, budget, origin, chained.configurations[1:], tries=1)
        result = whole if whole.feasible else chained
        result.iterations = chained.iterations + whole.iterations
    else:
        result = solve_span(skeleton, 0, last, settings, random, budget, origin, warm, tries=tries)
    result.seconds = time.monotonic() - began
    return result


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
) -> BoundResult:
    """P_seq of phases `first` … `last`, with restarts. `configurations` begins with the state before `first`: `start`,
    or with `free` an unknown one, and `start` is then the scene at time 0."""
    began = time.monotonic()
    span = _Span(skeleton, first, last, settings, random, budget, start, free)
    best: BoundResult | None = None
    amounts: list[float] = []
    iterations = 0
    for attempt in range(tries or min(TRIES, 4 + last - first)):
        fresh = attempt % 3 != 1 or (attempt == 1 and last - first < SHORT)
        result = span.attempt(attempt, warm if attempt == 0 else None, None if fresh else best)
        iterations += result.iterations
        if best is None or _worst(result) < _worst(best):
            best = result
        if fresh:
            amounts.append(_worst(result))
        if result.feasible or _hopeless(amounts):
            break
    assert best is not None
    best.iterations, best.seconds = iterations, time.monotonic() - began
    return best


def _worst(result: BoundResult) -> float:
    return result.violations[0].amount if result.violations else 0.0


def _hopeless(amounts: list[float]) -> bool:
    """Whether independent starts ended far from feasible, or all at the same least violation."""
    if len(amounts) < AGREE:
        return False
    least = min(amounts)
    return least > HOPELESS or sum(a < ALIKE * least for a in amounts) >= AGREE


class _Span:
    """Attempts at P_seq of some phases."""

    def __init__(
        self, skeleton: Skeleton, first: int, last: int, settings: MotionSettings, random: np.random.Generator,
        budget: Budget, start: Configuration, free: bool,
    ) -> None:  # fmt: skip
        self.skeleton, self.first, self.last = skeleton, first, last
        self.settings, self.random, self.budget = settings, random, budget
        self.start, self.free = start, free
        self._programs: dict[bool, SwitchProgram] = {}

    def _program(self, frozen: bool) -> SwitchProgram:
        if frozen not in self._programs:
            self._programs[frozen] = SwitchProgram(
                self.skeleton, self.first, self.last, self.start, self.settings, self.free, frozen
            )  # fmt: skip
        return self._programs[frozen]

    def _guess(self, noise: float) -> list[Configuration]:
        """All slices, the state before included."""
        if not self.free:
            phases = range(self.first, self.last + 1)
            return [self.start, *guess(self.skeleton, phases, self.start, self.random, noise)]
        return guess(self.skeleton, range(self.last + 1), self.start, self.random, noise)[self.first - 1 :]

    def attempt(
        self, number: int, warm: Sequence[Configuration] | None, repair: BoundResult | None
    ) -> BoundResult:
        """One solve: from `warm`, from a new guess, or from `repair` with new guesses where it was violated."""
        switches = self._program(number % 2 == 0)
        slices = [self.start, *warm] if warm is not None else self._guess(NOISE * (1 + number % 2))
        if repair is not None:
            slices = _repair(switches, repair.configurations, slices)
        program, outcome = switches.solve(switches.pack(slices), SEQUENCE, self.budget)
        result = _result(switches, program, outcome.x, self.settings, self.budget)
        result.iterations = outcome.iterations
        return result


def _result(
    switches: SwitchProgram, program: Program, x: Array, settings: MotionSettings, budget: Budget
) -> BoundResult:
    """Project what is nearly feasible; report what is not."""
    feasible = False
    if program.largest(x) <= settings.tolerance:
        program, x = switches.project(x, ACCURATE, budget)
        feasible = program.largest(x) <= settings.tolerance
    violations: list[Violation] = [] if feasible else program.violations(x, settings.tolerance)
    return BoundResult("seq", feasible, program.cost(x), 0.0, 0, switches.unpack(x), [], violations)


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


def window_feasible(
    skeleton: Skeleton, first: int, last: int, settings: MotionSettings, seed: int, budget: Budget
) -> BoundResult:
    """Whether phases `first` … `last` can follow each other at all: P_seq of these alone. For first > 0 the state
    before is unknown but for the relations that hold in it. `configurations` begins with that state."""
    origin = start_configuration(skeleton.problem)
    random = np.random.default_rng(seed)
    return solve_span(skeleton, first, last, settings, random, budget, origin, free=first > 0)


def refine(
    skeleton: Skeleton,
    configurations: Sequence[Configuration],
    settings: MotionSettings,
    budget: Budget,
    tolerance: float = 1e-7,
) -> list[Configuration]:
    """The K + 1 switch configurations projected onto all rows of P_seq within `tolerance`."""
    switches = SwitchProgram(skeleton, 0, len(skeleton) - 1, configurations[0], settings, frozen=False)
    x = switches.pack(configurations)
    switches.prepare(x)
    return switches.unpack(switches.project(x, tolerance, budget)[1])
