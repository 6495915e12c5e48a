"""The plan file: everything that a stranger needs to check, draw or execute a plan. `docs/plan-format.md` explains it.

Poses are `[x, y, z, qx, qy, qz, qw]` in the world frame, metres; joint values radians or metres; times seconds.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import msgspec

FORMAT = "tamplang-plan/1"
NO_LIMIT = 1e9
"""Stands for an infinite limit: JSON has no infinity."""


class PlanFileError(Exception):
    """The file is not a readable plan; the message says why."""


class ShapeRecord(msgspec.Struct, frozen=True):
    kind: str
    size: list[float]


class JointRecord(msgspec.Struct, frozen=True):
    name: str
    kind: str
    parent: int
    placement: list[float]
    axis: list[float]
    lower: float
    upper: float
    speed: float
    acceleration: float = NO_LIMIT


class EffectorRecord(msgspec.Struct, frozen=True):
    name: str
    joint: int
    placement: list[float]
    shape: ShapeRecord | None


class LinkRecord(msgspec.Struct, frozen=True):
    joint: int
    placement: list[float]
    shape: ShapeRecord


class ModuleRecord(msgspec.Struct, frozen=True):
    """A module: its kinematics in full, its start pose and start joint values."""

    name: str
    type: str
    joints: list[JointRecord]
    effectors: list[EffectorRecord]
    links: list[LinkRecord]
    pose: list[float]
    start: list[float]


class BodyRecord(msgspec.Struct, frozen=True):
    name: str
    type: str
    shape: ShapeRecord
    pose: list[float]
    movable: bool


class PlaceRecord(msgspec.Struct, frozen=True):
    """A place in a source text; lines and columns count from 1."""

    file: str
    line: int
    column: int


class LiteralRecord(msgspec.Struct, frozen=True):
    """A ground literal, with the place of the rule line or motion predicate it comes from."""

    predicate: str
    args: list[str]
    place: PlaceRecord | None = None


class PhaseRecord(msgspec.Struct, frozen=True):
    """One action and the interval before its switch. `mode` holds the motion literals during the interval, `added`
    those that bind at the switch; `literals` holds the logic literals during the interval (supports, holdings,
    connections and the like). An interval that was not `completed` was broken off before its switch: the action had
    no effect."""

    action: str
    rule: str
    args: list[str]
    place: PlaceRecord | None
    start: float
    end: float
    literals: list[LiteralRecord]
    mode: list[LiteralRecord]
    added: list[LiteralRecord]
    completed: bool = True


class CourseRecord(msgspec.Struct, frozen=True):
    """A body that moves on its own: from time `start` on through `points` at `speed` (m/s; 0 jumps to the last point
    at once), then at rest, or back and forth when it `returns`. Its orientation stays."""

    body: str
    start: float
    points: list[list[float]]
    speed: float
    returns: bool


class BreakdownRecord(msgspec.Struct, frozen=True):
    """From `time` on a module's joints are stuck ("locked") or it has left the scene ("gone")."""

    module: str
    time: float
    kind: str


class WindowRecord(msgspec.Struct, frozen=True):
    """One planning of a run with a receding horizon: at plan time `time`, before phase `phase`, for `reason`, in
    `seconds` of computing. `actions` is the way to the goal as it was seen then, `motions` how many of them got their
    motion; `unmet` are the parts of the goal that did not hold."""

    time: float
    phase: int
    reason: str
    seconds: float
    actions: list[str]
    motions: int
    unmet: list[str]


class TrackRecord(msgspec.Struct, frozen=True):
    """Sampled motion of one module: `poses` of its module frame and `joints`, one row per time stamp of the plan."""

    name: str
    poses: list[list[float]]
    joints: list[list[float]]


class BodyTrackRecord(msgspec.Struct, frozen=True):
    """Sampled poses of a body that moves at some time."""

    name: str
    poses: list[list[float]]


class SplineRecord(msgspec.Struct, frozen=True):
    """The joint motion of one module in one phase: a cubic spline, clamped at both ends, through `values` (one row
    per knot) at equidistant `knots` of the plan's time."""

    module: str
    phase: int
    knots: list[float]
    values: list[list[float]]


class BoundRecord(msgspec.Struct, frozen=True):
    bound: str
    solved: int
    refused: int
    seconds: float


