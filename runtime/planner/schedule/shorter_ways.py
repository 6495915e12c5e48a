"""Switches with regard to the objective: postures between which the longest chain of motions is short.

A phase lasts as long as its slowest joint, and only phases of the longest chain count for the makespan. P_seq minimises
squares; here squares are weighted anew after each solve, so that those of slow joints in phases that matter count most
(iteratively reweighted least squares for the sum of largest times).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ....langs.frozen import dataclass
from ...budget import Budget
from ...seeds import Seed
from ...skeleton import Array, BoundResult, Configuration, PhasePath, Skeleton, may_differ
from ..motion.keyframes.keyframe_program import POLISH, SwitchProgram
from ..motion.keyframes.multi_start import SpanSolver
from ..motion.keyframes.unwinding import unwound
from ..motion.nlp.augmented_lagrangian import SolverOptions
from ..motion.nlp.row_groups import LinearGroup
from ..motion.settings import MotionSettings
from .dependencies import Precedence, precedence
from .least_times import least_time
from .list_schedule import scheduled, tails
from .settings import SCHEDULE

NEAR = SolverOptions(damping=1e-2, inner_tolerance=3e-2, iterations=5)
"""From switches that stand: small weights of rows let postures slide along them, and steps need little damping. Rows
need to hold only in the end, where they are held to with large weights."""


@dataclass(frozen=True, slots=True)
class _Ways:
    """What a sequence of switches takes: by phase and module how far each joint goes, radians or metres, and seconds of
    each; and by phase the seconds of its motion and how much these count for the objective."""

    away: tuple[Mapping[str, Array], ...]
    seconds: tuple[Mapping[str, Array], ...]
    longest: tuple[float, ...]
    counts: tuple[float, ...]
    value: float


def with_shorter_ways(
    skeleton: Skeleton, sequence: BoundResult, settings: MotionSettings, seed: Seed, budget: Budget
) -> BoundResult | None:
    """The switches of a feasible `sequence` moved so that the objective gets better by what motions take at least; None
    where it does not by enough to be tried, or does not depend on ways. Raises OutOfTime."""
    weights = dict(settings.objective.weights)
    if not weights.keys() & {"makespan", "duration", "travel"} or len(skeleton) > SCHEDULE.longest_shortened:
        return None
    last, switches = len(skeleton) - 1, sequence.configurations
    program = _program(skeleton, switches, settings)
    if program is None:
        return None
    span = SpanSolver(skeleton, 0, last, settings, seed.child("ways").random(), budget, switches[0], False)
    first = ways = _ways(skeleton, switches, weights)
    rounds, pulls = [], None
    for _ in range(SCHEDULE.shortenings):
        pulls = _pulls(skeleton, ways, weights, pulls)
        program.pull([_rows(program, pulls)])
        _, outcome = program.solve(program.pack(switches), NEAR, budget)
        switches = program.unpack(outcome.x)
        ways = _ways(skeleton, switches, weights)
        rounds.append((ways.value, switches))
    result = span.solve(program, min(rounds, key=lambda r: r[0])[1], POLISH)
    switches = unwound(skeleton.problem, result.configurations)
    ways = _ways(skeleton, switches, weights)
    if not result.feasible or ways.value > (1.0 - SCHEDULE.shorter_by) * first.value:
        return None
    return replace(sequence, configurations=switches, iterations=sequence.iterations + span.iterations)


def _program(
    skeleton: Skeleton, switches: Sequence[Configuration], settings: MotionSettings
) -> SwitchProgram | None:
    """P_seq with what rests in these switches at rest, first the joints of closed rings, then robots that a switch does
    not concern; None where these switches are not of its form."""
    last = len(skeleton) - 1
    for frozen, still in ((True, True), (True, False), (False, False)):
        program = SwitchProgram(skeleton, 0, last, switches[0], settings, frozen=frozen, still=still)
        kept = program.unpack(program.pack(switches))
        if not any(_apart(a, b) for a, b in zip(kept, switches, strict=True)):
            return program
    return None


def _apart(one: Configuration, other: Configuration) -> bool:
    """Whether something stands otherwise in two configurations."""
    pairs = [(slot, other.modules[name]) for name, slot in one.modules.items()]
    pairs += [(one.bodies[name], other.bodies[name]) for name in may_differ(one, other)]
    return not all(np.allclose(a, b, atol=SCHEDULE.alike) for a, b in pairs)


def _ways(skeleton: Skeleton, switches: Sequence[Configuration], weights: Mapping[str, float]) -> _Ways:
    modules = skeleton.problem.world.modules
    away, seconds, paths = [], [], []
    for before, after in pairwise(switches):
        ways = {name: np.abs(after.modules[name][7:] - before.modules[name][7:]) for name in modules}
        away.append(ways)
        seconds.append({
            name: np.array([least_time(j, float(w)) for j, w in zip(modules[name].type.joints, way, strict=True)])
            for name, way in ways.items()
        })  # fmt: skip
        ends = {name: np.stack([before.modules[name], after.modules[name]]) for name in modules}
        bodies = {name: np.stack([before.bodies[name], after.bodies[name]]) for name in may_differ(before, after)}
        slowest = max((float(s.max(initial=0.0)) for s in seconds[-1].values()), default=0.0)
        paths.append(PhasePath(ends, bodies, slowest))
    order = precedence(skeleton, paths, SCHEDULE.tick)
    makespan, shares = _chains(order)
    timed, every = weights.get("makespan", 0.0), weights.get("duration", 0.0)
    travel = weights.get("travel", 0.0) * sum(float(np.linalg.norm(w)) for ways in away for w in ways.values())
    longest = tuple(path.duration for path in paths)
    counts = tuple(timed * share + every for share in shares)
    return _Ways(tuple(away), tuple(seconds), longest, counts, timed * makespan + every * sum(longest) + travel)


def _chains(order: Precedence) -> tuple[float, list[float]]:
    """Seconds until the last switch where nothing is in the way, and by phase 1 on the longest chain, less for those
    that have time left."""
    behind = tails(order)
    free = scheduled(order, None, behind)
    assert free is not None
    end = max(1, free.end)
    left = [end - (start or 0) - tail for start, tail in zip(free.starts, behind, strict=True)]
    shares = [SCHEDULE.idle + math.exp(-max(0, ticks) / (SCHEDULE.near_longest * end)) for ticks in left]
    return SCHEDULE.tick * free.end, shares


_Pulls = Mapping[tuple[int, str], Array]
"""By phase and module, `(n,)`: the weights of the squares of what its joints go."""


def _pulls(skeleton: Skeleton, ways: _Ways, weights: Mapping[str, float], before: _Pulls | None) -> _Pulls:
    """Weights with which squares change as the objective does near these switches, in the mean with those before."""
    modules = skeleton.problem.world.modules
    found: dict[tuple[int, str], Array] = {}
    for k, (away, seconds) in enumerate(zip(ways.away, ways.seconds, strict=True)):
        for name, way in away.items():
            joints = modules[name].type.joints
            at_least = np.maximum(way, SCHEDULE.least_way)
            rates = np.array([
                min(j.speed, math.sqrt(j.acceleration * w)) for j, w in zip(joints, at_least, strict=True)
            ])  # fmt: skip
            share = (seconds[name] / ways.longest[k]) ** SCHEDULE.sharpness if ways.longest[k] > 0.0 else 0.0
            pull = ways.counts[k] * share / rates / at_least + SCHEDULE.pull
            pull = pull + weights.get("travel", 0.0) / max(float(np.linalg.norm(way)), SCHEDULE.least_way)
            found[k, name] = pull if before is None else np.sqrt(pull * before[k, name])
    return found


def _rows(program: SwitchProgram, pulls: _Pulls) -> LinearGroup:
    """½ Σ pull · (way of a joint)² as rows of P_seq."""
    layout = program.layout
    places: list[Array] = [np.zeros((0, 2), dtype=np.int64)]
    scales: list[Array] = [np.zeros(0)]
    for (k, name), pull in pulls.items():
        if layout.is_unknown(k, name) or layout.is_unknown(k + 1, name):
            entries = layout.joints(name)
            places.append(np.stack([layout.slot(k, name)[entries], layout.slot(k + 1, name)[entries]], axis=1))
            scales.append(np.sqrt(pull[entries - 7]))
    scale = np.concatenate(scales)[:, None]
    return LinearGroup("cost", np.concatenate(places), scale * [-1.0, 1.0], np.zeros(len(scale)), [])
