"""P_seq of long skeletons by sliding windows with backtracking (design section 6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...compiler.motion.collision import keeps_pose
from ..budget import Budget
from ..skeleton import Array, BoundResult, Configuration, Skeleton
from .settings import MotionSettings
from .starts import guess, shake
from .switches import SwitchProgram

WINDOW = 4
COMMIT = 2
BACKTRACKS = 10
ANEW = 3
"""What a new start of the first window counts for."""
PERIOD = 2
"""Gaits repeat after two phases."""


def _support(skeleton: Skeleton, phase: int, configuration: Configuration) -> Array | None:
    """The mean position of the bodies on which a phase sets effectors down."""
    found = []
    for literal in sorted(skeleton.phases[phase].added):
        kept = keeps_pose(skeleton.problem, literal)
        if kept and kept[0] in configuration.bodies:
            found.append(configuration.bodies[kept[0]][:3])
    return np.mean(found, axis=0) if found else None


def _repeat(
    skeleton: Skeleton, phase: int, known: Sequence[Configuration], guessed: Configuration, random: np.random.Generator
) -> Configuration:
    """The switch one period back, moved along with its supports; the plain guess where nothing repeats."""
    if phase < PERIOD or skeleton.phases[phase].action.rule != skeleton.phases[phase - PERIOD].action.rule:
        return guessed
    earlier = known[phase - PERIOD + 1]
    here, there = _support(skeleton, phase, guessed), _support(skeleton, phase - PERIOD, earlier)
    if here is None or there is None:
        return guessed
    copy = shake(skeleton.problem, earlier, random, 0.03)
    for slot in copy.modules.values():
        slot[:3] += here - there
    for name in copy.bodies:
        copy.bodies[name] = guessed.bodies[name].copy()
    return copy


def _continue(
    skeleton: Skeleton, last: int, known: Sequence[Configuration], ahead: Sequence[Configuration],
    random: np.random.Generator,
) -> list[Configuration]:  # fmt: skip
    """A start for the switches behind `known` up to phase `last`: what the window before has found `ahead`, then
    the gait repeated."""
    from .sequence import NOISE

    found = [*known, *ahead]
    phases = range(len(found) - 1, last + 1)
    for phase, guessed in zip(phases, guess(skeleton, phases, found[-1], random, NOISE), strict=True):
        found.append(_repeat(skeleton, phase, found, guessed, random))
    return found[len(known) :]


def solve_windows(
    skeleton: Skeleton, settings: MotionSettings, random: np.random.Generator, budget: Budget, start: Configuration,
    tries: int | None = None,
) -> BoundResult:  # fmt: skip
    """Windows of four phases that commit two, each started from what the one before has found ahead, and then from the
    slice two phases back moved along with its supports. On failure the search goes back further each time, to start
    anew. Raises OutOfTime."""
    from .sequence import solve_span

    known = [start]
    ahead: list[Configuration] = []
    iterations = setbacks = 0
    while len(known) <= len(skeleton):
        first = len(known) - 1
        last = min(first + WINDOW, len(skeleton)) - 1
        warm = None if setbacks and not ahead else _continue(skeleton, last, known, ahead, random)
        result = solve_span(skeleton, first, last, settings, random, budget, known[-1], warm, tries=tries)
        iterations += result.iterations
        if result.feasible:
            kept = last - first + 1 if last == len(skeleton) - 1 else COMMIT
            known += result.configurations[1 : kept + 1]
            ahead = result.configurations[kept + 1 :]
            continue
        setbacks += 1 if first else ANEW
        if setbacks > (tries or BACKTRACKS):
            result.iterations = iterations
            return result
        del known[max(1, first + 1 - COMMIT * (1 + setbacks // 2)) :]
        ahead = []
    whole = SwitchProgram(skeleton, 0, len(skeleton) - 1, start, settings, frozen=False)
    cost = whole.program().cost(whole.pack(known))
    return BoundResult("seq", True, cost, 0.0, iterations, known, [], [])
