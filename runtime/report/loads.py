"""What drives, docks and feet bear over time, beside what they can, from what a plan tells of forces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import msgspec
import numpy as np

from ...langs.frozen import dataclass
from ..geometry.transforms import Array
from ..plan import NO_LIMIT, JointRecord, MeasureRecord, Plan
from ..plan_forces import HoldRecord, StaticsRecord, WrenchRecord

POINTS = 300
"""Most instants of a curve: of more, the greatest of neighbours are shown."""
SILENT = 1e-6
"""N m or N: a drive that never gives more has no curve."""
CONTACTS = ("pad", "rest")
STILL = 1e-5
"""Radians or metres by which a joint may change whose brake holds it."""
KINDS = {"torque_ratio": "the drive of", "bearing_ratio": "the bearing of", "dock_ratio": "", "foot_ratio": ""}
"""How the verifier's figures of loads call what they are of."""
Stretch = tuple[Array, Array]
"""Times `(T,)` of a phase and values `(T,)` at them."""


@dataclass(frozen=True, slots=True)
class LoadPlot:
    """A load over time in a box of 1000 by 100, one path for each time that it lasts; where its limits lie; and the
    greatest, when."""

    name: str
    detail: str
    paths: list[str]
    limits: list[float]
    peak: str
    limit: str
    time: float
    share: float
    """Of the limit, 0 where there is none."""
    marks: list[tuple[float, str]]
    """Where numbers stand at the axis, in percent from above, and what they say."""


@dataclass(frozen=True, slots=True)
class ModuleLoads:
    name: str
    plots: list[LoadPlot]


@dataclass(frozen=True, slots=True)
class Weakest:
    """What comes nearest to its strength: whose, which share of it, when."""

    name: str
    share: float
    time: float


@dataclass(frozen=True, slots=True)
class LoadsView:
    safety: float
    weakest: Weakest | None
    drives: list[ModuleLoads]
    pairs: list[LoadPlot]
    switches: list[float]
    """Where actions end, on the axis of 1000."""


def told(plan: Plan) -> StaticsRecord | None:
    return None if isinstance(plan.statics, msgspec.UnsetType) or not plan.phases else plan.statics


def build_loads(plan: Plan) -> LoadsView | None:
    """The curves of a plan that tells of forces; None of another."""
    given, total = told(plan), plan.times[-1] if plan.times else 0.0
    if given is None or total <= 0.0:
        return None
    drives = [ModuleLoads(m.name, list(_drives(plan, given, m.name, m.joints))) for m in plan.modules]
    pairs = list(_pairs(plan, given))
    ends = sorted({round(1000.0 * p.end / total, 1) for p in plan.phases[:-1]})
    shown = [d for d in drives if d.plots]
    return LoadsView(given.safety, _weakest(plan, shown, pairs), shown, pairs, ends) if shown or pairs else None


def _weakest(plan: Plan, drives: Sequence[ModuleLoads], pairs: Sequence[LoadPlot]) -> Weakest | None:
    """By what the verifier measured, and by what is told: what stands may be near to tipping."""
    measures = [m for m in (plan.verdict.measures if plan.verdict else []) if m.kind in KINDS and m.limit > 0.0]
    found = [Weakest(_whose(m), m.amount / m.limit, m.time or 0.0) for m in measures]
    found += [Weakest(f"the drive of {p.name} of {m.name}", p.share, p.time) for m in drives for p in m.plots]
    found += [Weakest(p.name, p.share, p.time) for p in pairs]
    found = [w for w in found if w.share > 0.0]
    return max(found, key=lambda w: w.share, default=None)


def _whose(measure: MeasureRecord) -> str:
    if KINDS[measure.kind] and len(measure.between) == 2:
        return f"{KINDS[measure.kind]} {measure.between[1]} of {measure.between[0]}"
    return " and ".join(measure.between)


def stamps(plan: Plan, phase: int, count: int) -> Array:
    """The times of `count` rows that are told of a phase."""
    record = plan.phases[phase]
    return np.linspace(record.start, record.end, max(count, 2))


def _drives(plan: Plan, given: StaticsRecord, name: str, joints: Sequence[JointRecord]) -> Iterator[LoadPlot]:
    strengths = {d.joint: (d.torque, d.brake) for d in given.drives if d.module == name}
    records = [
        t for t in given.torques
        if t.module == name and 0 <= t.phase < len(plan.phases) and t.values
        and all(len(row) == len(joints) for row in t.values)
    ]  # fmt: skip
    for column, joint in enumerate(joints):
        torque, brake = strengths.get(joint.name, (NO_LIMIT, 0.0))
        stretches, share = [], 0.0
        for record in records:
            values = np.array([row[column] for row in record.values])
            stretches.append((stamps(plan, record.phase, len(values)), np.resize(values, max(len(values), 2))))
            strength = torque if brake <= torque or _moves(plan, name, column, record.phase) else brake
            share = max(share, given.safety * float(np.abs(values).max()) / strength)
        most = max((float(np.abs(v).max()) for _, v in stretches), default=0.0)
        if most > SILENT:
            unit = "N m" if joint.kind == "revolute" else "N"
            detail = f"brake {brake / given.safety:.3g} {unit}" if brake > torque else ""
            plot = _plot(plan, joint.name, detail, stretches, torque / given.safety, unit)
            yield replace(plot, share=share) if brake > torque else plot


