"""The numbers that steer P_seqPath."""

from __future__ import annotations

from dataclasses import dataclass

from .....compiler.settings import setting


@dataclass(frozen=True)
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
    rounds: int = setting(120, "rounds", "And at last.")
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
    made: float = setting(1e-4, "rad or m", "How near to its end a path comes that was made, radians or metres.")
    same_pose: float = setting(
        1e-5, "m",
        "By how much the poses of things at rest may differ, metres, and be the same.",
    )
    pair_lot: int = setting(
        500_000, "pairs",
        "Pairs of spheres that are looked at at once, which is what a process can hold.",
        "a tenth of a second",
    )


PHASES = PhaseSettings()
