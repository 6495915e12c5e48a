"""The numbers that steer the symbolic search."""

from __future__ import annotations

from ....compiler.settings import setting
from ....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """The numbers that steer the symbolic search."""

    recorded_nodes: int = setting(2000, "nodes", "How many nodes of the tree are kept for drawing.")
    clock_period: int = setting(128, "nodes", "After so many nodes the search looks whether its time is up.")
    renaming_from: int = setting(
        512, "nodes",
        "From so many nodes on it pays to go through renamed states only: fewer successor functions, but a plan "
        "to rename.",
    )
    hurried_weight: float = setting(
        1.5, "1",
        "Weight of the estimate of a search that has become long, and of method wastar.",
    )
    hurry_after: int = setting(
        50_000, "nodes",
        "Nodes that A* expands in one search before it hurries.",
        "60 times the most that a task of `bench thesis` takes (809); 2 to 50 s of CPU, as 28,000 to 1,000 nodes "
        "a second are expanded",
    )
    repairs: int = setting(
        8, "candidates",
        "Candidates in a row at most that are mended instead of searched from the start: others may have to help.",
        "not measured",
    )
    repair_nodes: int = setting(
        1000, "nodes",
        "Nodes that are expanded at most for another way of the robots of a candidate that motion refused, while the "
        "others do as before.",
        "4 to 60 are needed where a way of two to four actions of one robot is another",
    )
    penalty_power: int = setting(
        6, "1",
        "The power of an action's strain with which its penalty grows, and that slack is measured by.",
    )
    strained_from: float = setting(
        0.3, "1",
        "The least strain that is taken for the reason of a refusal.",
        "refusals of the examples have 0.6 and more; robots that never leave a large floor have 0.1 there, however far "
        "away things are",
    )
    penalty_first: float = setting(
        0.5, "cost",
        "The penalty of an action at the strain at which it was refused: at first.",
    )
    penalty_growth: float = setting(1.5, "1", "What it is multiplied by with each refusal.")
    penalty_most: float = setting(64.0, "cost", "What it is at most.")
    penalty_fading: float = setting(
        0.7, "1",
        "What is left of a penalty in the next search, once motion has accepted something.",
    )
    limit_forgetting: float = setting(0.9, "1", "What is left of how far a limit is below 1.")
    penalty_inherited: float = setting(2.0, "cost", "The most of a penalty in the next search.")
    slack_width: int = setting(
        400, "states",
        "States per layer that are kept when slack is maximised, least strained first.",
    )


SEARCH = SearchSettings()
