"""The numbers that steer profiles and schedules."""

from __future__ import annotations

from ....compiler.settings import setting
from ....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class ScheduleSettings:
    """The numbers that steer profiles and schedules."""

    tick: float = setting(
        0.01, "s", "All begins, ends and knots of a schedule are multiples of it, so that rest and motion join.",
        "Rounding up costs half of it per phase, 1 % of short ones; twice as long is too coarse for ramps.",
    )  # fmt: skip
    most_ticks: int = setting(
        6000, "ticks", "A plan that takes longer has a longer tick: a file and its check grow with their number."
    )
    ramp: float = setting(
        0.04, "s", "Over so long accelerations change at least, from rest on: it bounds the jerk.",
        "Over 57 phases 0.05 s cost 6 % against unbounded jerk in the median, 0.1 s 12 %.",
    )  # fmt: skip
    ramp_share: float = setting(
        0.08, "1", "The same as a share of a short phase's time, so that no phase pays more than this for its ramps."
    )
    grid: int = setting(120, "points", "Points along a curve at which its speed is chosen.")
    dense: int = setting(40, "looks", "Looks at a curve per knot, by which its length is measured.")
    slower: int = setting(8, "times", "How often a profile is slowed down by what it is still too fast.")
    put_off: int = setting(
        5, "ticks", "By so much a start is put off while something is in the way, before it is brought nearer again."
    )
    rounds: int = setting(4, "rounds", "How often limits are lowered where the stored curve passes them.")
    fine: int = setting(4, "looks", "Looks per tick where two things that move come near each other.")
    near: float = setting(
        2e-3, "m", "What a moving thing keeps from one that rests elsewhere than when the motion was planned."
    )
    touch: float = setting(
        3e-4, "m", "How much nearer than at the switches two things may come; the verifier forbids three times as much."
    )
    clocked_nodes: int = setting(
        80, "nodes", "How many nodes the search with clocks expands at most behind a plan; with a gap more and more.",
        "Two arms and four things take 60; with four arms 500 took 3 s of CPU, three quarters of the plan itself, when "
        "a node took twice as long; with eight modules that dock 150 took 1.9 s, a third of it.",
    )
    usual_children: int = setting(
        8, "nodes", "Nodes of more children count for more where nodes are counted: what takes time are children.",
        "Two arms and four things have 7, four arms 18.",
    )
    nearer_nodes: int = setting(
        300, "nodes", "The same of the search behind it, which goes by the ways between postures that are known."
    )
    fresh_states: int = setting(
        15, "states", "And how many states they expand that no search has expanded before, up to numbers in them, with "
        "as many children as usual: each takes some 10 ms.",
        "With four modules that dock, whose names are told apart, 300 nodes took 4 s of CPU, half of the solve; 30 of "
        "eight modules, with ten times the children, took 4 s, too, and 15 in each search still a tenth.",
    )
    better: int = setting(
        4, "candidates", "How many candidates that may be better are taken to motion behind the first plan at most, "
        "where no gap is asked for: no more once the plan of one was not better.",
        "Each may cost as much as the plan itself.",
    )
    worthwhile: float = setting(
        0.05, "1", "By so much of its value a candidate must be better, as far as is known, to be taken to motion.",
        "Motions of one rule differ by more than this: what is gained on paper is lost in motion.",
    )
    detours: int = setting(
        60, "candidates", "After so many in a row that are plans found before, with a detour, no other is looked for.",
        "A single robot can walk about for ever; the four plans of `rendezvous` n=2 follow each other at once.",
    )
    shortenings: int = setting(
        1, "solves", "How often the ways between switches are weighted anew, with five steps of the solver each, "
        "before switches are settled.",
        "One gains 3 to 14 % of the makespan of six tasks in 0.1 to 0.25 s; two or three make ten plans 1 % "
        "shorter in the mean, one of them by 8 %, three longer, in twice the time.",
    )  # fmt: skip
    longest_shortened: int = setting(
        100, "phases", "Longer skeletons keep the switches that they have: one program holds them all."
    )
    shorter_by: float = setting(
        0.02, "1", "By so much of the objective switches must be better to get motions first.",
        "They may be harder to come by than those of P_seq, which are next.",
    )  # fmt: skip
    sharpness: float = setting(
        5.0, "1", "How much faster joints that take as long as their phase count than others: a power of the share.",
        "Of 2, 3, 5, 7 and 11, 5 and 7 gained most, 2 next to nothing, and above 7 it goes back and forth.",
    )  # fmt: skip
    pull: float = setting(
        0.01, "1", "The weight of ways that count for nothing: joints still go no farther than they need."
    )
    idle: float = setting(0.02, "1", "What a phase counts for that others outlast by far, as a share of what they do.")
    near_longest: float = setting(
        0.1, "1", "A chain that is shorter by this share of the longest counts for a third of what that does."
    )
    least_way: float = setting(
        0.05, "rad or m", "Shorter ways have the weights of this one: those of none would have no bound."
    )
    alike: float = setting(1e-6, "m or rad", "What stands so near to where it was rests: P_seq misses rows by less.")
    detour: float = setting(
        1.15, "1", "Where motions take so many times as long as straight ones, other ways are looked for.",
        "The fastest law takes 1.04 to 1.1 along a straight way.",
    )
    bent: int = setting(
        8, "starts", "How many bent starts each of them gets of each size, beside a straight one.",
        "Of eight, two to five led through in two phases of `rendezvous`, the best in 2.0 instead of 3.8 s and in 1.3 "
        "instead of 1.8 s, for 0.16 s of CPU each; of two chains that dock a straight start led through in 1.19 s, the "
        "best bent one in 0.95 s, for 0.3 s of CPU.",
    )
    bends: tuple[float, ...] = setting((0.3, 0.6), "rad or m", "How far these starts are bent.", "1 led through less.")
    orders: int = setting(4, "orders", "How many orders of priority are tried where things are in each other's way.")
    tight: float = setting(
        0.05, "1", "A schedule that takes no longer than this above its bound is good enough: no other order is tried.",
        "Of arms at one table 8 orders took a fifth of the solve to come from 3 % above the bound to 3 %.",
    )


SCHEDULE = ScheduleSettings()
"""The numbers that steer profiles and schedules."""
