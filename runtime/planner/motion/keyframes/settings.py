"""The numbers that steer P_seq."""

from __future__ import annotations

from .....compiler.settings import setting
from .....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class KeyframeSettings:
    """The numbers that steer P_seq."""

    pressed: float = setting(
        2e-4, "m",
        "How deep what may touch may press into each other at switches.",
        "a fifth of what the verifier forbids",
    )
    met: float = setting(
        4e-4, "m",
        "The same of what comes together or parts at a switch, besides what rows ask of it.",
        "paths take 0.5 mm there",
    )
    most_redrawn: int = setting(
        24, "phases",
        "Phases of a stretch that are drawn anew at once; longer ones stay as they are.",
    )
    repair_noise: float = setting(0.4, "rad", "Radians by which joints are shaken for another start.")
    laid_out_from: int = setting(
        7, "things",
        "From how many things on a body on they are laid out; fewer find room from any guess.",
    )
    edge: float = setting(0.03, "m", "Metres kept to the edge of the top.")
    gap: float = setting(0.02, "m", "And between things at least, however they are turned.")
    tight_edge: float = setting(0.025, "m", "Where that leaves too little room: to the middles of things.")
    tight_gap: float = setting(0.03, "m", "And between things side by side.")
    widest_grid: float = setting(
        2.0, "1",
        "Grids get no wider than this, in widths of the largest thing: far corners may be out of reach.",
    )
    sweep_looks: int = setting(12, "places", "At how many places between two switches what slides is looked at.")
    sweep_through: float = setting(
        0.5, "1",
        "The share of its spheres whose centres lie in something at rest from which it goes right through.",
    )
    sweep_moved: float = setting(0.05, "m", "Metres that something must slide to be looked at.")
    longest_whole: int = setting(12, "phases", "Phases up to which one program holds the whole skeleton.")
    longest_polished: int = setting(
        40, "phases",
        "Phases up to which the whole is solved once more from what windows have found, for a cheaper one.",
        "takes as long as the windows: a fifth of climb n=256, 65 phases; of n=512, 129 phases, it was refused",
    )
    few_backtracks: int = setting(
        3, "times",
        "How often windows go back where the whole has failed only by its collisions.",
    )
    window: int = setting(
        4, "phases", "Phases of a window.",
        "climb n=512 takes 24.0 CPU s with windows of 4 phases, of which 2 are kept, 27.9 with 6 and 4, whose paths "
        "cost 8 % less; with 12 and 8 that of n=256 takes twice the steps",
    )
    commit: int = setting(2, "phases", "Phases that a window keeps.")
    backtracks: int = setting(10, "times", "How often windows go back, where nothing else is said.")
    patience: int = setting(6, "times", "How often windows go back at least before new ground is won.")
    anew: int = setting(3, "times", "What a new start of the first window counts for.")
    gait_period: int = setting(2, "phases", "Gaits repeat after two phases.")
    led_around: int = setting(
        3, "times",
        "How often a window is drawn anew in which something that slides would go right through what rests.",
    )
    stretched: float = setting(
        1.2, "1",
        "Before the windows, phases are tried alone that span this many times what the usual one of their rule "
        "does.",
    )
    most_stretched: int = setting(3, "phases", "At most so many.")
    postures_anywhere: int = setting(128, "postures", "How many postures are drawn from all that the joints can take …")
    postures_turned: int = setting(
        8, "postures",
        "… and how many in which one joint alone leaves its value, for each joint.",
    )
    posture_near: float = setting(0.1, "m", "Metres from the aim that are near enough: what is nearer is not better.")
    bent: float = setting(
        0.03, "m/rad",
        "Metres that a posture may be farther off if its joints are a radian nearer, in the mean.",
    )
    tilted: float = setting(0.2, "m", "Or for the sine of a small angle by which it is more upright.")
    averted: float = setting(
        0.5, "1",
        "What a share of the way between two modules counts for beside the sum of the normals of two docks that are to "
        "face each other.",
    )
    posture_steps: int = setting(30, "steps", "Gauss-Newton steps with which a posture is led to its aim at most.")
    posture_slow: float = setting(
        0.99, "1",
        "They end where one leaves more than this share of the miss. What is at a limit and pulled beyond it "
        "stays.",
    )
    posture_damping: float = setting(1e-4, "m²", "What is added to the squares of derivatives.")
    posture_closed: float = setting(1e-4, "m", "Metres from its aim at which a posture is there.")
    posture_difference: float = setting(
        1e-6, "rad or m",
        "Radians or metres by which joints are varied to see which way a hand can go.",
    )
    posture_rank: float = setting(
        1e-4, "1",
        "A direction in which a hand moves by less, as a share of what it can move at all, is none.",
    )
    walk_steps: int = setting(
        40, "steps", "Steps of a walk along a closed ring at most.", "a crank goes round in 30 of them"
    )
    walk_step: float = setting(0.25, "rad", "How far the joints of a ring move in a step, as a norm.")
    walk_open: float = setting(1e-3, "m or rad", "By how much a ring may be open on the way.")
    walk_slow: float = setting(0.1, "1", "A walk ends where a step is shorter than this share: at a limit.")
    walks: int = setting(8, "starts", "Starts from walks along closed rings, where the first start has failed.")
    walks_found: int = setting(3, "postures", "Of so many that walks have found the nearest is taken.")
    walk_projections: int = setting(40, "iterations", "With which what a walk has come to is put onto all rows.")
    clear_sides: int = setting(64, "directions", "From how many sides a thing is looked at for room for a hand.")
    clear_tries: int = setting(32, "postures", "At so many of these a hand is led to the thing …")
    clear_steps: int = setting(8, "steps", "… with so many Gauss-Newton steps.")
    clear_draws: int = setting(16, "guesses", "Of so many guesses the one with the least in the way is taken …")
    clear_enough: float = setting(0.02, "m", "… or the first with less than this.")
    clear_postures: int = setting(512, "postures", "From the nearest of so many postures that are drawn.")
    clear_touch: float = setting(5e-3, "m", "What spheres may be in a solid and count as beside it.")
    limit_inset: float = setting(0.1, "rad", "Radians by which guesses keep away from joint limits.")
    base_spread: float = setting(
        0.4, "1",
        "The share of a base's top, around its middle, over which guesses spread what is put down there.",
    )
    free_directions: int = setting(
        6, "directions",
        "Directions in which a hand can move with which a solve finds its way from any posture.",
    )
    noise: float = setting(0.3, "rad", "Standard deviation of the joints of a new start around what it starts from.")
    tries: int = setting(8, "starts", "Starts of a window where nothing else is said.")
    more_tries: int = setting(6, "starts", "Attempts that a span gets at least that can be done but for collisions.")
    repair_period: int = setting(2, "starts", "Every so many attempts the best one is repaired; the others start anew.")
    alike: float = setting(
        1.1, "1",
        "A span is refused when three starts end with the same largest row within this factor …",
    )
    far: float = setting(0.02, "m or rad", "… or two without collisions with more than this …")
    far_alike: float = setting(1.03, "1", "… alike within this factor …")
    hopeless: float = setting(0.15, "m or rad", "… or two without collisions with more than this.")
    homing_weight: float = setting(0.1, "1", "Weight of the distance of joints from their home.")
    velocity_weight: float = setting(0.3, "1", "Weight of the way of joints from switch to switch.")
    homeward_velocity: float = setting(
        0.03, "1", "The same where postures near the joints' home are looked for.",
        "of 12 docked crawlers 5 phases had no path without samples with 0.3, 2 with 0.03",
    )
    place_weight: float = setting(
        60.0, "1/m",
        "How strongly things are drawn to the places that are laid out for them, against homing and velocity.",
    )
    turn_weight: float = setting(3.0, "1", "And to lie turned as they lay at the start.")
    refreshes: int = setting(
        4, "solves",
        "How often pairs that came near during a solve are taken in and the solve is resumed.",
    )
    wish_scale: float = setting(
        10.0, "1/m",
        "The scale of wished clearances.",
        "they weigh as much as rows do at first: a margin that can be had is then missed by a fraction of a "
        "millimetre for the sake of homing",
    )
    causes_tried: int = setting(4, "starts", "Starts from which it is asked why a phase is refused.", "not measured")
    longest_cause: int = setting(3, "phases", "Phases that can be refused together at most for that to be asked.")
    yielding: float = setting(
        0.1, "1",
        "How much less the rows of a switch weigh than all else when it is asked why they are missed.",
        "a hundredth of what is missing is then left to other rows",
    )
    past_limits: float = setting(
        10.0, "1",
        "The scale of what joints go past their limits when it is asked how far they would have to.",
        "a millimetre of it is not left to homing, which would have joints go farther",
    )
    load_violation: float = setting(
        1e-6, "m",
        "What an excess of load counts against misses of rows: the last to be mended.",
    )



KEYFRAMES = KeyframeSettings()
