"""Modules that nothing carries: their frames stay where the scene puts them, as if they were bolted there."""

from __future__ import annotations

from ..ir import Fact, Problem
from ..kept_pairs import keeps_pose
from ..remembering import remembered


@remembered(256)
def bolted(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """The modules whose frames stay where they are at the start while `mode` holds: nothing carries them at the start,
    and nothing does now."""
    loose = frozenset(problem.world.modules) - _carried(problem, problem.init_motion)
    return loose - _carried(problem, mode) if loose else loose


def _carried(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """What follows something by the poses that a mode keeps; what is fixed to the scene is always the leader."""
    fixed = {b.name for b in problem.world.bodies.values() if not b.movable}
    pairs = [pair for pair in (keeps_pose(problem, literal) for literal in mode) if pair]
    ends = [problem.world.effector(a if b in fixed else b) or (a if b in fixed else b) for a, b in pairs]
    return frozenset(end if isinstance(end, str) else end[0].name for end in ends)
