"""P_seq: switch configurations of a skeleton (thesis section 3.2)."""

from __future__ import annotations

import time
from collections.abc import Sequence

from ....budget import Budget
from ....seeds import Seed
from ....skeleton import Bound, BoundResult, Configuration, Skeleton, start_configuration
from ..settings import MotionSettings
from .multi_start import SpanSolver, solve_span
from .placement_samples import places
from .settings import KEYFRAMES
from .sliding_windows import led_around, solve_windows
from .unwinding import unwound


def solve_sequence(
    skeleton: Skeleton,
    settings: MotionSettings,
    seed: Seed,
    budget: Budget,
    start: Configuration | None = None,
    warm: Sequence[Configuration] | None = None,
    tries: int | None = None,
) -> BoundResult:
    """P_seq of the whole skeleton from `start` (default: the scene at time 0). `warm` gives the K switch
    configurations to start from; `tries` how many starts a span gets at most, and in skeletons that are not long how
    often windows go back. Raises OutOfTime."""
    began = time.monotonic()
    origin = start or start_configuration(skeleton.problem)
    last = len(skeleton) - 1
    if last < 0:
        return BoundResult(Bound.SEQ, True, 0.0, 0.0, 0, [origin], [], [])
    random = seed.child("sequence").random()
    span = SpanSolver(skeleton, 0, last, settings, random, budget, origin, False)
    if len(skeleton) > KEYFRAMES.longest_whole and warm is None:
        result = solve_windows(skeleton, settings, seed, budget, origin, tries, patient=True)
    else:
        result = span.search(warm, tries or min(KEYFRAMES.tries, 4 + last))
        if not result.feasible and span.reached and len(skeleton) > KEYFRAMES.window and warm is None and tries is None:
            result = solve_windows(skeleton, settings, seed, budget, origin, KEYFRAMES.few_backtracks)
        elif result.feasible:
            result, spent = led_around(skeleton, 0, last, settings, random, budget, result)
            span.iterations += spent
    in_windows = result.feasible and len(skeleton) > KEYFRAMES.longest_whole and warm is None
    if in_windows and len(skeleton) <= KEYFRAMES.longest_polished and not places(skeleton):
        whole = span.search(result.configurations[1:], 1)
        result = whole if whole.feasible else result
    if result.feasible:
        result.configurations = unwound(skeleton.problem, result.configurations)
    result.iterations += span.iterations
    result.seconds = time.monotonic() - began
    return result


def window_feasible(
    skeleton: Skeleton, first: int, last: int, settings: MotionSettings, seed: Seed, budget: Budget
) -> BoundResult:
    """Whether phases `first` … `last` can follow each other at all: P_seq of these alone. For first > 0 the state
    before is unknown but for the relations that hold in it. `configurations` begins with that state."""
    origin = start_configuration(skeleton.problem)
    random = seed.child("window").random()
    return solve_span(skeleton, first, last, settings, random, budget, origin, free=first > 0)
