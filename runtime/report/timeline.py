"""The timeline: a row per module and per moved thing, a block per phase; and the joint plots."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ...compiler.ir import JointKind
from ...langs.frozen import dataclass
from ..geometry.transforms import Array
from ..plan import JointRecord, Plan
from ..tracks import body_rows
from .lanes import Motion, critical, motions, works_at_once
from .replay import joint_rows, pick_samples
from .robots import ACCENT, Robot, effector_owners, group_modules, module_colours

RULE_COLOURS = ("#566adf", "#b45a30", "#2f8050", "#b04a8f", "#5f791b", "#257d8f", "#a0522d", "#7a6bb5")
"""White stands on them."""
PLOT_POINTS = 260
WAITED = 0.015
"""Seconds: less is no wait, as switches follow each other a hundredth apart."""
NO_LIMIT = 1e8
"""A limit beyond this, rad or m, is none: plan files have no infinity."""


@dataclass(frozen=True, slots=True)
class TimelineBlock:
    """One phase in one row, in percent of the whole time; `acts` when the row's thing takes part. Where robots work at
    once, one motion, or a wait; `critical` when the length of the plan hangs on it."""

    phase: int
    left: float
    width: float
    colour: str
    robot: str
    acts: bool
    title: str
    completed: bool = True
    critical: bool = False


@dataclass(frozen=True, slots=True)
class Mark:
    """One planning of a run: where on the axis, in percent; `anew` when something made it necessary."""

    left: float
    time: float
    title: str
    anew: bool


@dataclass(frozen=True, slots=True)
class TimelineRow:
    name: str
    kind: str
    blocks: list[TimelineBlock]


@dataclass(frozen=True, slots=True)
class Bracket:
    """Rows `first` to `last` that are one robot in a phase; `closed` when no other row is between."""

    phase: int
    left: float
    width: float
    first: int
    last: int
    closed: bool
    colour: str


@dataclass(frozen=True, slots=True)
class Timeline:
    total: float
    rules: list[tuple[str, str]]
    actions: list[TimelineBlock]
    rows: list[TimelineRow]
    brackets: list[Bracket]
    ticks: list[tuple[float, str]]
    marks: list[Mark]
    happenings: list[Mark]
    at_once: bool = False
    waits: tuple[tuple[str, float], ...] = ()
    """Modules that wait, and for how many seconds."""


ROUTINE = ("start", "next window")
"""How reasons of windows begin that nothing unexpected brought about."""


def window_seconds(plan: Plan) -> list[float | None]:
    """Seconds of computing of every window; None where the plan does not tell."""
    told: list[float | None] = [] if plan.timing is None else list(plan.timing.windows)
    return [*told, *[None] * len(plan.windows)][: len(plan.windows)]


def marks(plan: Plan, scale: float) -> list[Mark]:
    """The windows of a run, each with its reason and how long it took to plan."""
    return [
        Mark(
            w.time * scale,
            w.time,
            f"{w.time:.2f} s: {w.reason}" + (f"; planned in {seconds:.2f} s" if seconds is not None else ""),
            not w.reason.startswith(ROUTINE),
        )
        for w, seconds in zip(plan.windows, window_seconds(plan), strict=True)
    ]


def happenings(plan: Plan, scale: float) -> list[Mark]:
    """What happens to the scene by itself until the end: modules that fail, bodies that are moved at once (`anew`), and
    bodies that begin to move."""
    found = [(b.time, f"{b.module} is {b.kind}", True) for b in plan.breakdowns]
    for course in plan.courses:
        what = "begins to move" if course.speed else "is moved all at once"
        found.append((course.start, f"{course.body} {what}", not course.speed))
    end = total_time(plan)
    return [Mark(time * scale, time, f"{time:.2f} s: {what}", now) for time, what, now in sorted(found) if time <= end]


def total_time(plan: Plan) -> float:
    """Seconds from start to the end of all motion."""
    return max([0.0, *plan.times[-1:], *(p.end for p in plan.phases)])


def rule_colours(plan: Plan) -> dict[str, str]:
    rules = dict.fromkeys(p.rule for p in plan.phases)
    return {rule: RULE_COLOURS[i % len(RULE_COLOURS)] for i, rule in enumerate(rules)}


def ticks(total: float) -> list[tuple[float, str]]:
    """Round times along the axis, as percent and label."""
    if total <= 0.0 or not math.isfinite(total):
        return []
    rough = total / 10.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * f for f in (1.0, 2.0, 5.0, 10.0) if power * f >= rough)
    return [(100.0 * k * step / total, f"{k * step:g}") for k in range(int(total / step) + 1)]


def acting(plan: Plan) -> list[set[str]]:
    """Per phase the modules and bodies that the action names, and those that move."""
    owners = effector_owners(plan)
    modules = {m.name: i for i, m in enumerate(plan.modules)}
    result: list[set[str]] = []
    rows = body_rows(plan)
    for phase in plan.phases:
        names = {a for literal in phase.added for a in literal.args} | set(phase.args)
        taking = {plan.modules[owners[n]].name for n in names if n in owners}
        result.append(taking | {n for n in names if n in modules} | moving(plan, rows, phase.start, phase.end))
    return result


def moving(plan: Plan, rows: Mapping[str, Sequence[Sequence[float]]], start: float, end: float) -> set[str]:
    """Names of the modules and bodies whose samples change between two times; `rows` are those of bodies."""
    inside = [i for i, t in enumerate(plan.times) if start <= t <= end]
    found: set[str] = set()
    if len(inside) < 2:
        return found
    first, last = inside[0], inside[-1]
    while first < last and plan.times[first + 1] <= plan.times[first]:
        first += 1
    while last > first and plan.times[last - 1] >= plan.times[last]:
        last -= 1
    for track in plan.tracks:
        if changes(track.poses, first, last) or changes(track.joints, first, last):
            found.add(track.name)
    return found | {name for name, poses in rows.items() if changes(poses, first, last)}


def changes(rows: Sequence[Sequence[float]], first: int, last: int) -> bool:
    chosen = rows[first : last + 1]
    return any(abs(a - b) > 1e-4 for row in chosen for a, b in zip(row, chosen[0], strict=False))


def build_timeline(plan: Plan) -> Timeline:
    total = total_time(plan)
    scale = 100.0 / total if total > 0.0 else 0.0
    colours = rule_colours(plan)
    taking = acting(plan)
    robots = [group_modules(plan, p.mode) for p in plan.phases]
    hues = [module_colours(plan, groups) for groups in robots]

    def block(index: int, name: str, robot: str) -> TimelineBlock:
        phase = plan.phases[index]
        acts = not name or name in taking[index]
        return TimelineBlock(
            index,
            phase.start * scale,
            max(0.0, phase.end - phase.start) * scale,
            colours[phase.rule],
            robot,
            acts,
            f"{index + 1}. {phase.action}{'' if phase.completed else ' (broken off)'}",
            phase.completed,
        )

    def bracket(index: int, robot: Robot) -> Bracket:
        phase, first, last = plan.phases[index], min(robot.modules), max(robot.modules)
        closed = last - first + 1 == len(robot.modules)
        width = max(0.0, phase.end - phase.start) * scale
        return Bracket(index, phase.start * scale, width, first, last, closed, robot.hue)

    count = range(len(plan.phases))
    at_once = works_at_once(plan)
    moved = motions(plan) if at_once else []
    hanging = critical(plan, moved)

    def motion_blocks(name: str, robot: Sequence[str]) -> list[TimelineBlock]:
        found = []
        for number, motion in enumerate(moved):
            if motion.module != name:
                continue
            colour, action = colours[plan.phases[motion.phase].rule], plan.phases[motion.phase].action
            told = f"{motion.phase + 1}. {action} · moves {motion.begin:.2f} – {motion.end:.2f} s"
            found.append(TimelineBlock(
                motion.phase, motion.begin * scale, (motion.end - motion.begin) * scale, colour, robot[motion.phase],
                True, told, critical=number in hanging,
            ))  # fmt: skip
            for since, seconds, why in ((motion.end, motion.waits, "for the switch"),
                                        (motion.ready, motion.is_held_up, "until its way is free")):  # fmt: skip
                if seconds > WAITED:
                    told = f"{motion.phase + 1}. {action} · waits {seconds:.2f} s {why}"
                    found.append(TimelineBlock(
                        motion.phase, since * scale, seconds * scale, colour, robot[motion.phase], False, told
                    ))  # fmt: skip
        return found

    rows = [
        TimelineRow(
            m.name,
            "module",
            motion_blocks(m.name, [h[at] for h in hues]) if at_once else [block(i, m.name, hues[i][at]) for i in count],
        )
        for at, m in enumerate(plan.modules)
    ]
    for body in plan.bodies:
        if body.movable and any(body.name in names for names in taking):
            rows.append(TimelineRow(body.name, "body", [block(i, body.name, ACCENT) for i in count]))
    brackets = [bracket(i, r) for i in count for r in robots[i] if len(r.modules) > 1]
    actions = [block(i, "", "") for i in count]
    return Timeline(
        total, list(colours.items()), actions, rows, brackets, ticks(total), marks(plan, scale),
        happenings(plan, scale), at_once, waited(moved),
    )  # fmt: skip


def waited(moved: Sequence[Motion]) -> tuple[tuple[str, float], ...]:
    """By module, the seconds for which it waits for switches or until its way is free, where it does."""
    sums: dict[str, float] = {}
    for motion in moved:
        for seconds in (motion.waits, motion.is_held_up):
            if seconds > WAITED:
                sums[motion.module] = sums.get(motion.module, 0.0) + seconds
    return tuple(sorted(sums.items()))


@dataclass(frozen=True, slots=True)
class Plot:
    """One joint over time in a box of 1000 by 100: the curve as an SVG path, and where its limits lie."""

    joint: str
    unit: str
    lower: float
    upper: float
    path: str
    lower_y: float
    upper_y: float
    peak: float
    column: int
    marks: list[tuple[float, str]]
    """Where numbers stand at the axis, in percent from above, and what they say."""


@dataclass(frozen=True, slots=True)
class ModulePlots:
    name: str
    track: int
    plots: list[Plot]


def build_plots(plan: Plan) -> list[ModulePlots]:
    """Small multiples per module with a track. `track` counts them in the order of the replay's joints."""
    total = total_time(plan)
    picked = pick_samples(plan.times)
    stride = max(1, len(picked) // PLOT_POINTS)
    chosen = sorted({*picked[::stride].tolist(), *picked[-1:].tolist()})
    result: list[ModulePlots] = []
    for module in plan.modules:
        for track in plan.tracks:
            if track.name != module.name or not (track.joints and module.joints and chosen) or total <= 0.0:
                continue
            sampled = [track.joints[min(i, len(track.joints) - 1)] for i in chosen]
            rows = joint_rows(sampled, [], len(module.joints))
            times = np.array([plan.times[i] for i in chosen])
            plots = [plot(j, times * 1000.0 / total, rows[:, k], k) for k, j in enumerate(module.joints)]
            result.append(ModulePlots(module.name, len(result), plots))
    return result


def plot(joint: JointRecord, across: Array, values: Array, column: int) -> Plot:
    """The plot of one joint: `across` holds the samples' places on the axis, 0 to 1000, `values` rad or m."""
    lower = joint.lower if joint.lower > -NO_LIMIT else -math.inf
    upper = joint.upper if joint.upper < NO_LIMIT else math.inf
    low = min(v for v in (lower, float(values.min())) if math.isfinite(v))
    high = max(v for v in (upper, float(values.max())) if math.isfinite(v))
    margin = 0.06 * (high - low) or 1.0
    low, high = low - margin, high + margin

    def height(value: float) -> float:
        return round(100.0 * (high - value) / (high - low), 2) if math.isfinite(value) else -10.0

    points = " ".join(f"{x:.1f},{height(float(v))}" for x, v in zip(across, values, strict=True))
    unit = "rad" if joint.kind == JointKind.REVOLUTE else "m"
    peak = float(values[int(np.argmax(np.abs(values)))])
    marks = [(height(high - margin), f"{high - margin:.3g} {unit}"), (height(low + margin), f"{low + margin:.3g}")]
    return Plot(joint.name, unit, lower, upper, points, height(lower), height(upper), peak, column, marks)
