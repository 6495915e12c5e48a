"""Plan files of format 1 as plans of today's format. Nothing is taken on trust that a plan of today must show."""

from __future__ import annotations

import msgspec

from .plan import (
    FORMAT,
    NO_LIMIT,
    BodyRecord,
    BodyTrackRecord,
    BoundRecord,
    BreakdownRecord,
    CourseRecord,
    FileRecord,
    LiteralRecord,
    ModuleRecord,
    PhaseRecord,
    Plan,
    RefusalRecord,
    SearchNode,
    SourceRecord,
    SplineRecord,
    StatisticsRecord,
    TaskRecord,
    TimingRecord,
    TrackRecord,
    VerdictRecord,
    WindowRecord,
)

FORMAT_1 = "tamplang-plan/1"
TEXT = ".tamp"
"""How the names of sources end; those of URDFs and meshes, which format 1 kept among them, do not."""


class Task1(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    name: str
    file: str
    parameters: dict[str, float | int]
    seed: int
    sources: list[SourceRecord]
    goal: str


class Window1(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    time: float
    phase: int
    reason: str
    seconds: float
    actions: list[str]
    motions: int
    unmet: list[str]


class BodyTrack1(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    name: str
    poses: list[list[float]]


class Spline1(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    module: str
    phase: int
    knots: list[float]
    values: list[list[float]]


class Bound1(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    bound: str
    solved: int
    refused: int
    seconds: float


class Statistics1(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    tree_nodes: int = 0
    expanded_nodes: int = 0
    optimal: bool = False
    gap: float | None = None
    cost: float = 0.0
    seconds: dict[str, float] = {}
    bounds: list[Bound1] = []
    refusals: list[RefusalRecord] = []
    tree: list[SearchNode] = []
    path_cost: float | None = None
    path_cost_before: float | None = None


class Plan1(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A plan of format 1; parts that have not changed are those of today."""

    format: str
    versions: dict[str, str]
    task: Task1
    modules: list[ModuleRecord]
    bodies: list[BodyRecord]
    phases: list[PhaseRecord]
    final_mode: list[LiteralRecord]
    times: list[float]
    tracks: list[TrackRecord]
    body_tracks: list[BodyTrack1]
    splines: list[Spline1]
    statistics: Statistics1
    verdict: VerdictRecord | None = None
    courses: list[CourseRecord] = []
    breakdowns: list[BreakdownRecord] = []
    windows: list[Window1] = []
    complete: bool = True


class EarlyPlan(Plan, frozen=True):
    """A plan from before joints had limits of acceleration: its file states none. The motion has to keep those of its
    module types all the same."""


def upgraded(old: Plan1) -> Plan:
    """The same plan in today's format."""
    statistics = old.statistics
    stated = all(joint.acceleration != NO_LIMIT for module in old.modules for joint in module.joints)
    return (Plan if stated else EarlyPlan)(
        format=FORMAT,
        versions=old.versions,
        task=_task(old.task),
        modules=old.modules,
        bodies=old.bodies,
        phases=old.phases,
        final_mode=old.final_mode,
        times=old.times,
        tracks=old.tracks,
        body_tracks=[BodyTrackRecord(track.name, 0, track.poses) for track in old.body_tracks],
        splines=[SplineRecord(s.module, s.phase, s.phase, s.knots, s.values) for s in old.splines if any(s.values)],
        statistics=StatisticsRecord(
            tree_nodes=statistics.tree_nodes,
            expanded_nodes=statistics.expanded_nodes,
            optimal=statistics.optimal,
            gap=statistics.gap,
            cost=statistics.cost,
            bounds=[BoundRecord(b.bound, b.solved, b.refused) for b in statistics.bounds],
            refusals=statistics.refusals,
            tree=statistics.tree,
            path_cost=statistics.path_cost,
            path_cost_before=statistics.path_cost_before,
        ),
        verdict=old.verdict,
        courses=old.courses,
        breakdowns=old.breakdowns,
        windows=[WindowRecord(w.time, w.phase, w.reason, w.actions, w.motions, w.unmet) for w in old.windows],
        complete=old.complete,
        timing=TimingRecord(statistics.seconds, [w.seconds for w in old.windows]),
    )


def _task(old: Task1) -> TaskRecord:
    """A URDF becomes a file. Of a mesh format 1 kept only the corners of its hull, from which it cannot be made again:
    it is left out, and a checker says that it lacks."""
    texts = [s for s in old.sources if s.path.endswith(TEXT)]
    models = [s for s in old.sources if not s.path.endswith(TEXT) and s.text.lstrip().startswith("<")]
    files = [FileRecord(s.path, s.text.encode("utf-8", "surrogatepass"), s.sha256) for s in models]
    return TaskRecord(old.name, old.file, old.parameters, old.seed, texts, old.goal, files)
