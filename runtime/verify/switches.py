"""Which modules an action binds; those rest at its switch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...compiler import ir
from ..plan import Plan
from .findings import Findings
from .kept_poses import kept, thing_of
from .replay import Story
from .splines import Spline


def check_switches(
    problem: ir.Problem, plan: Plan, story: Story, curves: Mapping[tuple[str, int], Spline], findings: Findings
) -> None:
    """Measure the rates of the joints of bound modules whose spline goes on through the switch; at its end a spline
    has none."""
    for phase, record in enumerate(plan.phases):
        through = sorted({m for m, k in curves if k == phase and curves.get((m, phase + 1)) is curves[m, phase]})
        if not through:
            continue
        bound = bound_by(problem, story, phase)
        for module in through:
            if module in bound:
                rate = float(np.max(np.abs(curves[module, phase](np.array([record.end]), 1))))
                message = f"{module} moves through the switch of {record.action}, which binds it"
                findings.measure("switch_rad_s", rate, message, time=record.end, between=[module])


def bound_by(problem: ir.Problem, story: Story, phase: int) -> frozenset[str]:
    """The modules that the action at the end of a phase binds: those that motion literals name which it adds or
    deletes, and the robots that these are part of, before or after."""
    before = story.modes[phase]
    after = story.modes[phase + 1] if phase + 1 < len(story.modes) else story.final
    changed = (before ^ after) | story.added[phase]
    named = {thing_of(problem, a) for literal in changed for a in literal[1:]} & problem.world.modules.keys()
    robots = [r for mode in (before, after) for r in _robots(problem, mode) if r & named]
    return frozenset(named).union(*robots)


def _robots(problem: ir.Problem, mode: frozenset[ir.Fact]) -> Iterator[set[str]]:
    """Modules that are linked with each other through kept poses."""
    robots: list[set[str]] = []
    for pair in kept(problem, mode):
        ends = {thing_of(problem, name) for name in pair}
        if ends <= problem.world.modules.keys():
            joined = [r for r in robots if r & ends]
            robots = [r for r in robots if not r & ends] + [ends.union(*joined)]
    return iter(robots)
