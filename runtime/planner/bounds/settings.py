"""The numbers that steer which bound is asked for what."""

from __future__ import annotations

from ....compiler.settings import setting
from ....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class BoundSettings:
    """The numbers that steer which bound is asked for what."""

    longest_conflict: int = setting(3, "phases", "How many phases a conflict that may start anywhere has at most.")
    wider_margin: float = setting(0.01, "m", "Metres by which margins grow for a plan that the verifier refused.")
    first_starts: int = setting(1, "starts", "Starts of a span of a whole skeleton at first.")
    conflict_reach: int = setting(4, "phases", "How far from the phases that P_seq blames a conflict is looked for.")
    readmissions: int = setting(
        3, "times",
        "How often refused candidates may come again where some had switches, but no motion between them.",
        "where a hand must come close, as to three convex bodies, one draw of four finds a path: a round of five "
        "draws then ends without in one run of four",
    )
    answer_period: float = setting(
        0.05, "s",
        "Seconds after which whoever waits for an answer looks at the clock, and lets Ctrl-C through.",
    )
    queued: int = setting(
        3, "questions",
        "Questions under way for each process that answers, so that none waits for the next one.",
    )
    always_refused: int = setting(
        3, "pairs of poses",
        "Between how many pairs of poses a phase must fail before it is refused wherever it starts.",
    )
    kept_answers: int = setting(
        32_000_000, "bytes",
        "What a process keeps of answers, to find them when it solves the same task again.",
        "one of climb n=8 takes 5 to 30 kB, a whole solve 0.3 MB",
    )
    largest_answer: int = setting(
        2_000_000, "bytes", "Larger answers are not kept: a few of them would push out all else.", "not measured"
    )
    kept_scenes: int = setting(256, "scenes", "Scenes whose answers are kept; a horizon has one for each window.")
    recent_problems: int = setting(
        4, "problems",
        "So many problems are told apart without looking at them; those before are dropped, and found again by what"
        " they say.",
        "a solve has one, or two where its unit of length is not the metre",
    )
    quick_starts: int = setting(3, "starts", "Starts of a span before a skeleton is refused for the first time.")
    redraws: int = setting(
        4, "times",
        "How often all switch poses are drawn anew at least when mending them around phases without a path does "
        "not help.",
    )
    quick_redraws: int = setting(
        12, "times",
        "The same before, where some phase closes a loop, without a look for a way among samples.",
        "two arms that carry one beam over their heads: a draw takes 0.4 CPU s, that look ten",
    )
    least_reach: float = setting(
        0.1, "m", "Robots of which the largest comes no less far than this, and …",
        "a cube of 10 cm that docks; P_seq of a gantry with ways of 1 cm misses its rows",
    )
    greatest_reach: float = setting(
        10.0, "m", "… no farther than that, are planned for in metres; others in their reach, or, where only what they "
        "slide is longer, such that they reach so far.",
        "P_seq of a gantry with ways of 20 m misses its rows by metres; of 20 or 30 units, too",
    )
    path_effort: int = setting(
        400_000, "iterations × unknowns",
        "What P_path of one skeleton may take.",
        "about 12 s, at 25 to 50 µs each",
    )
    long_way_after: int = setting(
        2, "draws",
        "After so many, where nothing but one phase has no path, that is looked for once …",
        "not measured",
    )
    long_way_slices: int = setting(
        80, "slices", "… in so many, if it has fewer, with trees that grow for the square as many rounds.",
        "a rover through three walls of a hall of 4 m is solved with 80 slices, not with 20",
    )
    soon_redraws: int = setting(
        1, "times",
        "The same, where something is in the way that could be moved.",
        "a rover before a shut gate took 12 s for each of 16 draws",
    )
    redrawn_phases: int = setting(
        32, "phases",
        "So many phases are drawn anew in all where none closes a loop.",
        "a draw then takes some 40 ms for each, P_path of the same 4 s; grasping a convex body takes up to 13 draws",
    )
    left_out: int = setting(
        8, "candidates", "So many in a row are left out as they are like refused ones, then one of them is asked.",
        "where all things are alike, one refusal of the first two holds for all; of 0.6 s each with 32 things",
    )
    by_phases_from: int = setting(
        8, "phases", "From how many phases on motion is looked for phase by phase where it was refused, …",
        "motion of fewer is found as soon by drawing all switches anew",
    )
    by_phases_to: int = setting(
        40, "phases", "… and up to how many: of more, single ones are mended.",
        "each draw goes through all phases before it",
    )
    whole_to: int = setting(
        10, "phases", "Of up to so many switches are drawn anew once before, phases without a way moving little.",
        "chains of 8 modules, seeds 1, 2, 4, without an objective: 12.3, 13.3, 9.4 s of motion in 20 CPU s instead of "
        "15.7, 13.3, 13.3 s in 22; of 12, seeds 0 to 2, it found one of three, in 50 CPU s instead of 43",
    )
    phase_draws: int = setting(
        3, "draws",
        "How often the switch after a phase is drawn before the one before it is drawn anew, the last time with a look "
        "for a way among samples …",
        "with 8 and 4 draws those that fail at first fail on: the state before them is at fault",
    )
    sampled_width: float = setting(
        64.0, "joints", "… where no more joints move.",
        "a way among samples of 84 took 5 to 20 s and a gigabyte, another draw 1 s",
    )
    first_sampled: float = setting(
        14.0, "joints",
        "Where motion may be looked for phase by phase, only phases of no more joints get that look before it is.",
        "8 docked modules: 1 to 1.5 of 8 CPU s, after which all switches were drawn anew all the same",
    )
    phase_setbacks: int = setting(
        16, "times", "How often it goes back, farther every other time, before new ground is won.",
        "16 docked crawlers, seed 2: 11",
    )
    homeward_margin: float = setting(
        0.1, "m",
        "What switches are then to keep from all else, at first: half as much where none are found so, and until it is "
        "the usual margin only those move to a switch that it concerns.",
        "with 0.2 none are found among 16 crawlers that stand 0.2 m apart, with 0.1 none among 24 that stand 0.13 "
        "apart; ways of 168 joints, where all move, take 5 s to refuse, others 0.1",
    )
    loaded_redraws: int = setting(
        2, "times",
        "How often switch poses are drawn anew between which something is too heavily loaded on the way.",
        "a draw takes 1 to 4 s there, as other ways are looked for, too; real_climb, seed 1: 28 CPU s with ten, 21 so",
    )



BOUNDS = BoundSettings()
