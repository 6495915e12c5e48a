"""Everything the page shows, as plain records for the template."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Sequence
from statistics import median

from ...compiler.standard import EXTENSION
from ...langs.frozen import dataclass
from ..plan import LiteralRecord, MeasureRecord, ObjectiveRecord, PhaseRecord, Plan, WindowRecord
from .robots import Robot, group_modules, literal_text
from .sources import SourceLine, SourceLink, Sources
from .timeline import ModulePlots, Timeline, build_plots, build_timeline, rule_colours, total_time, window_seconds
from .tree import Tree, build_tree

NEAR = 0.5
"""The share of a limit from which on a figure counts as near to fail."""
AT_LIMITS = ("joint_speed", "joint_acceleration", "joint_jerk")
"""Kinds of measures that planners take to their limits."""


@dataclass(frozen=True, slots=True)
class LiteralView:
    text: str
    link: SourceLink | None


@dataclass(frozen=True, slots=True)
class LiteralGroup:
    """Literals that one place of the text speaks of: with many things, a link for each would be most of the page."""

    texts: list[str]
    link: SourceLink | None


@dataclass(frozen=True, slots=True)
class PhaseView:
    """One row of the skeleton table; `marked` are the lines of its rule to highlight: the head, and what was added."""

    index: int
    record: PhaseRecord
    colour: str
    link: SourceLink | None
    rule_lines: list[SourceLine]
    marked: set[int]
    added: list[LiteralView]
    literals: list[LiteralGroup]
    mode: list[LiteralGroup]
    robots: list[str]


@dataclass(frozen=True, slots=True)
class MeasureView:
    """A figure against its limit. `share` is amount over limit, or None where that says nothing."""

    record: MeasureRecord
    link: SourceLink | None
    share: float | None
    worst: bool


@dataclass(frozen=True, slots=True)
class Linked:
    """Any record with the link of its place."""

    record: object
    link: SourceLink | None


@dataclass(frozen=True, slots=True)
class View:
    plan: Plan
    verdict: str
    checked: bool
    """Whether the verdict was made for this page, and not read from the file."""
    optimality: str
    proof: str
    command: str
    machine: str
    objective: str
    seconds: float
    duration: float
    phases: list[PhaseView]
    final: list[LiteralGroup]
    timeline: Timeline
    plots: list[ModulePlots]
    stages: list[tuple[str, float, float]]
    refusals: list[Linked]
    failures: list[Linked]
    measures: list[MeasureView]
    residuals: list[MeasureView]
    tree: Tree
    sources: Sources
    latency: tuple[float, float] | None
    """Seconds for a window after the first: median and worst."""
    windows: list[tuple[WindowRecord, float | None]]
    """Windows, with the seconds that it took to plan them."""

    @property
    def searched(self) -> bool:
        """Whether the plan tells of a search: the record of a run has windows instead."""
        return bool(self.plan.statistics.tree_nodes or self.tree.branches or not self.plan.windows)


def latency(plan: Plan) -> tuple[float, float] | None:
    seconds = plan.timing.windows[1:] if plan.timing is not None else []
    return (median(seconds), max(seconds)) if seconds else None


def figure(amount: float, unit: str) -> str:
    """A number for people: three digits, small lengths in millimetres, short times in milliseconds."""
    if not math.isfinite(amount):
        return "∞" if amount > 0 else "−∞" if amount < 0 else "–"
    small = {"m": "mm", "s": "ms"}.get(unit)
    if small and abs(amount) < 0.1:
        amount, unit = amount * 1000.0, small
    least = 1e-3 if small and unit == small else 1e-6
    if 0.0 < abs(amount) < least:
        return f"< {least:g} {unit}".strip()
    text = f"{amount:.3g}" if abs(amount) < 1000 else f"{amount:.0f}"
    return f"{text} {unit}".strip()


def optimality(plan: Plan) -> str:
    statistics = plan.statistics
    if statistics.optimal:
        return "optimal"
    if statistics.gap is None:
        return "not proved optimal"
    return f"at most {statistics.gap:g} above the optimum"


def minimised(plan: Plan) -> str:
    """What the plan was to be best at, its value, and the bounds of it; "" where that was the cost of actions."""
    told = plan.statistics.objective
    if not isinstance(told, ObjectiveRecord):
        return ""
    bounds = [f"at least {figure(bound, told.unit)} for {name}" for name, bound in told.bounds.items() if bound > 0.0]
    return f"{told.minimise}: {figure(told.value, told.unit)}" + (f" ({'; '.join(bounds)})" if bounds else "")


def shares(records: Sequence[MeasureRecord], sources: Sources) -> list[MeasureView]:
    """Measures with what they use of their limits. One is marked as the worst: that which is nearest to fail, where
    something is near; rates of joints are at their limits by design, as phases are no longer than they must."""
    ratios = [max(0.0, r.amount) / r.limit if r.limit > 0.0 and math.isfinite(r.limit) else None for r in records]
    known = [s for r, s in zip(records, ratios, strict=True) if s is not None and not r.kind.startswith(AT_LIMITS)]
    worst = max(known, default=0.0)
    return [
        MeasureView(r, sources.link(r.place), s, s == worst >= NEAR and not r.kind.startswith(AT_LIMITS))
        for r, s in zip(records, ratios, strict=True)
    ]


def stages(plan: Plan) -> tuple[list[tuple[str, float, float]], float]:
    """Name, seconds and percent of the total of every stage; and the total."""
    seconds = dict(plan.timing.seconds) if plan.timing is not None else {}
    total = seconds.pop("total", sum(seconds.values()))
    whole = max(total, sum(seconds.values()), 1e-12)
    return [(name, value, 100.0 * value / whole) for name, value in seconds.items()], total


def marked_lines(phase: PhaseRecord) -> set[int]:
    """Numbers of the rule's own line and of the effects that the phase adds, in the file of the rule."""
    places = [phase.place, *(literal.place for literal in phase.added)]
    return {p.line for p in places if p and phase.place and p.file == phase.place.file}


