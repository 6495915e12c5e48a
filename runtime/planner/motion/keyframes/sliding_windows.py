"""P_seq of long skeletons by sliding windows with backtracking."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from .....compiler.kept_pairs import keeps_pose, kept_pairs
from ....budget import Budget
from ....geometry.attachments import followers
from ....geometry.resampling import followed
from ....seeds import Seed
from ....skeleton import Array, Bound, BoundResult, Configuration, Skeleton, may_differ, start_configuration
from ..settings import MotionSettings
from .initial_guesses import guess, shake
from .keyframe_program import SwitchProgram
from .multi_start import judged_alone, solve_span
from .prismatic_sweeps import all_pierced, held_back
from .settings import KEYFRAMES


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
    before = phase - KEYFRAMES.gait_period
    if before < 0 or skeleton.phases[phase].action.rule != skeleton.phases[before].action.rule:
        return guessed
    earlier = known[before + 1]
    here, there = _support(skeleton, phase, guessed), _support(skeleton, phase - KEYFRAMES.gait_period, earlier)
    if here is None or there is None:
        return guessed
    copy = shake(skeleton.problem, earlier, random, 0.03)
    for slot in copy.modules.values():
        slot[:3] += here - there
    for name in may_differ(copy, guessed):
        copy.bodies[name] = guessed.bodies[name].copy()
    return copy


def _continue(
    skeleton: Skeleton, last: int, known: Sequence[Configuration], ahead: Sequence[Configuration],
    random: np.random.Generator,
) -> list[Configuration]:  # fmt: skip
    """A start for the switches behind `known` up to phase `last`: what the window before has found `ahead`, then
    the gait repeated."""
    found = [*known, *ahead]
    phases = range(len(found) - 1, last + 1)
    for phase, guessed in zip(phases, guess(skeleton, phases, found[-1], random, KEYFRAMES.noise), strict=True):
        found.append(_repeat(skeleton, phase, found, guessed, random))
    return found[len(known) :]


def _stretch(skeleton: Skeleton, phase: int) -> float:
    """The largest distance between the resting bodies to which a phase and its switch fix something, in metres."""
    problem, bodies = skeleton.problem, skeleton.problem.world.bodies
    mode, added = skeleton.phases[phase].mode, skeleton.phases[phase].added
    carried = followers(problem, mode)
    kept = kept_pairs(problem, mode | added)
    names = sorted({name for pair in kept for name in pair if name in bodies and name not in carried})
    return max((math.dist(bodies[a].pose[:3], bodies[b].pose[:3]) for a, b in combinations(names, 2)), default=0.0)


def _outliers(skeleton: Skeleton) -> list[int]:
    """The phases that span much more than others of their rule, the farthest first."""
    spans = [_stretch(skeleton, phase) for phase in range(len(skeleton))]
    by_rule: dict[str, list[float]] = {}
    for phase, span in zip(skeleton.phases, spans, strict=True):
        by_rule.setdefault(phase.action.rule, []).append(span)
    usual = {rule: float(np.median(found)) for rule, found in by_rule.items()}
    far = [k for k, phase in enumerate(skeleton.phases) if spans[k] > KEYFRAMES.stretched * usual[phase.action.rule]]
    return sorted(far, key=lambda k: -spans[k])[:KEYFRAMES.most_stretched]


class _Alone:
    """Phases tried alone, from an unknown state: what is refused so no window can do."""

    def __init__(
        self, skeleton: Skeleton, settings: MotionSettings, seed: Seed, budget: Budget, tries: int | None
    ) -> None:  # fmt: skip
        self.skeleton, self.settings, self.seed, self.budget, self.tries = skeleton, settings, seed, budget, tries
        self.iterations = 0
        self._done: set[tuple[int, ...]] = set()

    def refused(self, phase: int) -> BoundResult | None:
        """The refusal of a phase; None where it can be done, was asked for before, or cannot be judged alone."""
        return self._asked(phase) if phase else None

    def window(self, first: int, last: int) -> BoundResult | None:
        """The refusal of the phases of a window that failed, without what comes before; None as above."""
        return self._asked(first, last)

    def _asked(self, *ends: int) -> BoundResult | None:
        first, last = ends[0], ends[-1]
        if ends in self._done or not judged_alone(self.skeleton, first):
            return None
        self._done.add(ends)
        origin, random = start_configuration(self.skeleton.problem), self.seed.child(*ends).random()
        result = solve_span(
            self.skeleton, first, last, self.settings, random, self.budget, origin, free=True, tries=self.tries
        )  # fmt: skip
        self.iterations += result.iterations
        return None if result.feasible else replace(result, window=(first, last))


def led_around(
    skeleton: Skeleton, first: int, last: int, settings: MotionSettings, random: np.random.Generator, budget: Budget,
    found: BoundResult,
) -> tuple[BoundResult, int]:  # fmt: skip
    """The switches of a window, drawn anew while something that slides would have to go right through what rests and
    this makes fewer phases so; and the iterations that this took."""
    iterations = 0
    bad = all_pierced(skeleton, first, found.configurations)
    for _ in range(KEYFRAMES.led_around):
        if not bad:
            break
        warm = held_back(skeleton, first, found.configurations, bad)
        again = solve_span(
            skeleton, first, last, settings, random, budget, found.configurations[0], warm[1:], tries=1
        )  # fmt: skip
        iterations += again.iterations
        left = all_pierced(skeleton, first, again.configurations) if again.feasible else bad
        if len(left) >= len(bad):
            break
        found, bad = again, left
    return found, iterations


def solve_windows(
    skeleton: Skeleton, settings: MotionSettings, seed: Seed, budget: Budget, start: Configuration,
    tries: int | None = None, patient: bool = False,
) -> BoundResult:  # fmt: skip
    """Windows that commit their first phases, each started from what the one before has found ahead, and then from the
    slice two phases back moved along with its supports. On failure the search goes back further each time, to start
    anew up to where it failed, until it comes farther than before; `tries` bounds the starts of a window, and with
    `patient` not how often it goes back. Phases that span the most, and those that a window blames, are tried alone
    first; where `tries` are bounded, so are windows that failed. Raises OutOfTime."""
    alone = _Alone(skeleton, settings, seed.child("alone"), budget, tries)
    random = seed.child("windows").random()
    for phase in _outliers(skeleton):
        refusal = alone.refused(phase)
        if refusal is not None:
            refusal.iterations = alone.iterations
            return refusal

    known = [start]
    ahead: list[Configuration] = []
    most = max(KEYFRAMES.patience, tries or KEYFRAMES.backtracks) if patient else tries or KEYFRAMES.backtracks
    iterations = setbacks = farthest = again = 0
    while len(known) <= len(skeleton):
        first = len(known) - 1
        last = max(again, min(first + KEYFRAMES.window, len(skeleton)) - 1)
        warm = None if setbacks and not ahead else _continue(skeleton, last, known, ahead, random)
        result = solve_span(skeleton, first, last, settings, random, budget, known[-1], warm, tries=tries)
        iterations += result.iterations
        if result.feasible:
            result, spent = led_around(skeleton, first, last, settings, random, budget, result)
            iterations += spent
            kept = last - first + 1 - (0 if last == len(skeleton) - 1 else KEYFRAMES.window - KEYFRAMES.commit)
            for phase, found in enumerate(result.configurations[1 : kept + 1], first):
                known.append(followed(skeleton.problem, skeleton.phases[phase].mode, known[-1], found))
            ahead, again = result.configurations[kept + 1 :], 0
            continue
        refusal = alone.refused(result.violations[0].phase) if result.violations else None
        if refusal is None and tries is not None:
            refusal = alone.window(first, last) if first else replace(result, window=(0, last))
        if refusal is not None:
            refusal.iterations = iterations + alone.iterations
            return refusal
        if first >= farthest + KEYFRAMES.commit:
            farthest, setbacks = first, 0
        setbacks += 1 if first else KEYFRAMES.anew
        if setbacks > most:
            result.iterations = iterations + alone.iterations
            return result
        del known[max(1, first + 1 - KEYFRAMES.commit * (1 + setbacks // 2)) :]
        ahead, again = [], last if last - len(known) + 2 <= KEYFRAMES.longest_whole else 0
    whole = SwitchProgram(skeleton, 0, len(skeleton) - 1, start, settings, frozen=False)
    cost = whole.loose.cost(whole.pack(known))
    return BoundResult(Bound.SEQ, True, cost, 0.0, iterations + alone.iterations, known, [], [])
