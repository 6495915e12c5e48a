"""The numbers that steer P_path and closed chains."""

from __future__ import annotations

from .....compiler.settings import setting
from .....langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class PathSettings:
    """The numbers that steer P_path and closed chains."""

    slip: float = setting(
        1e-4, "m or rad",
        "The largest drift of a kept pose along the resampled path.",
    )
    slice_factors: tuple[int, ...] = setting(
        (1, 2, 4, 8), "1",
        "How many times as many slices a path may need for that, and for joints that move far.",
    )
    first_starts: int = setting(1, "starts", "How many starts a phase gets at first.")
    starts: int = setting(
        3, "starts",
        "And once its switches were drawn anew: a straight one twice, the second time with a wider margin, "
        "then one along a sampled way.",
    )
    projections: int = setting(40, "iterations", "Iterations with which starts are put onto closure.")
    least_shrinking: float = setting(
        0.5, "1",
        "A path that drifts more than this share of what it did with half the slices is given up.",
        "a spline along closure drifts 16 times less with twice the slices; one that does not even halve its "
        "drift jumps from one posture to another, and more slices do not help",
    )
    least_inset: float = setting(
        1e-3, "rad or m",
        "What slices keep from joint limits at least, as splines go past them between slices; more is a wish.",
        "a lid that the elbow of an arm can just follow, 0.004 rad within its limit, was refused with 0.01",
    )
    widening: float = setting(
        1.5, "1",
        "By how much the margin grows when slices are clear but what lies between them is not.",
    )
    acceleration_weight: float = setting(0.1, "1", "Weight of second differences of joints against first ones.")
    homing_weight: float = setting(0.2, "1", "Weight of the distance of joints from their home.")
    wish_scale: float = setting(
        60.0, "1/m",
        "The scale of wished clearances.",
        "against accelerations, whose scale is 9, a margin is missed by less than a millimetre",
    )
    least_clearance: float = setting(
        5e-3, "m",
        "What begins or ends to touch must be apart by this once the margin is whole, and on the way there by "
        "its share.",
        "else the spline between two slices goes through what both only touch",
    )
    stiffness: float = setting(
        10.0, "1",
        "Scale of kept and switch rows.",
        "without it a path slips by up to 2 cm",
    )
    bumps: int = setting(6, "starts", "How many bumped starts follow the straight one.")
    bump: float = setting(0.5, "rad or m", "Their size.")
    tree_rounds: int = setting(
        60, "rounds",
        "How often trees of states on the rows of a phase grow before they count as not to be connected.",
    )
    tree_cuts: int = setting(12, "cuts", "How often corners of what they find are cut.")
    tree_stride: float = setting(
        0.15, "rad or m",
        "The largest change of a joint from one state of an edge to the next.",
    )
    tree_projections: int = setting(8, "iterations", "Gauss-Newton steps that put a state onto the rows.")
    goal_projections: int = setting(25, "iterations", "And those that put what a tree grows towards onto them.")
    goal_stride: float = setting(0.5, "rad or m", "By how much these change a joint at most.")
    tree_damping: float = setting(1e-6, "1", "The damping of both.")
    tree_accuracy: float = setting(
        1e-4, "m or rad", "How exactly rows hold there.", "the program that follows puts its slices on closure anew",
    )
    tree_met: float = setting(0.02, "rad or m", "How near to each other the ends of two branches that meet are.")
    refreshes: int = setting(
        3, "solves",
        "How often pairs that came near during a solve are taken in and the solve is resumed.",
    )


PATHS = PathSettings()
