"""The numbers that steer the simulated world and who runs in it."""

from __future__ import annotations

from ...compiler.settings import setting
from ...langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """The numbers that steer the simulated world and who runs in it."""

    drive_step: float = setting(2e-3, "s", "Seconds of one step of the drives.")
    drive_frequency: float = setting(40.0, "1/s", "Natural frequency of the drives, 1/s.")
    brake_knot: float = setting(0.02, "s", "Seconds between knots of a motion that is broken off.")
    brake_quick: float = setting(
        0.25, "s",
        "Seconds in which joints without a limit of acceleration come to rest from full speed.",
    )
    brake_shortest: float = setting(0.05, "s", "The least time in which a motion is broken off.")
    brake_growth: float = setting(
        1.4, "1",
        "By what factor the way to rest grows while it is not within the limits of the joints.",
    )
    brake_tries: int = setting(10, "times", "How often it grows.")
    through: float = setting(
        8e-4, "m",
        "Metres that something is in a robot which does not just press upon it, but goes through it: no plan may "
        "have more than 1 mm. The spheres that measure it lie within shapes, so that no less is in it in truth.",
        "a box pushed into a held one was measured to be 0.90 mm in it, and found to be 1.05 mm by the verifier",
    )
    touching: float = setting(5e-4, "m", "Metres that it may be in the robot when the run ends.")
    halvings: int = setting(12, "times", "Halvings of the time between two looks to find when it gets there.")
    clearance_stride: int = setting(5, "samples", "Every so many samples of the plan are looked at.")
    clearance_apart: float = setting(5e-3, "m", "What the plan has nearer, metres, is meant to touch.")
    clearance_far: float = setting(0.1, "m", "Distances beyond, metres, are of no interest.")
    rest_pieces: int = setting(10, "pieces", "Pieces of the motion of a phase in which nothing moves.")
    phase_looks: int = setting(101, "instants", "Instants of a phase that are looked at.")
    far: float = setting(0.2, "m", "Metres beyond which distances are of no interest.")
    horizon: int = setting(4, "actions", "Actions that get their motion in one window, where nothing else is said.")
    latency: float = setting(0.25, "s", "Simulated seconds that planning a window takes, where nothing else is said.")
    redraws: int = setting(
        3, "times",
        "How often a window is drawn anew where nothing leads on and giving way does not help, before a run is stuck.",
    )
    same_place: float = setting(1e-4, "m", "Metres that make no difference.")
    put_away: float = setting(
        2e-3, "m",
        "Metres by which such a body is put away from the end, as it may come after it.",
    )
    too_near: float = setting(
        0.01, "m",
        "Metres between a module and a body at the start of a phase at which no path may be found.",
    )
    let_go: float = setting(0.01, "m", "A body that is nearer to an end, metres, has just been let go.")
    sensing_period: float = setting(0.05, "s", "Seconds between two looks at the scene.")
    memory: int = setting(60, "looks", "Looks from which a velocity is estimated.")
    kept_looks: int = setting(100, "looks", "Looks that are remembered: planning may know the last ones too late.")
    tolerance: float = setting(5e-4, "m", "Metres by which a body may be off where a window expects it.")
    pushed: float = setting(
        0.01, "m",
        "Metres off its way after which a body may rest again: no speed is read off this step.",
    )
    sure: float = setting(5.0, "1", "Standard deviations of the noise that make no difference.")
    likely: float = setting(3.0, "1", "Standard deviations beyond which a speed is taken for one.")
    rare: float = setting(
        4.0, "1",
        "Standard deviations that a look is off the way of a body only where that has changed.",
    )
    ago: tuple[int, ...] = setting(
        (3, 6, 12), "looks",
        "Looks before which a body may have changed its way without any look that tells.",
    )
    enough: int = setting(8, "looks", "Looks before such a change that tell the way until then.")
    evasion_spreads: tuple[float, ...] = setting(
        (0.2, 0.4, 0.8), "rad or m",
        "Standard deviations of the joint values that are tried, around the present ones, radians or metres.",
    )
    evasion_draws: int = setting(24, "draws", "How many of each.")
    evasion_room: float = setting(0.03, "m", "Metres that a posture must keep from whatever the robot is not kept to.")
    evasion_paths: int = setting(
        4, "paths",
        "For so many postures, those with little motion first, a path is looked for.",
    )
    steer_farthest: float = setting(0.01, "m", "Metres that what is met may be off; beyond, a window is planned anew.")
    steer_least: float = setting(2e-4, "m", "Metres that make no difference.")
    steer_met: float = setting(
        1e-4, "m",
        "Metres, and radians times `steer_lever`, to which a corrected motion has to meet what it is to meet.",
    )
    steer_lever: float = setting(0.1, "m", "Metres: what a radian counts for.")
    steer_steps: int = setting(3, "steps", "Steps in which a motion is corrected at most.")
    steer_damping: float = setting(1e-3, "m/rad", "Metres per radian below which joints count as having no effect.")
    shorter: tuple[tuple[int, float], ...] = setting(
        ((2, -0.005), (2, -0.01)), "actions, m",
        "After a first try while things move: so many actions, as what comes later may be in reach by then, and "
        "so many metres added to margins, as a robot that stands a little off may be nearer to things than it "
        "should.",
    )
    hasty_candidates: int = setting(
        6, "plans",
        "Ways that a search judges where the run can give way and search again a moment later.",
        "as a rule the first one is taken (benchmarks/horizon.py)",
    )
    farther: int = setting(
        3, "actions",
        "Actions that are looked at beyond others for every time that the run has been in the same state before: "
        "it goes in circles when what is refused lies behind what it looks at.",
    )
    first_guess: float = setting(2.0, "s", "Seconds that a phase is assumed to take before any was seen.")
    time_room: float = setting(1.1, "1", "What the seconds that a phase takes are multiplied by.")
    attempts: int = setting(
        5, "times",
        "How often a window is planned anew because its first phase takes longer than assumed, or meets what it "
        "lets go.",
    )
    left_over: float = setting(0.3, "s", "What is left of a phase that was broken off may take so many seconds more.")
    wider: float = setting(0.01, "m", "Metres by which margins grow for a phase that would get into what moves.")
    deep: float = setting(8e-4, "m", "Metres that a phase may be in something, as when it leaves what rises.")
    pressed: float = setting(
        2e-4, "m",
        "The same for a robot at rest, which what changes its way may press further before it is noticed.",
    )
    threat: float = setting(
        3e-3, "m",
        "Metres from a motion within which what has changed its way breaks it off: it takes time to brake.",
    )
    no_more: float = setting(5e-5, "m", "Metres that are no more.")
    later_looks: int = setting(6, "looks", "Looks by which a motion may be broken off later than it could be.")
    nearly_met: float = setting(
        1e-3, "m",
        "Metres that a motion may end off what it meets, where it is too late for anything else.",
    )
    around: float = setting(0.05, "m", "Metres from a robot within which bodies are looked out for.")
    back_share: float = setting(
        0.5, "1",
        "Share of a broken-off motion that is gone back where nothing leads on from its end.",
    )
    back_short: float = setting(0.4, "s", "One of so many seconds is gone back as a whole.")
    instant: float = setting(1e-3, "s", "Seconds that make no difference.")
    wait: float = setting(
        0.5, "s",
        "Seconds that the run waits where nothing leads on, in the hope that what moves does so.",
    )
    most_waits: int = setting(40, "times", "How often it waits so, one time after the other.")
    at_last: float = setting(0.1, "s", "Seconds before its end from which a motion is not steered any more.")


SIMULATION = SimulationSettings()
