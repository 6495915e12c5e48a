"""Motions that take longer than they need are made anew behind the schedule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tamplang.api import loads
from tamplang.compiler.ir import Problem
from tamplang.runtime.budget import Budget
from tamplang.runtime.plan import Plan
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.planner.motion.time_scaling import shortest_duration
from tamplang.runtime.planner.schedule.at_once import AtOnce
from tamplang.runtime.planner.schedule.other_ways import OtherWays
from tamplang.runtime.planner.schedule.stage import Scheduler, Timed, configurations
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import PhasePath
from tamplang.runtime.verify import verify

from .test_at_once import PRESS

TOGETHER = PRESS.replace("0.65 m * cos(180 deg * k), 0, 0", "-0.7 m + 1.4 m * (k - 1), 0, 0")
"""The same two arms at either side."""


@pytest.fixture(scope="module")
def asked() -> tuple[Any, ...]:
    """Problem, skeleton, actions, paths and plan of a solve, as its schedule is asked for."""
    met: list[tuple[Any, ...]] = []
    shorter: Callable[..., Any] = AtOnce.shorter

    def noted(self: AtOnce, skeleton: Any, actions: Any, paths: Any, plan: Any, *more: Any, **names: Any) -> Any:
        met.append((skeleton.problem, skeleton, actions, paths, plan))
        return shorter(self, skeleton, actions, paths, plan, *more, **names)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(AtOnce, "shorter", noted)
        assert loads(TOGETHER).solve(time=300, minimise="makespan").plan is not None
    return met[0]


def bent(problem: Problem, path: PhasePath, by: float) -> PhasePath:
    """A path whose every moving joint is half-way off by so many radians."""
    wave = np.sin(np.pi * np.linspace(0.0, 1.0, path.samples))[:, None] ** 2
    modules = {}
    for name, rows in path.modules.items():
        moves = np.ptp(rows[:, 7:], axis=0) > 1e-9
        modules[name] = np.hstack([rows[:, :7], rows[:, 7:] - by * wave * moves])
    return replace(path, modules=modules, duration=shortest_duration(problem.world, modules))


def first(asked: tuple[Any, ...], paths: Sequence[PhasePath], ways: bool) -> Timed:
    problem, skeleton, actions, _, plan = asked
    budget, seed = Budget(300.0, None), Seed(0)
    other = OtherWays(problem, MotionSettings(), seed, budget) if ways else None
    made = Scheduler(problem, MotionSettings().margin, seed, budget, other)
    return next(made.plans(skeleton, actions, paths, plan.statistics))


def test_a_motion_that_winds_is_replaced(asked: tuple[Any, ...]) -> None:
    problem, _, _, paths, _ = asked
    winding = [bent(problem, paths[0], 0.8), *paths[1:]]
    straight, slow, again = first(asked, paths, False), first(asked, winding, False), first(asked, winding, True)
    assert slow.makespan > 1.2 * straight.makespan
    assert again.makespan < 1.05 * straight.makespan
    assert verify(again.plan).verified


def test_alone_a_motion_goes_through_where_others_rest(asked: tuple[Any, ...]) -> None:
    """The other robot is put where the one that moves ends."""
    problem, skeleton, _, paths, _ = asked
    switches = configurations(skeleton, paths)
    mover = next(m for m, rows in paths[0].modules.items() if np.ptp(rows[:, 7:]) > 1e-9)
    other = next(m for m in paths[0].modules if m != mover)
    lying = [c.then({**c.modules, other: switches[1].modules[mover]}, {}) for c in switches]
    look = OtherWays(problem, MotionSettings(), Seed(0), Budget(300.0, None))
    assert 0 not in look.found(skeleton, lying, {0}, alone=False)
    assert 0 in look.found(skeleton, lying, {0}, alone=True)


def test_where_nothing_winds_nothing_is_looked_for(asked: tuple[Any, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    def found(*_: Any, **__: Any) -> Any:
        raise AssertionError

    monkeypatch.setattr(OtherWays, "found", found)
    plan: Plan = first(asked, asked[3], True).plan
    assert verify(plan).verified
