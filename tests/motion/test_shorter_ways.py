"""Switches that were moved for the sake of an objective: all rows still hold, and what it counts got less."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from tamplang.compiler.objective_terms import spelled
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.planner.schedule.shorter_ways import with_shorter_ways
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Configuration, Skeleton

from .fixtures import climb_together, pick_and_place
from .test_sequence import check_feet


def seconds(skeleton: Skeleton, switches: list[Configuration]) -> float:
    """Of all phases, by the joint that takes longest from rest to rest along a straight way."""
    total = 0.0
    for before, after in pairwise(switches):
        times = [0.0]
        for name, module in skeleton.problem.world.modules.items():
            for joint, way in zip(
                module.type.joints, np.abs(after.modules[name][7:] - before.modules[name][7:]), strict=True
            ):
                rise = joint.speed**2 / joint.acceleration
                times.append(2 * np.sqrt(way / joint.acceleration) if way < rise else (way + rise) / joint.speed)
        total += max(times)
    return float(total)


def travel(skeleton: Skeleton, switches: list[Configuration]) -> float:
    """How far joints go, the lengths of all modules' straight ways."""
    return sum(
        float(np.linalg.norm(after.modules[name][7:] - before.modules[name][7:]))
        for before, after in pairwise(switches) for name in skeleton.problem.world.modules
    )  # fmt: skip


@pytest.mark.parametrize(
    ("skeleton", "objective", "measure"),
    [(climb_together(2, n=8), "duration", seconds), (climb_together(2, n=8), "makespan", seconds),
     (pick_and_place(3), "travel", travel)],
    ids=("duration", "makespan", "travel"),
)  # fmt: skip
def test_switches_get_better_by_the_objective(
    skeleton: Skeleton, objective: str, measure: Callable[[Skeleton, list[Configuration]], float]
) -> None:
    settings, budget = MotionSettings(objective=spelled(objective)), Budget(60.0)
    sequence = solve_sequence(skeleton, settings, Seed(0), budget)
    found = with_shorter_ways(skeleton, sequence, settings, Seed(0), budget)
    assert found is not None and found.feasible
    check_feet(skeleton, found.configurations)
    assert measure(skeleton, found.configurations) < 0.95 * measure(skeleton, sequence.configurations)
    again = with_shorter_ways(skeleton, sequence, settings, Seed(0), budget)
    assert again is not None
    assert measure(skeleton, again.configurations) == measure(skeleton, found.configurations)


@pytest.mark.parametrize("objective", ["actions", "energy"])
def test_what_does_not_depend_on_ways_leaves_switches_alone(objective: str) -> None:
    skeleton, settings = pick_and_place(1), MotionSettings(objective=spelled(objective))
    sequence = solve_sequence(skeleton, settings, Seed(0), Budget(60.0))
    assert with_shorter_ways(skeleton, sequence, settings, Seed(0), Budget(60.0)) is None
