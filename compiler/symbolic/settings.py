"""The numbers that bound the compiled logic."""

from __future__ import annotations

from ...langs.frozen import dataclass
from ..settings import setting


@dataclass(frozen=True, slots=True)
class SymbolicSettings:
    """The numbers that bound the compiled logic."""

    most_instances: int = setting(64, "facts", "Instances of a literal that are looked at for who achieves it.")
    estimate_depth: int = setting(3, "actions", "How many preconditions deep the estimate looks.")
    single_lengths: int = setting(
        4, "lengths",
        "So many single lengths from an object are looked up one by one before all of them are computed at once.",
    )
    single_values: int = setting(4, "values", "Up to so many values of a variable are compared one by one.")
    compiled_from: int = setting(
        32, "calls",
        "Successors of states with the same flags are compiled as one function after so many calls.",
        "compiling takes some 6 ms with 8 robots, where a search meets 530 words in 320 nodes",
    )
    remembered_answers: int = setting(
        4, "words",
        "Kinds of flag words for which the values of some variables of a rule are kept.",
    )
    most_alternatives: int = setting(
        16, "alternatives",
        "Alternatives of a condition that are split into flat rules at most.",
    )
    known_names: int = setting(10000, "formulas", "Formulas of which the free names are kept.")
    renamed_from: int = setting(
        2, "modules",
        "Below this many interchangeable modules the renaming costs more than it saves.",
    )
    strips_alternatives: int = setting(
        64, "alternatives",
        "Alternatives of a condition in the delete relaxation at most.",
    )
    strips_facts: int = setting(4096, "facts", "Facts of a delete relaxation at most.")
    pddl_chains: int = setting(
        2000, "actions",
        "Kinds of chains, or of pairs of them, that one rule may be about in PDDL.",
        "16 modules that are all alike have 120 pairs; 2000 actions take some 2 s",
    )
    pddl_denied_chains: int = setting(
        10, "orders",
        "Orders in which modules could be docked, for conditions in PDDL that deny a chain.",
        "two modules have 4; three have 15, 78 with the ways through them",
    )
    pddl_choices: int = setting(
        512, "choices",
        "Choices of ends for the variables of a rule that each become an action in PDDL; beyond, they are parameters.",
        "8 robots that step have 256; four feet and four sockets have a million",
    )
    pddl_branches: int = setting(64, "branches", "Actions that one rule may become as PDDL.")
    pddl_name: int = setting(
        60, "letters",
        "Length of a name in PDDL.",
        "some readers have a limit for lines or files",
    )


SYMBOLIC = SymbolicSettings()
