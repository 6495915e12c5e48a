"""How a solve ended that found no plan, for the page: in words, and in a colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from msgspec import structs

from ...compiler.ir import Problem
from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ...langs.render import render
from ...langs.source import Source, Span
from ..budget import Status
from ..plan import BodyTrackRecord, Plan, TrackRecord
from ..skeleton import Configuration, NearestMiss, start_configuration

HEADLINES = {
    Status.INFEASIBLE: "no plan: proved",
    Status.EXHAUSTED: "no plan found",
    Status.BUDGET: "unfinished",
    Status.MEMORY: "unfinished",
    Status.INTERRUPTED: "unfinished",
    Status.REFUSED: Status.REFUSED,
}
WHY = {
    Status.INFEASIBLE: "It is proved that no sequence of actions reaches the goal.",
    Status.EXHAUSTED: "Every candidate was refused, which is no proof that there is none.",
    Status.BUDGET: "The time or the nodes were spent; with more of them the search would go on.",
    Status.MEMORY: "The memory was spent; with more of it the search would go on.",
    Status.INTERRUPTED: "The run was ended by its user.",
    Status.REFUSED: "The verifier refuses the plan that was found.",
}


@dataclass(frozen=True, slots=True)
class Told:
    """A message, as code and text with the lines that it points to; `seconds` are those at which its misses are drawn.
    """

    code: str
    text: str
    seconds: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Ending:
    """`status` is that of the solve; `told` holds what refused the task. `postures` is the scene at the start, and
    second after second in the postures that came nearest, `misses` what they miss."""

    status: Status
    told: tuple[Told, ...]
    misses: tuple[NearestMiss, ...]
    postures: Plan

    @property
    def headline(self) -> str:
        return HEADLINES[self.status]

    @property
    def why(self) -> str:
        return WHY[self.status]

    @property
    def colour(self) -> str:
        """The class of the verdict: red for what is proved or refused, amber for what is open."""
        return "refused" if self.status in (Status.INFEASIBLE, Status.REFUSED) else "unfinished"


def ending_of(
    problem: Problem, status: Status, explanation: Sequence[Diagnostic], misses: Sequence[NearestMiss], scene: Plan
) -> Ending:
    """The ending of a solve of `problem`, whose `scene` at the start is drawn, and what of it `misses` tell."""
    sources: dict[str, Source] = {problem.called(s.path): s for s in problem.sources}
    waiting = list(enumerate(misses, start=1))
    told = []
    for diagnostic in explanation:
        own = [second for second, miss in waiting if _tells(diagnostic, miss)]
        told.append(Told(diagnostic.code, render([_anywhere(problem, diagnostic)], sources), tuple(own)))
    postures = in_postures(scene, problem, [miss.posture for miss in misses])
    return Ending(status, tuple(told), tuple(misses), postures)


def _anywhere(problem: Problem, diagnostic: Diagnostic) -> Diagnostic:
    """A diagnostic that calls files as they are called on any machine."""

    def called(span: Span) -> Span:
        return replace(span, file=problem.called(span.file))

    labels = tuple(replace(label, span=called(label.span)) for label in diagnostic.labels)
    return replace(diagnostic, span=diagnostic.span and called(diagnostic.span), labels=labels)


def _tells(diagnostic: Diagnostic, miss: NearestMiss) -> bool:
    return diagnostic.message == miss.message and miss.row in f"{diagnostic.message} {diagnostic.note}"


def in_postures(scene: Plan, problem: Problem, postures: Sequence[Configuration]) -> Plan:
    """The scene at the start, and then each posture, a second for each."""
    rows = [start_configuration(problem), *postures]
    tracks = []
    for name in problem.world.modules:
        slots = np.stack([row.modules[name] for row in rows])
        tracks.append(TrackRecord(name, slots[:, :7].tolist(), slots[:, 7:].tolist()))
    bodies = [
        BodyTrackRecord(name, 0, np.stack([row.bodies[name] for row in rows]).tolist())
        for name, start in rows[0].bodies.items()
        if any(not np.array_equal(row.bodies[name], start) for row in rows)
    ]
    times = [float(second) for second in range(len(rows))]
    return structs.replace(scene, times=times, tracks=tracks, body_tracks=bodies)
