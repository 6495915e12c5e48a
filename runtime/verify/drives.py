"""Whether joints without drives move only while something that moves by drives holds them.

Rigid parts are the nodes of a graph; joints and whatever is held together are its edges. A joint without a drive may
move in a phase in which a driven joint moves with which it lies on a ring: a closed way that meets no part twice.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

import numpy as np

from ...compiler import ir
from ..plan import Plan
from .findings import Findings
from .kept_poses import bolted, kept
from .limits import LIMITS
from .sampler import Sampler

WORLD = "the world"
Edge = tuple[object, object]


def check_drives(
    problem: ir.Problem, plan: Plan, modes: Iterable[Iterable[ir.Fact]], sampler: Sampler, findings: Findings
) -> None:
    """Measure how far each joint without a drive moves, on its spline, in each phase in which nothing drives it."""
    passive = {(m.name, i) for m in plan.modules for i, j in enumerate(m.joints) if j.passive}
    if not passive:
        return
    for phase, mode in enumerate(list(modes)[: len(plan.phases)]):
        findings.check_time()
        spans = _spans(plan, phase, sampler)
        graph: _Graph | None = None
        for key in sorted(passive):
            span, free = spans.get(key, 0.0), False
            if span > LIMITS["undriven_m"]:
                graph = graph or _Graph(problem, plan, frozenset(mode))
                free = any(graph.ring(key, other) for other, s in spans.items() if other not in passive and s > 0.0)
            if not free:
                _measure(plan, phase, key, span, findings)


def _measure(plan: Plan, phase: int, key: tuple[str, int], span: float, findings: Findings) -> None:
    name, index = key
    joint = next(m for m in plan.modules if m.name == name).joints[index]
    kind = "undriven_m" if joint.kind == ir.JointKind.PRISMATIC else "undriven_rad"
    message = f"joint {joint.name} of {name} has no drive and moves, held by nothing that drives move"
    findings.measure(kind, span, message, time=plan.phases[phase].start, between=[name, joint.name])


def _spans(plan: Plan, phase: int, sampler: Sampler) -> dict[tuple[str, int], float]:
    """How far each joint that moves in a phase does: from its least to its greatest value on the spline."""
    start, end = plan.phases[phase].start, plan.phases[phase].end
    found = {}
    for module in plan.modules:
        curve = sampler.curve(module.name, phase)
        if curve is None:
            continue
        times, values = curve.extrema()
        ends = curve(np.array([start, end]))
        for index in range(len(module.joints)):
            inside = values[(times[:, index] >= start) & (times[:, index] <= end), index]
            found[module.name, index] = float(np.ptp([*ends[:, index], *inside]))
    return found


class _Graph:
    """The rigid parts of the world in one phase, those held rigidly together as one node."""

    def __init__(self, problem: ir.Problem, plan: Plan, mode: frozenset[ir.Fact]) -> None:
        self._world = problem.world
        touching: dict[object, set[object]] = {}
        for name, body in self._world.bodies.items():
            if not body.movable:
                touching.setdefault((name, -1), set()).add(WORLD)
                touching.setdefault(WORLD, set()).add((name, -1))
        for name in bolted(problem, mode):
            touching.setdefault((name, -1), set()).add(WORLD)
            touching.setdefault(WORLD, set()).add((name, -1))
        pairs = list(kept(problem, mode))
        for one, other in pairs:
            a, b = self._part(one), self._part(other)
            touching.setdefault(a, set()).add(b)
            touching.setdefault(b, set()).add(a)
        self._node = _groups(touching)
        self._joints = {
            (m.name, i): (self._of((m.name, j.parent)), self._of((m.name, i)))
            for m in plan.modules for i, j in enumerate(m.joints)
        }  # fmt: skip
        self._loose = [
            (self._of(self._part(a)), self._of(self._part(b)))
            for literal in mode if _holds(problem, literal) for a in literal[1:] for b in literal[1:] if a < b
        ]  # fmt: skip
        self._leaders = {
            (m.name, i): (m.name, j.follows.leader if j.follows else i)
            for m in plan.modules for i, j in enumerate(m.joints)
        }  # fmt: skip

    def _part(self, name: str) -> object:
        end = self._world.effector(name)
        return (name, -1) if end is None else (end[0].name, end[1].joint)

    def _of(self, part: object) -> object:
        return self._node.get(part, part)

    def ring(self, one: tuple[str, int], other: tuple[str, int]) -> bool:
        """Whether a ring goes over two joints, or over one that follows the same as the first."""
        led = [key for key, leader in self._leaders.items() if leader == self._leaders[one]]
        return any(self._on_ring(key, other) for key in led)

    def _on_ring(self, one: tuple[str, int], other: tuple[str, int]) -> bool:
        first, second = self._joints[one], self._joints[other]
        if first[0] == first[1] or second[0] == second[1]:
            return False
        edges = [e for key, e in self._joints.items() if key not in (one, other)] + self._loose
        return _two_ways(edges, first, second)


def _holds(problem: ir.Problem, literal: ir.Fact) -> bool:
    """Whether a literal holds its objects together by `keep` rows or by equations that hold all the time."""
    rows = problem.motions[literal[0]].rows
    return any(row.when == "keep" or (row.when == "during" and row.operator == "=") for row in rows)


def _groups(touching: dict[object, set[object]]) -> dict[object, object]:
    """For each part one that stands for all that are held together with it, directly or through others."""
    found: dict[object, object] = {}
    for start in touching:
        waiting = [] if start in found else [start]
        while waiting:
            part = waiting.pop()
            if part not in found:
                found[part] = start
                waiting += touching[part]
    return found


def _two_ways(edges: list[Edge], sources: Edge, sinks: Edge) -> bool:
    """Whether two ways lead from the two ends of one edge to the two of another without a common node (Menger): a flow
    of two through nodes of capacity one, found by two searches; the second may take back what the first took."""
    after: dict[object, dict[object, int]] = {}

    def link(a: object, b: object) -> None:
        after.setdefault(a, {}).setdefault(b, 0)
        after[a][b] += 1
        after.setdefault(b, {}).setdefault(a, 0)

    for node in {n for edge in (*edges, sources, sinks) for n in edge}:
        link(("in", node), ("out", node))
    for a, b in edges:
        link(("out", a), ("in", b))
        link(("out", b), ("in", a))
    for node in sources:
        link("source", ("in", node))
    for node in sinks:
        link(("out", node), "sink")
    return all(_augment(after) for _ in range(2))


def _augment(after: dict[object, dict[object, int]]) -> bool:
    came: dict[object, object] = {"source": "source"}
    waiting = deque[object](["source"])
    while waiting and "sink" not in came:
        node = waiting.popleft()
        for other, room in after.get(node, {}).items():
            if room > 0 and other not in came:
                came[other] = node
                waiting.append(other)
    if "sink" not in came:
        return False
    at: object = "sink"
    while at != "source":
        after[came[at]][at] -= 1
        after[at][came[at]] += 1
        at = came[at]
    return True
