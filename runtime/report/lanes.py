"""When each module moves and for what it waits, in plans whose robots work at once; and the chain of motions that makes
the plan as long as it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...langs.frozen import dataclass
from ..plan import Plan, SplineRecord
from .robots import effector_owners

REST = 1e-7
"""Radians or metres from one knot to the next: less is rest."""
TICK = 0.015
"""Seconds by which two instants differ that follow each other at once: switches are a hundredth apart."""


@dataclass(frozen=True, slots=True)
class Motion:
    """A module moves from `begin` to `end` seconds, for the switch of `phase` at `due`; it might have moved since
    `ready`, when its switch before took place."""

    module: str
    begin: float
    end: float
    phase: int
    due: float
    ready: float = 0.0

    @property
    def waits(self) -> float:
        """Seconds from the end of the motion to the switch."""
        return max(0.0, self.due - self.end)

    @property
    def is_held_up(self) -> float:
        """Seconds in which it might have moved already."""
        return max(0.0, self.begin - self.ready)


def works_at_once(plan: Plan) -> bool:
    """Whether some module moves through a switch."""
    return any(spline.until > spline.first for spline in plan.splines)


def motions(plan: Plan) -> list[Motion]:
    """All motions, in the order of their begins."""
    found = [motion for spline in plan.splines for motion in _of_spline(plan, spline)]
    found.sort(key=lambda m: (m.begin, m.phase, m.module))
    last: dict[str, Motion] = {}
    for number, motion in enumerate(found):
        if motion.module in last:
            found[number] = replace(motion, ready=max(last[motion.module].due, last[motion.module].end))
        last[motion.module] = motion
    return found


def _of_spline(plan: Plan, spline: SplineRecord) -> list[Motion]:
    """A spline may rest between two motions."""
    steps = np.abs(np.diff(np.asarray(spline.values, dtype=float), axis=0))
    moves = (steps.max(axis=1, initial=0.0) > REST).astype(int)
    changes = np.flatnonzero(np.diff(np.concatenate([[0], moves, [0]])))
    owners = effector_owners(plan)
    found = []
    for first, last in changes.reshape(-1, 2).tolist():
        begin, end = spline.knots[first], spline.knots[last]
        later = [k for k in range(spline.first, len(plan.phases)) if plan.phases[k].end >= end - TICK / 2.0]
        own = [k for k in later if spline.module in _named(plan, owners, k)]
        phase = (own or later or [spline.until])[0]
        found.append(Motion(spline.module, begin, end, phase, plan.phases[phase].end))
    return found


def _named(plan: Plan, owners: dict[str, int], phase: int) -> set[str]:
    """Modules that the action of a phase names, or what it adds."""
    record = plan.phases[phase]
    names = {a for literal in record.added for a in literal.args} | set(record.args)
    return {plan.modules[owners[n]].name for n in names if n in owners} | names


def critical(plan: Plan, found: Sequence[Motion]) -> set[int]:
    """The numbers of motions that the length of the plan hangs on: back from the last switch, always what ended last
    before."""
    chosen: set[int] = set()
    now = plan.phases[-1].end if plan.phases else 0.0
    while True:
        before = [k for k, m in enumerate(found) if m.end <= now + TICK and m.begin < now - TICK and k not in chosen]
        if not before:
            return chosen
        last = max(found[k].end for k in before)
        ending = [k for k in before if found[k].end >= last - TICK / 2.0]
        longest = max(ending, key=lambda k: found[k].end - found[k].begin)
        same = (found[longest].phase, found[longest].begin)
        chosen |= {k for k in ending if (found[k].phase, found[k].begin) == same}
        now = found[longest].begin
