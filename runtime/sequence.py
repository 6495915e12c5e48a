"""P_seq: switch configurations of a skeleton (thesis section 3.2.1; design section 6)."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from .budget import Budget
from .program import Program
from .settings import MotionSettings
from .skeleton import Array, BoundResult, Configuration, Skeleton, Violation, start_configuration
from .solver import Options
from .starts import guess
from .switches import SwitchProgram

SEQUENCE = Options()
NOISE = 0.3
TRIES = 8
HOPELESS = 0.15
"""A largest row above this after two starts refuses at once; nearer misses get all tries."""
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
) -> BoundResult:
    """P_seq of the whole skeleton from `start` (default: the scene at time 0). `warm` gives the K switch
    configurations to start from. Raises OutOfTime."""
    from .windows import solve_windows

    began = time.monotonic()
    origin = start or start_configuration(skeleton.problem)
    last = len(skeleton) - 1
    if last < 0:
        return BoundResult("seq", True, 0.0, 0.0, 0, [origin], [], [])
    random = np.random.default_rng(seed)
    if len(skeleton) > LONGEST and warm is None:
        chained = solve_windows(skeleton, settings, random, budget, origin)
        if not chained.feasible:
            chained.seconds = time.monotonic() - began
            return chained
        whole = solve_span(skeleton, 0, last, settings, random, budget, origin, chained.configurations[1:], tries=1)
        result = whole if whole.feasible else chained
        result.iterations = chained.iterations + whole.iterations
    else:
        result = solve_span(skeleton, 0, last, settings, random, budget, origin, warm)
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
    best: tuple[float, BoundResult] | None = None
    iterations = 0
    origin: Configuration = start
    previous: list[Configuration] | None = None
    for attempt in range(tries or min(TRIES, 4 + last - first)):
        switches = SwitchProgram(skeleton, first, last, start, settings, free, frozen=attempt % 2 == 0)
        if attempt == 0 and warm is not None:
            guesses = list(warm)
        else:
            guesses = guess(skeleton, range(0 if free else first, last + 1), start, random, NOISE * (1 + attempt % 2))
            if free:
                origin, guesses = guesses[first - 1], guesses[first:]
            if previous is not None and attempt % 4 != 3:
                origin, *guesses = _repair(switches, previous, [origin, *guesses])
        program, outcome = switches.solve(switches.pack([origin, *guesses]), SEQUENCE, budget)
        iterations += outcome.iterations
        result = _result(switches, program, outcome.x, settings, budget)
        result.iterations = iterations
        result.seconds = time.monotonic() - began
        worst = result.violations[0].amount if result.violations else 0.0
        if best is None or worst < best[0]:
            best = (worst, result)
        if result.feasible or (attempt >= 1 and best[0] > HOPELESS):
            break
        previous = result.configurations
    assert best is not None
    chosen = best[1]
    chosen.iterations, chosen.seconds = iterations, time.monotonic() - began
    return chosen


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
