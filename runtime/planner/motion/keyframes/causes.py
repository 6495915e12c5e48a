"""Why P_seq refuses some phases: what of the last one could be done if something of the scene were otherwise.

The rows of its literals at the switch give way first, so that what is missing gathers there. Where nothing is missing
without collisions, something is in the way; where nothing is without joint limits, these are; else it is out of reach.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from enum import StrEnum
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from .....compiler.ir import Fact, Problem
from .....compiler.kept_pairs import keeps_pose
from .....langs.frozen import dataclass
from ....budget import Budget
from ....geometry.attachments import followers, involved, looped
from ....seeds import Seed
from ....skeleton import Array, Configuration, Skeleton, Violation, start_configuration
from ..nlp.features import limits
from ..nlp.row_groups import LinearGroup, LinearWish
from ..settings import MotionSettings
from .keyframe_program import CLEARANCES, SwitchProgram, run
from .multi_start import SINGLE, SpanSolver
from .settings import KEYFRAMES


class Why(StrEnum):
    """What forbids a posture."""

    IN_THE_WAY = "in the way"
    LIMIT = "limit"
    RING = "ring"
    HELD = "held"
    CONTRADICTED = "contradicted"
    REACH = "reach"


@dataclass(frozen=True, slots=True)
class Cause:
    """Why a posture is refused, and the row of its literals that is missed least by all means but for that; what is
    `at` fault: the parts that are in the way, the joint and by how much it would have to go past its limit; or the
    `names` of the modules of a ring, of a literal that keeps where it is what would have to move, or of one that
    holds at that switch and without which nothing would be missed; where it is out of reach, of one that keeps an end
    of a robot, if one does. The `nearest` posture is the one that misses least, and where things are in the way, the
    one in which they overlap."""

    why: Why
    missed: Violation
    nearest: Configuration = field(compare=False, repr=False)
    at: tuple[Violation, ...] = ()
    names: tuple[str, ...] = ()


class _Yielding(SwitchProgram):
    """P_seq whose last switch gives way."""

    def _weight(self, phase: int) -> float:
        return KEYFRAMES.yielding if phase == self.phases[-1] else 1.0


class _Without(_Yielding):
    """The same without what a literal asks of the last phase while it lasts."""

    def __init__(self, left_out: Fact, *arguments: Any) -> None:
        self._left_out = left_out
        super().__init__(*arguments)

    def _excused(self, phase: int) -> frozenset[Fact]:
        return frozenset({self._left_out}) if phase == self.phases[-1] else frozenset()


class _Unlimited(SwitchProgram):
    """P_seq where it only costs what joints go past their limits."""

    def _limits(self, phase_of: list[int]) -> list[LinearGroup]:
        return [LinearWish(limits(self.problem, self.layout, 0.0, phase_of), KEYFRAMES.past_limits)]


@dataclass(frozen=True, slots=True)
class _Nearest:
    """The unknowns at which the rows of a program without collisions are missed least, and the worst of these."""

    program: SwitchProgram
    unknowns: Array
    missed: Violation

    @property
    def posture(self) -> Configuration:
        """At the switch of the last phase."""
        return self.program.unpack(self.unknowns)[-1]


def cause(
    skeleton: Skeleton, first: int, last: int, free: bool, settings: MotionSettings, seed: Seed, budget: Budget,
    switches: Sequence[Configuration],
) -> Cause | None:  # fmt: skip
    """Why phases `first` … `last` cannot follow each other, `free`: from anywhere; `switches` is where P_seq came to,
    the state before included. None where it is not plain, for one where another guess does it. Raises OutOfTime."""
    start = start_configuration(skeleton.problem)

    def nearest(kind: Callable[..., SwitchProgram]) -> _Nearest | None:
        program = kind(skeleton, first, last, start, settings, free)
        random = seed.child("cause").random()
        span = SpanSolver(skeleton, first, last, settings, random, budget, start, free)
        options = replace(span.options, projected=0.0, persistent=True)  # costs weigh as much as misses
        best: _Nearest | None = None
        guesses = (span.guess(wide=number > 1, steady=number == 0) for number in range(KEYFRAMES.causes_tried))
        known = [switches] if len(switches) == last - first + 2 else []
        for guess in chain(known, guesses):
            x = run(program.loose, program.pack(guess), options, settings, budget).x
            missed = program.loose.violations(x, 0.0)
            if missed and (best is None or missed[0].amount < best.missed.amount):
                best = _Nearest(program, x, missed[0])
        return best

    bound = nearest(_Yielding)
    if bound is None:
        return None
    if bound.missed.amount <= settings.tolerance:
        return _in_the_way(bound, settings, budget)
    unbound = nearest(_Unlimited)
    if unbound is not None and unbound.missed.amount <= settings.tolerance:
        past = _past_limits(unbound, settings.tolerance)
        return Cause(Why.LIMIT, bound.missed, bound.posture, past) if past else None
    for literal in _asking(skeleton, last, bound.missed.names):
        released = nearest(partial(_Without, literal))
        if released is not None and released.missed.amount <= settings.tolerance:
            return Cause(Why.CONTRADICTED, bound.missed, bound.posture, names=literal)
    ring = looped(skeleton.problem, skeleton.phases[last].mode) & involved(skeleton, last)
    mode = skeleton.phases[last].mode
    still = _kept_still(skeleton.problem, mode, bound.missed.names[1:])
    held = still or _holding(skeleton.problem, mode)
    why = Why.HELD if still else Why.RING if ring else Why.HELD if held else Why.REACH
    named = held if why == Why.HELD else tuple(sorted(ring))
    names = named or _kept_end(skeleton.problem, mode, bound.missed.names[1:])
    return Cause(why, bound.missed, bound.posture, names=names)


def _asking(skeleton: Skeleton, phase: int, missed: Fact) -> list[Fact]:
    """What asks something of a phase while it lasts, but for what keeps a pose."""
    problem = skeleton.problem
    rows = {literal: problem.motions[literal[0]].rows for literal in sorted(skeleton.phases[phase].mode - {missed})}
    return [
        literal
        for literal, found in rows.items()
        if keeps_pose(problem, literal) is None and any(row.when != "switch" for row in found)
    ]


def _kept_still(problem: Problem, mode: frozenset[Fact], names: Sequence[str]) -> Fact:
    """The first literal that keeps one of `names` to what rests, where nothing among these can move; else empty."""
    resting = problem.world.bodies.keys() - followers(problem, mode)
    keeping: dict[str, Fact] = {}
    for literal in sorted(mode):
        pair = keeps_pose(problem, literal) or ("", "")
        keeping |= {own: literal for own, other in (pair, pair[::-1]) if other in resting}
    moving = [name for name in names if name not in resting and name not in keeping]
    return () if moving else next((keeping[name] for name in names if name in keeping), ())


def _kept_end(problem: Problem, mode: frozenset[Fact], names: Sequence[str]) -> Fact:
    """A literal that keeps an end among `names` of a robot with drives to something else; empty where there is none."""
    ends = {name: problem.world.effector(name) for name in names}
    driven = {n for n, end in ends.items() if end is not None and any(not j.passive for j in end[0].type.joints)}
    return next((x for x in sorted(mode) if driven & set(keeps_pose(problem, x) or ())), ())


def _holding(problem: Problem, mode: frozenset[Fact]) -> Fact:
    """A literal that keeps what robots carry to what rests; empty where there is none."""
    carried = followers(problem, mode)
    resting = problem.world.bodies.keys() - carried
    for literal in sorted(mode):
        pair = keeps_pose(problem, literal)
        if pair and any(own in carried and other in resting for own, other in (pair, pair[::-1])):
            return literal
    return ()


def _past_limits(nearest: _Nearest, tolerance: float) -> tuple[Violation, ...]:
    """The joints that go past their limits, the farthest first."""
    program = nearest.program
    rows = limits(program.problem, program.layout, 0.0, [program.phases[0], *program.phases])
    amounts = rows.residuals(np.concatenate([program.layout.constants, nearest.unknowns]))[:, 0]
    found = {}
    for k in np.argsort(-amounts, kind="stable").tolist():
        label = rows.label(k)
        if amounts[k] > tolerance and label.names not in found:
            found[label.names] = Violation(label.phase, label.kind, label.names, float(amounts[k]), label.units[0])
    return tuple(found.values())


def _in_the_way(nearest: _Nearest, settings: MotionSettings, budget: Budget) -> Cause | None:
    """What meets where collisions count again, of that what overlaps most where they do not."""
    switches = nearest.program
    overlaps = switches.overlaps(nearest.unknowns)
    program, outcome = switches.solve(nearest.unknowns, SINGLE, budget)
    rows = [v for v in program.violations(outcome.x, settings.tolerance) if v.kind not in CLEARANCES]
    if not overlaps or not rows:
        return None
    return Cause(Why.IN_THE_WAY, rows[0], nearest.posture, tuple(overlaps[:1]))
