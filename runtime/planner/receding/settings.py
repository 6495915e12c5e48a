"""The numbers that steer a receding horizon."""

from __future__ import annotations

from ....compiler.settings import setting
from ....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class HorizonSettings:
    """The numbers that steer a receding horizon."""

    first_length: int = setting(4, "actions", "The adaptive horizon at first.")
    least_length: int = setting(2, "actions", "At least.")
    most_length: int = setting(16, "actions", "At most.")
    most_ordered: int = setting(64, "parts", "With more parts than this the order is that of the goal's text.")
    landmark_depth: int = setting(
        3, "actions",
        "How far back it is looked for what every way to a part of the goal needs.",
    )
    plan_length: int = setting(
        3, "windows",
        "So many windows long are plans for some parts of the goal at least: later windows then go on along them.",
    )
    lookahead: int = setting(
        2, "phases",
        "P_seq looks so many phases beyond the window, a whole window more for each time that what followed failed.",
        "two things in one slot, without a look beyond: 0 to 4 windows undone in 8 seeds, 0 to 16 where it never grows",
    )
    clocked_nodes: int = setting(
        300, "nodes", "Where seconds count, nodes of a window's search for what is done soonest, before the plain one."
    )
    few_parts: int = setting(
        3, "parts",
        "Up to so many unmet parts of the goal are planned for at once from the first try on.",
    )
    search_nodes: int = setting(300, "nodes", "Nodes that a search for the cheapest plan may expand.")
    hurried_nodes: int = setting(30000, "nodes", "And then a hurried one.")
    least_penalty: float = setting(
        1.0, "cost",
        "The penalty that an action at the limit of its conditions has at least, also before any was refused: "
        "windows then need fewer candidates, and runs promise no cheapest plan anyway.",
    )
    most_remembered: int = setting(
        4, "actions",
        "Refused beginnings of a window with two to so many actions are forbidden wherever their robots stand "
        "alike; one action only in the posture in which the window starts.",
    )
    candidates: int = setting(24, "plans", "Plans that are judged for one goal of one window.")
    alike: int = setting(
        3, "candidates",
        "After so many that are expected to be refused, the one that was refused is tried once more.",
    )
    hard: int = setting(2, "candidates", "So many refused candidates in one window make the adaptive horizon grow.")
    beginnings: int = setting(4, "times", "How often a run begins at least before it gives up.")
    motions: int = setting(
        2, "times",
        "How many motions a beginning gets before it is forbidden; and how often as many windows are undone "
        "before more.",
    )
    visits: int = setting(2, "times", "How often windows may start at the same facts.")
    shown_nodes: int = setting(200, "nodes", "Nodes of a window's search that are kept for drawing.")
    doubts: int = setting(
        2, "times",
        "How often a run that the verifier refuses is planned anew from the window that it blames.",
    )


RECEDING = HorizonSettings()
