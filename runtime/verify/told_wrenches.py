"""Whether the torques and the loads of pairs that a plan tells are those of its motion.

What bears alone is compared. In a closed loop the share of loads is open: there the told wrenches must balance what
hangs on them, and keep every strength; the torques of the loop's drives follow from them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from ...compiler import ir
from ..plan import Plan
from ..plan_forces import TorqueRecord, WrenchRecord
from .findings import Findings
from .geometry import Array, crossed
from .strengths import Joined, Looked, Node, Support, Wrench, along_axis, judge, meeting_place
from .told_forces import told

APART = 0.02
"""Share of the greatest told load of its kind in the phase by which a load with inertia may be off, for what the
accelerations of two ways of differentiating differ by: 0.004 was met."""
EXACT = 1e-4
"""The same of loads at rest: places are told to a micrometre."""
ENDS = 1.0
"""The same at the first and the last instant of a motion, where accelerations may jump."""
SLACK = 1e-3
"""N m or N by which a load may be off besides."""
MOST_ROWS = 1000


def told_rows(plan: Plan, phase: int) -> int:
    """The most instants for which a plan tells loads of a phase; 0 where it tells none."""
    return max((min(len(r.values), MOST_ROWS) for r in _records(plan, phase)), default=0)


def _records(plan: Plan, phase: int) -> list[TorqueRecord | WrenchRecord]:
    given = told(plan)
    every: list[TorqueRecord | WrenchRecord] = [] if given is None else [*given.torques, *given.wrenches]
    return [r for r in every if r.phase == phase]


def told_pairs(plan: Plan, problem: ir.Problem, phase: int, at: Looked) -> dict[Joined, Wrench]:
    """What a plan tells that pairs bear in a phase, straight between its instants, right or not."""
    given = told(plan)
    stored = {frozenset(r.between): r for r in (given.wrenches if given is not None else ()) if r.phase == phase}
    found: dict[Joined, Wrench] = {}
    for edge in at.edges:
        record = stored.get(frozenset(edge.names))
        if not edge.joint_of and record is not None:
            rows = _told_at(record, 6, len(at.times))
            if rows is not None:
                place, axes, _ = meeting_place(problem, edge, at.nodes)
                found[edge] = _about_origin(record, edge, rows, place, axes)
    return found


def _told_at(record: TorqueRecord | WrenchRecord, width: int, count: int) -> Array | None:
    """What a record tells at so many instants `(T, width)`, straight in between; None where it does not fit."""
    values = record.values
    least = 1 if isinstance(record, WrenchRecord) or count == 1 else 2
    if not least <= len(values) <= MOST_ROWS or any(len(row) != width for row in values):
        return None
    rows = np.asarray(values, dtype=float).reshape(len(values), width)
    own, here = np.linspace(0.0, 1.0, len(values)), np.linspace(0.0, 1.0, count)
    return np.stack([np.interp(here, own, column) for column in rows.T], axis=1) if width else rows[:0]


def _about_origin(record: WrenchRecord, edge: Joined, rows: Array, place: Array, axes: Array) -> Wrench:
    """What the far side of a pair puts on the near one, from what is told `(T, 6)` in the axes of where they meet."""
    sign = 1.0 if record.between[0] == edge.names[1] else -1.0
    force = sign * np.einsum("tij,tj->ti", axes, rows[:, :3])
    return force, sign * np.einsum("tij,tj->ti", axes, rows[:, 3:]) + crossed(place, force)


def check_forces(
    plan: Plan, problem: ir.Problem, phase: int, at: Looked, support: Support, borne: Mapping[Joined, Wrench],
    moving: bool, findings: Findings,
) -> None:  # fmt: skip
    """Torques and wrenches of a phase, or of what holds after the last one. `borne` is what edges bear alone."""
    given = told(plan)
    if given is None:
        return
    if phase == len(plan.phases) and any(
        not 0 <= n <= phase for n in (*(t.phase for t in given.torques), *(w.phase for w in given.wrenches))
    ):
        findings.fail("structure", "loads are told of a phase that the plan does not have")
    check = _Told(plan, problem, phase, at, support, moving, findings)
    torques = [r for r in given.torques if r.phase == phase]
    wrenches = [r for r in given.wrenches if r.phase == phase]
    known = dict(borne)
    if given.wrenches:
        known |= check.pairs(wrenches, known)
    elif phase == len(plan.phases):
        return
    check.torques(torques, known)


class _Told:
    def __init__(
        self, plan: Plan, problem: ir.Problem, phase: int, at: Looked, support: Support, moving: bool,
        findings: Findings,
    ) -> None:  # fmt: skip
        self.plan, self.problem, self.phase, self.at = plan, problem, phase, at
        self.support, self.findings = support, findings
        self.slack = np.full(len(at.times), APART if moving else EXACT)
        if moving:
            self.slack[[0, -1]] = ENDS
        self.standing = [*support.bridges, *(e for ring in support.rings for e in ring)]

    def rows(self, record: TorqueRecord | WrenchRecord, width: int, whose: str) -> Array | None:
        """What a record tells at all instants `(T, width)`, straight in between; None where it does not fit."""
        rows = _told_at(record, width, len(self.at.times))
        if rows is None:
            self.findings.fail("structure", f"loads of {whose} do not fit")
        return rows

    def torques(self, records: Sequence[TorqueRecord], known: Mapping[Joined, Wrench]) -> None:
        """Compare torques with those that the wrenches of all joints ask for."""
        wanted = {e.joint_of for e in self.standing if e.joint_of}
        if {r.module for r in records} != wanted or len(records) != len(wanted):
            message = "torques are not told of just the modules that stand or hang"
            self.findings.fail("structure", message, time=self.time)
            return
        for record in records:
            names = [j.name for j in self.problem.world.modules[record.module].type.joints]
            stored = self.rows(record, len(names), record.module)
            own = {e: -along_axis(self.problem, e, self.at.nodes, *known[e]) for e in self.standing
                   if e.joint_of == record.module and e in known}  # fmt: skip
            most = max((float(np.abs(rows).max()) for rows in own.values()), default=0.0)
            for edge, rows in own.items() if stored is not None else ():
                assert stored is not None
                what = f"the told torque of joint {edge.names[1]} of {record.module} is not that of its motion"
                self.near(stored[:, names.index(edge.names[1])] - rows, most, what, edge, "N m")

    def near(self, off: Array, most: float, message: str, edge: Joined, unit: str) -> None:
        excess = np.abs(off) - self.slack * most - SLACK
        if not float(excess.max()) <= 0.0:
            worst = int(np.argmax(excess))
            self.findings.fail("statics", message, amount=float(np.abs(off[worst])), unit=unit,
                               time=float(self.at.times[worst]), between=list(edge.names))  # fmt: skip

    @property
    def time(self) -> float:
        return float(self.at.times[0])

    def pairs(self, records: Sequence[WrenchRecord], known: Mapping[Joined, Wrench]) -> dict[Joined, Wrench]:
        """Compare the wrenches of pairs that bear alone, and find those of the edges of rings from what is told."""
        edges = {frozenset(e.names): e for e in self.standing if not e.joint_of}
        stored = {frozenset(r.between): r for r in records}
        if stored.keys() != edges.keys() or len(stored) != len(records):
            self.findings.fail("structure", "loads are not told of just the pairs that bear something", time=self.time)
            return {}
        found: dict[Joined, Wrench] = {}
        for key, edge in edges.items():
            place, axes, radius = meeting_place(self.problem, edge, self.at.nodes)
            rows = self.rows(stored[key], 6, " and ".join(edge.names))
            if rows is None or not self.fits(stored[key], edge, radius):
                return {}
            found[edge] = _about_origin(stored[key], edge, rows, place, axes)
            if edge in known:
                force, moment = found[edge][0] - known[edge][0], found[edge][1] - known[edge][1]
                self.balance(edge, force, moment - crossed(place, force), known)
        for ring in self.support.rings:
            found |= self.ring(ring, found, known)
        return found

    def fits(self, record: WrenchRecord, edge: Joined, radius: float) -> bool:
        names = {n for n in edge.names if record.at == n}
        contact = edge.manner in ("pad", "rest")
        right = record.manner == edge.manner and bool(names) and abs(record.radius - contact * radius) <= SLACK * 1e-3
        if not right:
            message = f"what is told of how {' and '.join(edge.names)} hold is not so"
            self.findings.fail("scene", message, between=list(edge.names))
        return right

    def balance(self, edge: Joined, force: Array, moment: Array, known: Mapping[Joined, Wrench]) -> None:
        """Whether a force and a moment about a place nearby are nothing, measured by what is borne in the phase."""
        most = max([float(np.abs(f).max()) for f, _ in known.values()] + [float(np.abs(self.weight()).max())])
        what = f"the told load of {' and '.join(edge.names)} is not that of its motion"
        self.near(np.linalg.norm(force, axis=1), most, what, edge, "N")
        self.near(np.linalg.norm(moment, axis=1), most, what, edge, "N m")

    def weight(self) -> Array:
        return sum((np.abs(f) for f in self.at.loads.forces.values()), np.zeros((1, 3)))

    def ring(
        self, ring: tuple[Joined, ...], stored: Mapping[Joined, Wrench], known: Mapping[Joined, Wrench]
    ) -> dict[Joined, Wrench]:
        """What the joints of a ring bear under the told wrenches of its pairs. These must balance every module and
        body of it, and all must keep their strengths."""
        root = self.support.root(ring)
        joints, pairs = [e for e in ring if e.joint_of], [e for e in ring if not e.joint_of]
        found: dict[Joined, Wrench] = {}
        for piece in _pieces({n for e in ring for n in (e.near, e.far)}, joints):
            if root not in piece:
                force, moment = self.total(piece, pairs, ring, stored, known)
                edge = next(e for e in pairs if {e.near, e.far} & piece)
                place, _, _ = meeting_place(self.problem, edge, self.at.nodes)
                self.balance(edge, force, moment - crossed(place, force), known)
        for edge in joints:
            rest = [e for e in joints if e is not edge]
            sides = _pieces({n for e in ring for n in (e.near, e.far)}, rest)
            far = next(s for s in sides if edge.far in s)
            side, sign = (far, 1.0) if root not in far else (next(s for s in sides if edge.near in s), -1.0)
            force, moment = self.total(side, pairs, ring, stored, known)
            found[edge] = sign * force, sign * moment
        for edge in ring:
            self.kept(edge, *(found | dict(stored))[edge])
        return found

    def total(
        self, nodes: frozenset[Node], pairs: Sequence[Joined], ring: tuple[Joined, ...],
        stored: Mapping[Joined, Wrench], known: Mapping[Joined, Wrench],
    ) -> Wrench:  # fmt: skip
        """All that pushes on some nodes, about the origin."""
        force, moment = np.zeros((len(self.at.times), 3)), np.zeros((len(self.at.times), 3))
        for node in sorted(nodes):
            if node in self.at.loads.forces:
                force, moment = force + self.at.loads.forces[node], moment + self.at.loads.moments[node]
            for edge in self.support.hanging(node, ring):
                sign = 1.0 if edge.near == node else -1.0
                force, moment = force + sign * known[edge][0], moment + sign * known[edge][1]
        for edge in pairs:
            for inside, sign in ((edge.near, 1.0), (edge.far, -1.0)):
                if inside in nodes:
                    force, moment = force + sign * stored[edge][0], moment + sign * stored[edge][1]
        return force, moment

    def kept(self, edge: Joined, force: Array, moment: Array) -> None:
        """Whether the strengths of an edge of a ring bear what is told."""
        given = told(self.plan)
        for figure in judge(self.problem, edge, self.at.nodes, force, moment, given.safety if given else 1.0):
            limit = SLACK if figure.kind == "tip_m" else 1.0
            self.near(np.maximum(figure.amounts - limit, 0.0), limit, f"by the told loads {figure.message}", edge, "")


def _pieces(nodes: Iterable[Node], edges: Sequence[Joined]) -> list[frozenset[Node]]:
    """The parts into which nodes fall that are joined by nothing but `edges`."""
    owner = {n: frozenset({n}) for n in nodes}
    for edge in edges:
        whole = owner[edge.near] | owner[edge.far]
        owner |= dict.fromkeys(whole, whole)
    return sorted(set(owner.values()), key=sorted)
