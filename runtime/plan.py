"""The plan file: everything that a stranger needs to check, draw or execute a plan. `docs/plan-format.md` explains it.

Poses are `[x, y, z, qx, qy, qz, qw]` in the world frame, metres; joint values radians or metres; times seconds.
"""

from __future__ import annotations

import msgspec

from .plan_forces import StaticsRecord

FORMAT = "tamplang-plan/2"
COUPLINGS = "couplings"
PASSIVE = "passive"
JERK = "jerk"
PLACES = "places"
STATICS = "statics"
PARTS = "parts"
KNOWN_NEEDS = frozenset({COUPLINGS, PASSIVE, JERK, PLACES, STATICS, PARTS})
"""The optional parts of the format that this version understands."""
NO_LIMIT = 1e9
"""Stands for an infinite limit: JSON has no infinity."""


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A part of a plan file. A field that it does not have is refused, not passed over: it may change what others
    mean."""


class ShapeRecord(Record, frozen=True, omit_defaults=True):
    """A body that is not convex has convex `parts`; its own shape is the hull around them."""

    kind: str
    size: list[float]
    parts: list[PartRecord] = []

    @property
    def solids(self) -> list[PartRecord]:
        """The convex shapes that it is made of."""
        return self.parts or [PartRecord([0.0, 0.0, 0.0], self)]


class PartRecord(Record, frozen=True):
    """A part, its frame at `at` in that of the body, and turned like it."""

    at: list[float]
    shape: ShapeRecord


class CouplingRecord(Record, frozen=True):
    """The joint's value is always `factor` times that of joint `leader`, an index, plus `offset`."""

    leader: int
    factor: float
    offset: float


class JointRecord(Record, frozen=True, omit_defaults=True):
    name: str
    kind: str
    parent: int
    placement: list[float]
    axis: list[float]
    lower: float
    upper: float
    speed: float
    acceleration: float = NO_LIMIT
    follows: CouplingRecord | None = None
    passive: bool = False
    jerk: float = NO_LIMIT


class EffectorRecord(Record, frozen=True):
    name: str
    joint: int
    placement: list[float]
    shape: ShapeRecord | None


class LinkRecord(Record, frozen=True):
    joint: int
    placement: list[float]
    shape: ShapeRecord


class ModuleRecord(Record, frozen=True):
    """A module: its kinematics in full, its start pose and start joint values."""

    name: str
    type: str
    joints: list[JointRecord]
    effectors: list[EffectorRecord]
    links: list[LinkRecord]
    pose: list[float]
    start: list[float]


class BodyRecord(Record, frozen=True, omit_defaults=True):
    """`collides` is false of what is only a place: a region, or a mark on something."""

    name: str
    type: str
    shape: ShapeRecord
    pose: list[float]
    movable: bool
    collides: bool = True


class PlaceRecord(Record, frozen=True):
    """A place in a source text; lines and columns count from 1."""

    file: str
    line: int
    column: int


class LiteralRecord(Record, frozen=True):
    """A ground literal, with the place of the rule line or motion predicate it comes from."""

    predicate: str
    args: list[str]
    place: PlaceRecord | None = None


class PhaseRecord(Record, frozen=True):
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


class CourseRecord(Record, frozen=True):
    """A body that moves on its own: from time `start` on through `points` at `speed` (m/s; 0 jumps to the last point
    at once), then at rest, or back and forth when it `returns`. Its orientation stays."""

    body: str
    start: float
    points: list[list[float]]
    speed: float
    returns: bool


class BreakdownRecord(Record, frozen=True):
    """From `time` on a module's joints are stuck ("locked") or it has left the scene ("gone")."""

    module: str
    time: float
    kind: str


class WindowRecord(Record, frozen=True):
    """One planning of a run with a receding horizon: at plan time `time`, before phase `phase`, for `reason`.
    `actions` is the way to the goal as it was seen then, `motions` how many of them got their motion; `unmet` are the
    parts of the goal that did not hold."""

    time: float
    phase: int
    reason: str
    actions: list[str]
    motions: int
    unmet: list[str]


class TrackRecord(Record, frozen=True):
    """Sampled motion of one module: `poses` of its module frame and `joints`, one row per time stamp of the plan."""

    name: str
    poses: list[list[float]]
    joints: list[list[float]]


class BodyTrackRecord(Record, frozen=True):
    """Some sampled poses of a body, from the sample with index `first` on. It rests, before, between and after its
    pieces, at the last pose that it had."""

    name: str
    first: int
    poses: list[list[float]]