ASKED = {
    "statics": "whether any posture could carry what the actions load; without motion",
    "seq": "one posture for each switch, all together: a part of what motion must keep",
    "seq-path": "the motion of each phase by itself, between the postures of its two switches",
    "path": "the motion of all phases at once, with postures free",
}
"""What each bound asks, in a sentence."""


def asked(bound: str) -> str:
    return ASKED.get(bound, "")


def proof(plan: Plan) -> str:
    """The cost, the bound below it, and what proves that."""
    statistics = plan.statistics
    if not plan.complete or statistics.gap is None:
        return ""
    least = statistics.cost - statistics.gap
    return (
        f"The actions cost {statistics.cost:.4g}; no plan costs less than {least:.4g}: sequences below that do "
        "not lead to the goal, or the bounds have refused them, as far as refusals by motion are right."
    )


def command(plan: Plan) -> str:
    """What solves the same task, as far as a plan tells: not of runs, nor with options of the command line."""
    task = plan.task
    if plan.windows or not task.file.endswith(EXTENSION):
        return ""
    given = [word for name, value in task.parameters.items() for word in ("-p", f"{name}={value}")]
    return shlex.join(["tamplang", "solve", task.file, task.name, *given, "--seed", str(task.seed)])


def machine(plan: Plan) -> str:
    """The machine on which the seconds of computing were spent."""
    told = plan.timing.machine if plan.timing is not None else None
    if told is None:
        return ""
    processor = f"{told.processor} ({told.architecture})" if told.processor else told.architecture
    return f"{processor}, {told.cores} core{'' if told.cores == 1 else 's'}, {told.system}"


_UNIT = re.compile(r"(?<=.)_(m|rad|s|ratio|(m|rad)_s[23]?)$")


def measure_name(kind: str) -> str:
    """A kind of measure in words: `joint_limit_rad` is a joint limit, its unit stands beside the figure."""
    return _UNIT.sub("", kind).replace("_", " ")


def robot_text(plan: Plan, robot: Robot) -> str:
    return " + ".join(plan.modules[i].name for i in robot.modules)


def standing(plan: Plan) -> str:
    """The verdict in words. Only a plan that reaches its goal is called verified, without more."""
    verdict = plan.verdict
    if verdict is None:
        return "not verified"
    if not verdict.verified:
        return "refused"
    return "verified" if verdict.goal_reached else "motion verified, goal not reached"


def _grouped(literals: Sequence[LiteralView]) -> list[LiteralGroup]:
    """By the places that speak of them, in the order in which these come first."""
    groups: dict[tuple[str, str], LiteralGroup] = {}
    for literal in literals:
        key = ("", "") if literal.link is None else (literal.link.text, literal.link.title)
        groups.setdefault(key, LiteralGroup([], literal.link)).texts.append(literal.text)
    return [LiteralGroup(_in_ranges(group.texts), group.link) for group in groups.values()]


_INDEX = re.compile(r"\[(\d+)\](?!.*\[\d+\])")
"""The last index of a literal."""


def _in_ranges(texts: Sequence[str]) -> list[str]:
    """Literals that differ only by their last index as one: `(on source item[1…9, 12])`."""
    found: dict[tuple[str, str], list[int]] = {}
    for text in texts:
        index = _INDEX.search(text)
        key = (text, "") if index is None else (text[: index.start(1)], text[index.end(1) :])
        found.setdefault(key, []).extend([] if index is None else [int(index[1])])
    return [before + _ranges(numbers) + after for (before, after), numbers in found.items()]


def _ranges(numbers: Sequence[int]) -> str:
    """Ascending, three or more in a row as a range."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(f"{r[0]}…{r[-1]}" if len(r) > 2 else ", ".join(map(str, r)) for r in runs)


def build_view(plan: Plan, checked: bool) -> View:
    """The page's content, from nothing but the plan; phases, verdict, tracks and tree may be missing."""
    sources = Sources(plan.task.sources)
    colours = rule_colours(plan)

    def literals(records: Sequence[LiteralRecord], motion: bool) -> list[LiteralView]:
        return [LiteralView(literal_text(r, motion), sources.link(r.place)) for r in records]

    phases = [
        PhaseView(
            index,
            record,
            colours[record.rule],
            sources.link(record.place),
            sources.excerpt(record.place),
            marked_lines(record),
            literals(record.added, True),
            _grouped(literals(record.literals, False)),
            _grouped(literals(record.mode, True)),
            [robot_text(plan, r) for r in group_modules(plan, record.mode)],
        )
        for index, record in enumerate(plan.phases)
    ]
    verdict = plan.verdict
    times, total = stages(plan)
    return View(
        plan,
        standing(plan),
        checked or verdict is None,
        optimality(plan),
        proof(plan),
        command(plan),
        machine(plan),
        minimised(plan),
        total,
        total_time(plan),
        phases,
        _grouped(literals(plan.final_mode, True)),
        build_timeline(plan),
        build_plots(plan),
        times,
        [Linked(r, sources.link(r.place)) for r in plan.statistics.refusals],
        [Linked(f, sources.link(f.place)) for f in (verdict.failures if verdict else [])],
        shares(verdict.measures if verdict else [], sources),
        shares(verdict.residuals if verdict else [], sources),
        build_tree(plan),
        sources,
        latency(plan),
        list(zip(plan.windows, window_seconds(plan), strict=True)),
    )
