"""The numbers that steer P_seqPath."""

from __future__ import annotations

from .....compiler.settings import setting
from .....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class PhaseSettings:
    """The numbers that steer P_seqPath."""

    levels: tuple[tuple[int, float, float], ...] = setting(
        ((6, 0.3, 0.5), (8, 0.5, 1.0), (16, 0.8, 0.5)), "starts, rad, 1",
        "After a straight start, one attempt after the other: starts per phase, the size of their bumps, radians, "
        "and how far the first of them goes towards the joints' home instead.",
    )
    quick_levels: int = setting(1, "attempts", "Of these so many before a skeleton is refused for the first time.")
    quick_rounds: int = setting(
        60, "rounds",
        "How often trees of samples grow before they count as not to be connected, at first.",
    )
    usual_slices: int = setting(
        20, "slices",
        "Of so many times as many slices, trees grow for the square of that times as many rounds, and so many times as "
        "many corners are cut: who gives more than usual expects a long way.",
        "a rover through three walls of a hall of 4 m: of two seeds none in 1,000 rounds, one in 2,000 of 8 edges",
    )
    far_wider: float = setting(
        2.0, "1",
        "Phases of so many times the joints of one without a path among samples are spared it at first.",
        "of 12 docked crawlers one with 28 joints fails in 2 CPU s, one with 84 takes 16 to find a path",
    )
    rounds: int = setting(120, "rounds", "And at last.")
    phases_per_try: int = setting(
        8, "phases", "Of every so many phases more there is one more look for a way among samples, …",
        "the more phases there are the dearer it is to draw the switches of all anew for one without a path",
    )
    most_tries: int = setting(3, "looks", "… at most so many, …", "not measured")
    once_from: float = setting(
        4.0, "1", "… but for phases of so many times the joints of the narrowest ones, which are looked at once.",
        "a look at 84 joints takes ten times as long as one at 28",
    )
    cuts: tuple[int, ...] = setting(
        (8, 16), "cuts",
        "How often corners of a sampled polyline are cut for each of the starts along it.",
    )
    repaired: float = setting(0.06, "m", "A path that misses its clearance by less, metres, is pushed away once more.")
    repair_looks: tuple[int, ...] = setting(
        (2, 4), "looks per slice",
        "How often per slice it is then looked at, one time after the other.",
    )
    hopeless: float = setting(
        5e-3, "m",
        "A path on which the optimiser's spheres, which lie within the shapes, overlap by more, metres, is not "
        "checked.",
    )
    acceleration_weight: float = setting(
        0.1, "1",
        "Weight of squared second differences of joints against squared first ones.",
    )
    homing_weight: float = setting(0.2, "1", "Weight of the squared distance of joints from their home.")
    no_penalty: float = setting(
        1e-3, "1",
        "A penalty that counts as none: a phase that has more goes on until the weight is at its greatest.",
    )
    lot: int = setting(
        60_000, "spheres",
        "Phases are improved in lots with about so many spheres at a time, which bounds the memory and fits the "
        "caches.",
    )
    patience: int = setting(15, "iterations", "Iterations before a phase may be given up.")
    stuck: float = setting(
        0.03, "m",
        "A phase is given up when spheres overlap by more then: things have passed each other.",
    )
    many_pairs: int = setting(
        2_000, "pairs",
        "Of more pairs of spheres of moving things, boxes around the spheres of each joint are looked at first.",
        "a crawler has some hundred, a chain of eight more than ten thousand",
    )
    many_part_pairs: int = setting(
        300, "pairs", "Of more pairs of true shapes, boxes around all of each thing are looked at first.",
        "two docked crawlers have 105, four 465; twelve took half a gigabyte otherwise",
    )
    made: float = setting(1e-4, "rad or m", "How near to its end a path comes that was made, radians or metres.")
    many_spheres: int = setting(
        16, "spheres", "From how many spheres of its cover on the optimiser sees a box or a cylinder as it is.",
        "two cubes of six flat parts take a fifth of the time so",
    )
    same_pose: float = setting(
        1e-5, "m",
        "By how much the poses of things at rest may differ, metres, and be the same.",
    )
    pair_lot: int = setting(
        500_000, "pairs",
        "Pairs of spheres that are looked at at once, which is what a process can hold.",
        "a tenth of a second",
    )
    touching: float = setting(
        2e-4, "m",
        "How deep two things may press into each other at looks at a path.",
        "a fifth of what the verifier forbids, as they may be deeper between two looks",
    )
    contact_tolerance: float = setting(
        5e-4, "m",
        "The same of a contact that begins or ends, which rows at switches may miss by more.",
    )
    pressed: float = setting(
        9.9e-4, "m",
        "The same of what overlaps at the start by less than what `check` lets pass, which the verifier does, too.",
    )
    refinement: int = setting(10, "samples", "Samples of the swept check per slice.")
    deepest: float = setting(
        8e-4, "m",
        "How deep two things may press into each other between two looks at a path.",
        "the verifier forbids 1 mm, and curves are taken for straight between looks",
    )
    closer_looks: int = setting(
        8, "looks",
        "Between two looks, to either side, where things pass each other so fast that they may be deeper there.",
        "a box passed another at 0.1 m/s, 1.2 mm deep between two looks that saw 0.2 mm",
    )
    closer_lot: int = setting(
        128, "times", "At so many times at once.", "climb n=128: all at once took 80 MB",
    )
    far: float = setting(
        1e-3, "m",
        "Excess clearance beyond which nothing is measured: more counts as this much.",
    )
    limits_above: float = setting(
        100.0, "1",
        "How much heavier than a missed clearance the excess over a joint limit weighs.",
        "no wish may push joints to it",
    )
    closely: float = setting(
        3e-3, "m",
        "What true shapes are kept apart, where they are looked at.",
        "more than they come nearer between looks",
    )
    next_to_ends: float = setting(
        0.1, "slices", "How far from either end paths that are looked at between slices are looked at, too.",
        "a palm was 1 mm deep in a crate there, and clear a quarter of a slice from the end",
    )
    least_share: float = setting(
        0.05, "1", "The least share of the margin by whose inverse a missed clearance next to a contact counts more.",
    )
    negligible: float = setting(
        0.02, "1",
        "Slices that count less at a time between others get nothing of the Hessian there.",
    )
    limit_inset: float = setting(
        0.02, "rad or m",
        "How far inside their limits joints are kept while a path is optimised.",
    )
    greatest_step: float = setting(
        0.5, "rad or m",
        "The largest change of a joint between neighbouring slices.",
    )
    blame_stride: int = setting(
        5, "samples",
        "Where a refused path is looked at first for what is in its way: every so many of the fine times.",
    )
    edge_resolution: float = setting(
        0.05, "rad or m",
        "Largest change of a joint between checked poses on an edge of a tree.",
    )
    first_steps: int = setting(
        8, "poses",
        "So many poses of an edge are checked at first, then twice as many at a time, while none is blocked.",
        "long edges are blocked soon where there are walls",
    )
    edge_look: float = setting(
        0.01, "m",
        "How far anything moves at most between looks at an edge near to things.",
        "a ring passed the wall of a bin 3 cm thick between poses 5 cm apart",
    )
    edge_stride: float = setting(0.6, "rad or m", "Largest change of a joint along one edge.")
    edges: int = setting(8, "edges", "Edges that grow at a time.")
    shortest_edge: float = setting(0.1, "rad or m", "Edges that get less far are dropped.")
    around: float = setting(
        0.3, "1",
        "Share of the samples drawn around poses that were reached already.",
    )
    spread: float = setting(0.6, "rad or m", "How far from them.")
    beyond_reached: float = setting(
        1.0, "rad or m", "How far beyond the box that a tree has reached the other samples are drawn.",
        "a rover with limits of 4 m through three walls of a hall of 4 m: a way in 960 rounds in three of four "
        "seeds, with samples anywhere within the limits in none; 0.3 and 0.6 do as well",
    )
    withdrawal_stride: float = setting(0.025, "m", "How far what moves is pushed along a straight way at a time.")
    withdrawal_steps: int = setting(16, "steps", "And how often.", "out of what is 40 cm deep")
    withdrawal_near: float = setting(0.05, "m", "The axes of what rests nearer than this are tried as directions.")
    most_withdrawals: int = setting(24, "ways", "How many directions are tried for each outermost frame.")
    withdrawal_alike: float = setting(0.999, "1", "The cosine of the angle within which two directions are one.")
    withdrawal_arm: float = setting(
        0.1, "m", "How far points are from the origin of a frame that are to move alike, which weighs its turning.",
    )
    withdrawal_damping: float = setting(1e-4, "m²", "Damping of the joints' change.")
    withdrawal_miss: float = setting(
        0.3, "1", "By what share of a step points may miss it; then a way ends.",
    )
    cuts_at_once: int = setting(6, "cuts", "Cuts that are tried on a polyline at a time.")
    load_scale: float = setting(
        0.1, "m", "What a load that is more than is kept of a strength by as much again counts as, beside clearances."
    )
    load_difference: float = setting(
        1e-6, "rad or m", "By how much joints are varied to see how fast they change loads."
    )
    load_stride: int = setting(
        5, "samples", "Every how many of the fine times loads are looked at where a path gives way to them."
    )
    winding: float = setting(
        2.0, "1", "Paths wind that are so many times as dear as straight ones: they are straightened.",
        "of 60 phases of six examples 52 are below 1.5, the others 2.3 to 30, which comes to 1.1 to 6 in 0.04 CPU s",
    )
    looks_apart: int = setting(5, "samples", "Every how many of the fine times such a path has a corner to be cut.")
    beyond: float = setting(
        2e-4, "rad or m",
        "How far joints may be beyond their limits.",
        "a fifth of what the verifier forbids",
    )



PHASES = PhaseSettings()
