"""The numbers that steer the motion programs, in one place. SI units."""

from __future__ import annotations

from dataclasses import replace

from ....compiler.objectives import ACTIONS, Objective
from ....compiler.settings import setting
from ....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """`slices` per phase on a path; `margin` wished for between surfaces along a path and `switch_margin` at switches,
    metres, and nothing is refused for less;
    `limit_margin` pulls joint limits in at switches, radians; `tolerance` is the largest violation of a single row
    that still counts as feasible (metres or radians). With `polish`, motions become cheaper once they are feasible.
    With `homeward`, switches are found where joints are near their home, however far they go to get there; with `still`
    only those robots move to a switch that it concerns.
    What an `objective` adds up beside actions is looked at where switches are found: robots that a switch does not
    concern rest again where it was found with all of them moving, and ways get shorter."""

    slices: int = 20
    margin: float = 0.02
    switch_margin: float = 0.025
    limit_margin: float = 0.03
    tolerance: float = 2e-3
    solver: str = "algn"
    collisions: bool = True
    polish: bool = True
    homeward: bool = False
    still: bool = False
    objective: Objective = ACTIONS

    @property
    def brief(self) -> bool:
        """Whether anything but actions counts."""
        return self.objective != ACTIONS

    def wider(self, by: float) -> MotionSettings:
        """The same with `by` metres more between surfaces, along paths and at switches."""
        return replace(self, margin=self.margin + by, switch_margin=self.switch_margin + by)


@dataclass(frozen=True)
class AcceptanceSettings:
    """The numbers that steer how motions are accepted, timed and written."""

    samples_per_slice: int = setting(5, "samples", "Looks at a path per slice, at least.")
    samples: int = setting(200, "samples", "Looks at a phase, at least.")
    eased_density: int = setting(2, "samples", "Samples of an eased phase per sample of the planner.")
    shortest_phase: float = setting(0.1, "s", "Least duration of a phase.")
    limit_share: float = setting(
        0.9999, "1",
        "What is used of a limit.",
        "rounded figures keep it, too",
    )
    stored_density: int = setting(3, "samples", "Samples of the plan file per sample of the planner.")


ACCEPTANCE = AcceptanceSettings()
