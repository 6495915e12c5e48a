"""Things in the way of what some action does that another one could move away: a gate across the only door, a box in a
passage, a cup on the only place for another one."""

from __future__ import annotations

import math
from dataclasses import replace

from ....compiler.ir import Problem
from ....compiler.motion.collision import contacts
from ...budget import Budget
from ...geometry.attachments import followers
from ...seeds import Seed
from ...skeleton import BoundResult, Breach, Skeleton, beginning, start_configuration
from ..conflicts.lifting import objects_of
from ..motion.acceptance import clashes, dense
from ..motion.keyframes.keyframe_program import SwitchProgram
from ..motion.keyframes.sequence import window_feasible
from ..motion.phases.settings import PHASES
from ..motion.settings import MotionSettings
from .requests import sequence_path


def obstacles(
    skeleton: Skeleton, sequence: BoundResult, refused: BoundResult, settings: MotionSettings, seed: Seed,
    budget: Budget, sampled_to: float = math.inf,
) -> tuple[int, frozenset[str]]:  # fmt: skip
    """The first phase for which P_seqPath found no motion between the switches of `sequence`, and the bodies at their
    places of the start that keep it from having one though something could move them: without them there is a motion,
    which goes through these. None where what overlaps is less than a passage. Raises OutOfTime."""
    worst = min(refused.violations, key=lambda v: (v.phase, -v.amount))
    none = worst.phase, frozenset[str]()
    standing = _others(skeleton, 0, worst.phase)
    if worst.kind != Breach.COLLISION or worst.amount < PHASES.stuck or not standing:
        return none
    first = beginning(skeleton, worst.phase + 1)
    known = replace(
        refused, configurations=refused.configurations[: len(first) + 1], paths=refused.paths[: len(first)],
        violations=[v for v in refused.violations if v.phase == worst.phase],
    )  # fmt: skip
    clear = replace(first, problem=_without(skeleton.problem, standing))
    found = sequence_path(clear, sequence, settings, seed, budget, thorough=False, known=known, sampled_to=sampled_to)
    if not found.feasible:
        return none
    start = found.configurations[worst.phase]
    motion = dense(skeleton.problem, first.phases[-1].mode, found.paths[-1], start)
    met = clashes(skeleton.problem, worst.phase, contacts(first)[-1], motion, start)
    return worst.phase, standing.intersection(name for clash in met for name in clash.names)


def bystanders(
    skeleton: Skeleton, phase: int, refused: BoundResult, settings: MotionSettings, seed: Seed, budget: Budget
) -> frozenset[str]:
    """The bodies that keep P_seq from doing one phase alone, which it refuses, though they could be moved and are not
    what it is about: it refuses it with these alone as well, and not without them; that is believed where they are
    those that it names. None where it refuses it in any case. Raises OutOfTime."""
    problem = skeleton.problem
    movable = _others(skeleton, phase, phase)
    found: frozenset[str] = frozenset()
    if refused.unobstructed or not movable:
        return found
    named = movable.intersection(name for v in refused.violations for name in v.names)
    while found != movable:
        clear = replace(skeleton, problem=_without(problem, movable - found))
        result = window_feasible(clear, phase, phase, settings, seed, budget)
        if not result.feasible:
            return found
        met = _met(skeleton, phase, result, settings) & movable
        if met <= found:
            return frozenset()
        found |= met
        if found == named:
            break
    return found


def _met(skeleton: Skeleton, phase: int, result: BoundResult, settings: MotionSettings) -> frozenset[str]:
    """What overlaps at the switches around a phase."""
    start = start_configuration(skeleton.problem)
    switches = SwitchProgram(skeleton, phase, phase, start, settings, free=phase > 0)
    overlaps = switches.overlaps(switches.pack(result.configurations))
    return frozenset(name for v in overlaps for name in v.names)


def _others(skeleton: Skeleton, first: int, phase: int) -> frozenset[str]:
    """The bodies that can be moved, that nothing moves from phase `first` to `phase`, and that the last is not
    about."""
    problem = skeleton.problem
    moved = frozenset(objects_of(skeleton.phases[phase].action)).union(
        *(followers(problem, p.mode) for p in skeleton.phases[first : phase + 1])
    )
    return frozenset(b.name for b in problem.world.solids if b.movable and b.name not in moved)


def _without(problem: Problem, names: frozenset[str]) -> Problem:
    """The problem in which nothing collides with these bodies."""
    bodies = {n: replace(b, collides=False) if n in names else b for n, b in problem.world.bodies.items()}
    return replace(problem, world=replace(problem.world, bodies=bodies))
