"""The numbers that steer how robots are held to their strengths."""

from __future__ import annotations

from ....compiler.settings import setting
from ....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class StaticsSettings:
    """The numbers that steer how robots are held to their strengths."""

    looked_at: int = setting(
        41, "instants", "Instants of a phase at which loads are looked at.",
        "Measured on 16 plans: 6 find the worst within 0.8 %, 24 within 0.1 %; paths that give way to loads go along "
        "strengths, and 13 missed what the four times finer look at inertia then found. 4 ms for two arms.",
    )  # fmt: skip
    kept: float = setting(
        0.985, "1", "What is used of a strength, so that the worst between two instants keeps it, too.",
        "Twice the 0.8 % by which the worst was missed.",
    )  # fmt: skip
    kept_moving: float = setting(
        0.97, "1", "The same at rest where inertia counts as well, which needs room of its own.",
        "with all of what is kept used up at rest, real_climb n = 6 with docks of 2.8 N m had three of five candidates "
        "refused for 0.5 % that no slowness takes away",
    )  # fmt: skip
    room: float = setting(
        0.95, "1", "What is used of a strength by the rows of switches, for loads are greater on the way between them."
    )
    fine: int = setting(4, "instants per slice", "Instants per slice at which inertia is looked at.")
    slowest: float = setting(
        50.0, "times", "How many times as long a phase may take for its drives; what needs more hardly bears itself."
    )
    missed: float = setting(
        5e-3, "m", "By how much rows of switches may be missed where they tell how far out an end must come.",
        "P_seq takes what is within 0.1 mm to 2 mm: the bound may refuse nothing of that",
    )  # fmt: skip
    level: float = setting(
        1.0 - 1e-9, "1", "Cosine of its tilt from which on a top counts as level.", "not measured"
    )
    directions: int = setting(
        64, "directions", "In which it is looked how far out a place is.", "the best of them is short of that by 0.12 %"
    )


STATICS = StaticsSettings()
"""The numbers that steer how robots are held to their strengths."""
