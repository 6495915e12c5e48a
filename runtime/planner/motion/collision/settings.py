"""The numbers that steer clearances of motion programs."""

from __future__ import annotations

from .....compiler.settings import setting
from .....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class CollisionSettings:
    """The numbers that steer clearances of motion programs."""

    near: float = setting(
        0.3, "m",
        "Pairs closer than this at the start of a solve take part in it; the others are looked at afterwards.",
    )
    listed_runs: int = setting(
        256, "bodies",
        "Up to so many things beside one robot each pair of a part and a thing is listed once for a program; of more, "
        "those near the robot are picked out each time.",
        "picking takes some 50 us, which more than 5 robots times 256 listed pairs take",
    )
    broken: float = setting(1e-4, "m", "By how much a pair that was left out overlaps and is told.")
    anchor_arm: float = setting(
        0.1, "m",
        "From the origin of a part to its anchors on the axes.",
        "about a link's size, which keeps rounding small",
    )
    anchors: int = setting(
        4, "points",
        "The most anchors of a part; those of a part with fewer are repeated.",
        "four points fix a frame",
    )


COLLISION = CollisionSettings()