def _moves(plan: Plan, name: str, column: int, phase: int) -> bool:
    """Whether a joint moves in a phase."""
    own = [s for s in plan.splines if s.module == name and s.first <= phase <= s.until]
    return any(max(row[column] for row in s.values) - min(row[column] for row in s.values) > STILL for s in own
               if s.values and all(len(row) > column for row in s.values))  # fmt: skip


def _pairs(plan: Plan, given: StaticsRecord) -> Iterator[LoadPlot]:
    found: dict[tuple[str, ...], list[Stretch]] = {}
    for record in given.wrenches:
        if not 0 <= record.phase < len(plan.phases):
            continue
        ratio = pair_ratio(given, record)
        if ratio is not None:
            times = stamps(plan, record.phase, len(ratio))
            stretch = times, np.resize(ratio, len(times))
            found.setdefault((record.manner, *record.between), []).append(stretch)
    for (manner, *names), stretches in found.items():
        yield _plot(plan, " and ".join(names), manner, stretches, 1.0, "")


def pair_ratio(given: StaticsRecord, record: WrenchRecord) -> Array | None:
    """Load times safety over strength `(T,)` of a pair; None where nothing is stated."""
    holds = [h for h in given.holds if h.name in record.between and h.manner == record.manner]
    rows = np.array([row for row in record.values if len(row) == 6]).reshape(-1, 6)
    if not holds or not len(rows):
        return None
    weaker = {n: min(getattr(h, n) for h in holds) for n in ("force", "shear", "moment", "twist", "friction")}
    across, bend = np.hypot(rows[:, 0], rows[:, 1]), np.hypot(rows[:, 3], rows[:, 4])
    shares = [across / weaker["shear"], bend / weaker["moment"], np.abs(rows[:, 5]) / weaker["twist"]]
    if record.manner not in CONTACTS:
        shares.append(np.abs(rows[:, 2]) / weaker["force"])
        if record.manner == "grip":
            shares.append(across / (weaker["friction"] * weaker["force"]))
        return np.asarray(given.safety * np.max(shares, axis=0))
    whole = [*shares, *_pressed(holds[0], weaker, record, rows, across, bend)]
    return np.asarray(given.safety * np.max(whole, axis=0))


def _pressed(
    hold: HoldRecord, weaker: dict[str, float], record: WrenchRecord, rows: Array, across: Array, bend: Array
) -> Iterator[Array]:
    """The shares of what stands: the pull, and what friction and the edge hold."""
    sticks = weaker["force"] if hold.manner == "pad" else 0.0
    if sticks >= NO_LIMIT:
        return
    held = np.maximum(sticks - rows[:, 2], 1e-9)
    if sticks > 0.0:
        yield np.maximum(rows[:, 2], 0.0) / sticks
    if weaker["friction"] < NO_LIMIT:
        yield across / (weaker["friction"] * held)
    if weaker["moment"] >= NO_LIMIT and record.radius > 0.0:
        yield bend / (record.radius * held)


def _plot(plan: Plan, name: str, detail: str, stretches: Sequence[Stretch], limit: float, unit: str) -> LoadPlot:
    signed = bool(unit)
    peak, time = max((float(np.abs(v).max()), float(t[np.abs(v).argmax()])) for t, v in stretches)
    limited = limit * (1.0 + 1e-9) < NO_LIMIT / 1e3
    highest = 1.06 * max(peak, limit if limited else 0.0, SILENT)

    def height(value: float) -> float:
        share = min(max(value / highest, -1.0), 1.0)
        return round(50.0 - 50.0 * share if signed else 98.0 - 96.0 * share, 2)

    each = max(4, POINTS // len(stretches))
    paths = []
    for times, values in stretches:
        across, heights = _thinned(1000.0 * times / plan.times[-1], values, each)
        paths.append(" ".join(f"{x:.1f},{height(float(v))}" for x, v in zip(across, heights, strict=True)))
    limits = [height(v) for v in ((limit, -limit) if signed else (limit,))] if limited else []
    said = f"{peak:.3g} {unit}".strip() if signed else f"{100.0 * peak:.3g} %"
    bound = f"of {limit:.3g} {unit}" if signed and limited else "" if limited else "no limit"
    top = limit if limited else peak
    marks = [(height(top), f"{top:.3g} {unit}" if signed else f"{100.0 * top:.3g} %"), (height(0.0), "0")]
    marks += [(height(-top), f"−{top:.3g}")] if signed else []
    return LoadPlot(name, detail, paths, limits, said, bound, time, peak / limit if limited else 0.0, marks)


def _thinned(times: Array, values: Array, most: int) -> Stretch:
    """At most `most` of the values: of each group of neighbours the greatest."""
    step = math.ceil(len(values) / most)
    if step <= 1:
        return times, values
    groups = [np.arange(k, min(k + step, len(values))) for k in range(0, len(values), step)]
    chosen = [int(g[np.abs(values[g]).argmax()]) for g in groups]
    chosen = sorted({0, *chosen, len(values) - 1})
    return times[chosen], values[chosen]