class SplineRecord(Record, frozen=True):
    """The joint motion of one module from the start of phase `first` to the end of phase `until`: a cubic spline,
    clamped at both ends, through `values` (one row per knot) at equidistant `knots` of the plan's time."""

    module: str
    first: int = msgspec.field(name="from")
    until: int
    knots: list[float]
    values: list[list[float]]


class BoundRecord(Record, frozen=True):
    bound: str
    solved: int
    refused: int


class RefusalRecord(Record, frozen=True):
    """A skeleton, or part of one, that a bound refused: the actions, the worst row, by how much, and where from."""

    bound: str
    actions: list[str]
    reason: str
    amount: float
    unit: str
    place: PlaceRecord | None = None


class SearchNode(Record, frozen=True):
    """A node of the search tree, for drawing: only those expanded or pruned, at most some thousands."""

    id: int
    parent: int
    action: str
    estimate: float
    status: str


class ObjectiveRecord(Record, frozen=True):
    """What a plan was to be best at, as it is spelled: its `value` in `unit` ("" of a sum of several measures), the
    `measures` in it, and `bounds` below which the value is never, by what they hold for."""

    minimise: str
    value: float
    unit: str
    measures: dict[str, float]
    bounds: dict[str, float]


class StatisticsRecord(Record, frozen=True):
    """How a plan was found. `path_cost` is the cost of its motion, `path_cost_before` that before it was polished.
    `objective` is there where another one than the cost of actions was asked for."""

    tree_nodes: int = 0
    expanded_nodes: int = 0
    optimal: bool = False
    gap: float | None = None
    cost: float = 0.0
    bounds: list[BoundRecord] = []
    refusals: list[RefusalRecord] = []
    tree: list[SearchNode] = []
    path_cost: float | None = None
    path_cost_before: float | None = None
    objective: ObjectiveRecord | msgspec.UnsetType = msgspec.UNSET


class MachineRecord(Record, frozen=True):
    """What computed: the model of its processor ("" where the system does not tell), its architecture, the cores that
    the process could use, and the operating system with its release."""

    processor: str
    architecture: str
    cores: int
    system: str


class TimingRecord(Record, frozen=True):
    """Seconds of computing, which differ from one time to the next: per stage, and per window; and on which machine."""

    seconds: dict[str, float] = {}
    windows: list[float] = []
    machine: MachineRecord | None = None


class SourceRecord(Record, frozen=True):
    path: str
    text: str
    sha256: str


class FileRecord(Record, frozen=True):
    """A file that sources name, such as a mesh, byte by byte; base64 in the file."""

    path: str
    data: bytes
    sha256: str


class TaskRecord(Record, frozen=True):
    """What was asked: file and task name, the parameters' final values, the seed, the text of every source, and every
    other file that they name."""

    name: str
    file: str
    parameters: dict[str, float | int]
    seed: int
    sources: list[SourceRecord]
    goal: str
    files: list[FileRecord] = []


class FailureRecord(Record, frozen=True):
    """One thing the verifier refuses: kind, sentence, figure with unit, time, what is concerned, and source place."""

    kind: str
    message: str
    amount: float
    unit: str
    time: float | None = None
    place: PlaceRecord | None = None
    between: list[str] = []


class MeasureRecord(Record, frozen=True):
    """The worst figure of one kind that the verifier measured, when, between what, and the limit it must keep."""

    kind: str
    amount: float
    limit: float
    unit: str
    time: float | None = None
    between: list[str] = []
    place: PlaceRecord | None = None


class VerdictRecord(Record, frozen=True):
    """`verified`: nothing was refused. Only with `goal_reached` does the plan do what it was made for; else `unmet`
    holds the parts of the goal that do not hold at its end. `at_rest`: things move or fail in the scene, but the plan
    was made, and is checked, for the scene at rest."""

    verified: bool
    worst: dict[str, float]
    measures: list[MeasureRecord]
    failures: list[FailureRecord]
    residuals: list[MeasureRecord]
    """One entry per switch constraint of every phase: its own worst row."""
    goal_reached: bool = False
    unmet: list[str] = []
    at_rest: bool = False


class Plan(Record, frozen=True):
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
    needs: list[str] = []
    """Optional parts of the format that a reader must understand."""
    timing: TimingRecord | None = None
    statics: StaticsRecord | msgspec.UnsetType = msgspec.UNSET
    """Where the task asks for physics."""


def what_it_does(plan: Plan) -> Plan:
    """The plan without what is said of it: by what version it was found, how, in what time, and with what verdict."""
    return msgspec.structs.replace(
        plan, versions={}, statistics=StatisticsRecord(), verdict=None, windows=[], timing=None
    )  # fmt: skip
