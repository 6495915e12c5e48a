"""Modules that break down in mid-run: what is left of the task, and whether a robot is lost with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...compiler import ir
from ...compiler.kept_pairs import kept_pairs
from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ..geometry.attachments import carrier, followers, involved, robots
from ..planner.receding.mid_run_state import Reached
from ..skeleton import Configuration, Phase, PhasePath, Skeleton
from .breakdowns import frozen, names_of, silent_of, without

EPSILON = 1e-9


@dataclass(frozen=True, slots=True)
class Failed:
    """The state without what has left; `lost` says why the run cannot go on."""

    reached: Reached
    lost: Diagnostic | None = None


class Failures:
    """The breakdowns of a problem as they happen."""

    def __init__(self, problem: ir.Problem) -> None:
        self._problem = problem
        self._coming = sorted(problem.world.breakdowns, key=lambda b: b.time)
        self.locked: set[str] = set()
        self.gone: set[str] = set()

    def until(self, time: float, reached: Reached) -> Failed:
        """Let all breakdowns up to a time happen."""
        while self._coming and self._coming[0].time <= time + EPSILON:
            breakdown = self._coming.pop(0)
            if breakdown.kind == ir.BreakdownKind.LOCKED:
                self.locked.add(breakdown.module)
                continue
            lost = self._lost(breakdown, reached)
            self.gone.add(breakdown.module)
            reached = _left(self._problem, breakdown.module, reached)
            if lost is not None:
                return Failed(reached, lost)
        return Failed(reached)

    def due(self, time: float) -> ir.Breakdown | None:
        """A breakdown up to a time that has not happened yet."""
        return next((b for b in self._coming if b.time <= time + EPSILON), None)

    def next_of(self, phase: Phase, time: float) -> ir.Breakdown | None:
        """The next breakdown that stops the phase: of a module of the robot that moves, or that the action names."""
        skeleton = Skeleton(self._problem, (phase,), phase.mode)
        moving = involved(skeleton, 0)
        group = robots(self._problem, phase.mode)
        leaders = {group[m] for m in moving}
        named = {carrier(self._problem, a) for literal in phase.added for a in literal[1:]}
        for breakdown in self._coming:
            concerned = group[breakdown.module] in leaders or breakdown.module in named
            if concerned and breakdown.time > time:
                return breakdown
        return None

    def base(self, problem: ir.Problem) -> ir.Problem:
        """The task without the modules that are gone."""
        for module in sorted(self.gone):
            problem = without(problem, module)
        return problem

    def stuck(self, problem: ir.Problem) -> ir.Problem:
        """The task, begun where it stands, with the joints of locked modules fixed."""
        for module in sorted(self.locked - self.gone):
            problem = frozen(problem, module)
        return problem

    def whole(self, path: PhasePath, configuration: Configuration) -> PhasePath:
        """A motion with the joints of modules that are stuck or gone, at rest."""
        modules = {}
        count = path.samples
        for name, state in configuration.modules.items():
            rows = path.modules.get(name)
            if rows is None:
                rows = np.tile(state, (count, 1))
            elif rows.shape[1] < len(state):
                rows = np.hstack([rows[:, :7], np.tile(state[7:], (count, 1))])
            modules[name] = rows
        return PhasePath(modules, path.bodies, path.duration)

    def _lost(self, breakdown: ir.Breakdown, reached: Reached) -> Diagnostic | None:
        """Why nothing can go on when a module leaves: it carries the rest of its robot, or holds something."""
        problem, module = self._problem, breakdown.module
        pairs = kept_pairs(problem, reached.mode)
        group = robots(problem, reached.mode)
        others = sorted(m for m in group if m != module and m not in self.gone and group[m] == group[module])
        carried = followers(problem, reached.mode)
        held = sorted({b for a, b in pairs if carrier(problem, a) == module and b in carried})
        what = ""
        if others and not _stands_without(problem, module, others, pairs):
            what = f"it carried {' and '.join(others)}"
        elif held:
            what = f"it held {' and '.join(held)}"
        if not what:
            return None
        message = f"{module} has left the scene at {breakdown.time:g} s; {what}"
        return Diagnostic("S0008", message, breakdown.span)


def _stands_without(problem: ir.Problem, module: str, others: list[str], pairs: tuple[tuple[str, str], ...]) -> bool:
    """Whether every other module of a robot is still kept, directly or through others, to a body."""
    linked = {b for b in problem.world.bodies}
    grew = True
    while grew:
        grew = False
        for pair in pairs:
            a, b = (carrier(problem, name) for name in pair)
            for known, other in ((a, b), (b, a)):
                if known in linked and other in others and other not in linked:
                    linked.add(other)
                    grew = True
    return set(others) <= linked


def _left(problem: ir.Problem, module: str, reached: Reached) -> Reached:
    gone = names_of(problem, module)
    return replace(reached, facts=silent_of(reached.facts, gone), mode=silent_of(reached.mode, gone))
