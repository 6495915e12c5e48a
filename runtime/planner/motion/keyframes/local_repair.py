"""Switches drawn anew where phases between them have found no path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .....langs.frozen import dataclass
from ....budget import Budget
from ....seeds import Seed
from ....skeleton import BoundResult, Configuration, Skeleton
from ..settings import MotionSettings
from .multi_start import solve_span
from .settings import KEYFRAMES


@dataclass(frozen=True, slots=True)
class Mend:
    """Switches are drawn anew between the failed phases and `around` more on both sides, from a start in which the
    failed ones end where they begin; with a `draw`, from shaken joints instead."""

    around: int
    draw: int = 0


QUICK_MENDS = (Mend(1), Mend(2), Mend(3))
"""Those after which phases that are still hard fail soon."""
MENDS = (*QUICK_MENDS, Mend(1, 1), Mend(2, 2))


def unmoved(configurations: Sequence[Configuration], failed: Sequence[int]) -> list[Configuration]:
    """Switch configurations as a start in which the failed phases end where they begin."""
    result = [configuration.copy() for configuration in configurations]
    for phase in failed:
        result[phase + 1] = result[phase].copy()
    return result


def resampled(configurations: Sequence[Configuration], failed: Sequence[int], seed: Seed) -> list[Configuration]:
    """Switch configurations as a start, with new joint values at both ends of the failed phases."""
    random = seed.random()
    changed = {k for phase in failed for k in (phase, phase + 1)} - {0}
    result = []
    for k, configuration in enumerate(configurations):
        fresh = configuration.copy()
        if k in changed:
            for values in fresh.modules.values():
                values[7:] += random.normal(0.0, KEYFRAMES.repair_noise, len(values) - 7)
        result.append(fresh)
    return result


def spans(failed: Sequence[int], around: int, phases: int) -> list[tuple[int, int]]:
    """First and last phase of the stretches that hold the failed phases with `around` more on both sides; those that
    overlap are one."""
    found: list[tuple[int, int]] = []
    for phase in sorted(failed):
        first, last = max(0, phase - around), min(phases - 1, phase + around)
        if found and first <= found[-1][1]:
            first = found.pop()[0]
        found.append((first, last))
    return found


def mended(
    skeleton: Skeleton, sequence: BoundResult, refused: BoundResult, mend: Mend, settings: MotionSettings, seed: Seed,
    budget: Budget, tries: int | None = None,
) -> BoundResult:  # fmt: skip
    """P_seq of stretches around the phases that `refused` blames, each from the switch before it to the one after it,
    which stay. Infeasible when no stretch could be done; those that could not be stay as they are. Raises
    OutOfTime."""
    failed = sorted({v.phase for v in refused.violations})
    configurations = list(sequence.configurations)
    own = seed.child("mend", mend.around, mend.draw)
    warm = resampled(configurations, failed, own.child("start")) if mend.draw else unmoved(configurations, failed)
    random = own.random()
    iterations, done = 0, 0
    for first, last in spans(failed, mend.around, len(skeleton)):
        if last - first >= KEYFRAMES.most_redrawn:
            continue
        end = configurations[last + 1] if last + 1 < len(skeleton) else None
        found = solve_span(
            skeleton, first, last, settings, random, budget, configurations[first], warm[first + 1 : last + 2],
            tries=tries, end=end,
        )  # fmt: skip
        iterations += found.iterations
        if found.feasible:
            kept = last + 1 if end else last + 2
            configurations[first + 1 : kept] = found.configurations[1 : kept - first]
            done += 1
    return replace(sequence, feasible=done > 0, configurations=configurations, iterations=iterations)