class RefusalRecord(msgspec.Struct, frozen=True):
    """A skeleton, or part of one, that a bound refused: the actions, the worst row, by how much, and where from."""

    bound: str
    actions: list[str]
    reason: str
    amount: float
    unit: str
    place: PlaceRecord | None = None


class SearchNode(msgspec.Struct, frozen=True):
    """A node of the search tree, for drawing: only those expanded or pruned, at most some thousands."""

    id: int
    parent: int
    action: str
    estimate: float
    status: str


class StatisticsRecord(msgspec.Struct, frozen=True):
    """How a plan was found. `path_cost` is the cost of its motion, `path_cost_before` that before it was polished."""

    tree_nodes: int = 0
    expanded_nodes: int = 0
    optimal: bool = False
    gap: float | None = None
    cost: float = 0.0
    seconds: dict[str, float] = {}
    bounds: list[BoundRecord] = []
    refusals: list[RefusalRecord] = []
    tree: list[SearchNode] = []
    path_cost: float | None = None
    path_cost_before: float | None = None


class SourceRecord(msgspec.Struct, frozen=True):
    path: str
    text: str
    sha256: str


class TaskRecord(msgspec.Struct, frozen=True):
    """What was asked: file and task name, the parameters' final values, the seed, and the text of every source."""

    name: str
    file: str
    parameters: dict[str, float | int]
    seed: int
    sources: list[SourceRecord]
    goal: str


class FailureRecord(msgspec.Struct, frozen=True):
    """One thing the verifier refuses: kind, sentence, figure with unit, time, what is concerned, and source place."""

    kind: str
    message: str
    amount: float
    unit: str
    time: float | None = None
    place: PlaceRecord | None = None
    between: list[str] = []


class MeasureRecord(msgspec.Struct, frozen=True):
    """The worst figure of one kind that the verifier measured, when, between what, and the limit it must keep."""

    kind: str
    amount: float
    limit: float
    unit: str
    time: float | None = None
    between: list[str] = []
    place: PlaceRecord | None = None


class VerdictRecord(msgspec.Struct, frozen=True):
    verified: bool
    worst: dict[str, float]
    measures: list[MeasureRecord]
    failures: list[FailureRecord]
    residuals: list[MeasureRecord]
    """One entry per switch constraint of every phase: its own worst row."""


class Plan(msgspec.Struct, frozen=True):
    """A plan. `times` are the time stamps of all tracks, strictly increasing but for the switches, where one sample
    ends the phase and the next, at the same time, starts the next one."""

    format: str
    versions: dict[str, str]
    task: TaskRecord
    modules: list[ModuleRecord]
    bodies: list[BodyRecord]
    phases: list[PhaseRecord]
    final_mode: list[LiteralRecord]
    times: list[float]
    tracks: list[TrackRecord]
    body_tracks: list[BodyTrackRecord]
    splines: list[SplineRecord]
    statistics: StatisticsRecord
    verdict: VerdictRecord | None = None
    courses: list[CourseRecord] = []
    breakdowns: list[BreakdownRecord] = []
    windows: list[WindowRecord] = []
    complete: bool = True
    """False for the executed beginning of a run that was broken off: it does not claim that the goal holds."""


def write_text_atomically(path: str | Path, text: str) -> None:
    """Write `text` so that a reader, or an interrupted run, never sees half of it. Raises OSError."""
    target = Path(path)
    descriptor, temporary = tempfile.mkstemp(dir=target.parent or ".", prefix=f".{target.name}.")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as stream:
            stream.write(text)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(temporary, 0o666 & ~umask)
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def write_plan(plan: Plan, path: str | Path) -> None:
    """Write the plan as JSON, atomically. Raises OSError."""
    write_text_atomically(path, msgspec.json.encode(plan).decode())


def read_plan(path: str | Path) -> Plan:
    """Read a plan file. Raises PlanFileError when it cannot be read or is no plan of this format."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise PlanFileError(f"cannot read {path}: {error.strerror}") from error
    try:
        plan = msgspec.json.decode(data, type=Plan)
    except msgspec.DecodeError as error:
        raise PlanFileError(f"{path} is not a plan file: {error}") from error
    if plan.format != FORMAT:
        raise PlanFileError(f"{path} has format {plan.format!r}; this version reads {FORMAT!r}")
    return plan
