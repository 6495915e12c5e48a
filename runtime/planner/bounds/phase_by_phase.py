"""Motion found phase by phase: each gets its path before the switch after the next is settled.

Where all switches are drawn first, every phase must have a path between the two that it got: of a dozen phases of long
chains half have none, and drawing all anew solves others while it loses those. Here a phase without a path has its own
switch drawn anew, those before it stay, and where that does not help the search goes back.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace

from ...budget import Budget
from ...seeds import Seed
from ...skeleton import Bound, BoundResult, Configuration, Skeleton, beginning, start_configuration
from ..motion.keyframes.multi_start import solve_span
from ..motion.keyframes.settings import KEYFRAMES
from ..motion.settings import MotionSettings
from .requests import Question, sequence_path
from .settings import BOUNDS


@dataclass(frozen=True)
class PhasesRequest(Question[tuple[list[Configuration], BoundResult | None]]):
    """The first `motions` phases of a skeleton one after the other: the switch configurations, the start and what was
    found ahead included, and P_seqPath; None where there is none."""

    settings: MotionSettings
    seed: Seed
    tries: int | None
    motions: int

    @property
    def key(self) -> Hashable:
        return self

    def solved(self, skeleton: Skeleton, budget: Budget) -> tuple[list[Configuration], BoundResult | None]:
        homeward = replace(self.settings, homeward=True)
        least = self.settings.switch_margin
        margin = most = max(least, BOUNDS.homeward_margin)
        rooms = [most] * self.motions  # the widest margins with which switches are not known to be none
        random = self.seed.child("phases").random()
        path = BoundResult(Bound.SEQ_PATH, True, 0.0, 0.0, 0, [start_configuration(skeleton.problem)], [], [])
        drawn = [0] * self.motions
        number = setbacks = farthest = 0
        while setbacks <= BOUNDS.phase_setbacks:
            phase, number = len(path.paths), number + 1
            drawn[phase] += 1
            last = min(phase + KEYFRAMES.window, len(skeleton)) - 1
            margin = min(margin, rooms[phase])
            wishes = replace(homeward, switch_margin=margin, still=margin > least)
            switches = solve_span(
                skeleton, phase, last, wishes, random, budget, path.configurations[-1], tries=self.tries
            )
            if switches.feasible:
                widest = BOUNDS.sampled_width if drawn[phase] == BOUNDS.phase_draws else 0.0
                found = self._onward(skeleton, path, switches, self.seed.child("phase", number), budget, widest)
                if found.feasible:
                    path = found
                    if phase + 1 == self.motions:
                        return [*path.configurations, *switches.configurations[2:]], path
                    drawn[phase + 1] = 0
                    if phase + 1 > farthest:
                        farthest, setbacks = phase + 1, 0
                    continue
                margin = most  # more room at both ends, where there is, leaves more ways between them
            else:
                rooms[phase] = max(least, 0.5 * margin)
            if drawn[phase] >= BOUNDS.phase_draws:
                setbacks += 1
                back = max(0, phase - 1 - setbacks // 2)
                path = replace(path, configurations=path.configurations[: back + 1], paths=path.paths[:back])
                drawn[back:] = [0] * (self.motions - back)
        return path.configurations, None

    def _onward(
        self, skeleton: Skeleton, path: BoundResult, switches: BoundResult, draw: Seed, budget: Budget, widest: float
    ) -> BoundResult:
        """P_seqPath of one phase more than `path` has."""
        known = [*path.configurations[:-1], *switches.configurations[:2]]
        longer = beginning(skeleton, len(known) - 1)
        return sequence_path(
            longer, replace(switches, configurations=known), self.settings, draw, budget, False, path, widest
        )
