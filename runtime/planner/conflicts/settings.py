"""The numbers that steer what refusals teach."""

from __future__ import annotations

from ....compiler.settings import setting
from ....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class ConflictSettings:
    """The numbers that steer what refusals teach."""

    most_states: int = setting(
        200, "states",
        "Where more states can be reached than that, one state tells little of all.",
    )
    most_looks: int = setting(
        20_000, "conditions",
        "Conditions of ground actions that are looked at for the nearest miss.",
        "about 2 s",
    )
    similar_strain: float = setting(0.005, "1", "By how much strains may differ and still count as the same.")
    joints_named: int = setting(2, "joints", "Joints that would have to go past their limits that are named.")
    most_explained: int = setting(5, "refusals", "Refusals that are told to the user at most.")


CONFLICTS = ConflictSettings()
