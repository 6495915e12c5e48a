"""The least moments that a reach asks for, whatever the posture: an end that must come to a place far from where its
robot is held keeps the weights between them out there.

Everything is bounded by lengths along the robot, so that no posture that bears itself is ever refused: a weight is at
least as far out as the place, less what lies between weight and end, and at most so far behind a joint as lies between
these. What is not known (how a pair is joined, where a foot stands) makes a length infinite, and the moment 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from ....compiler.extents import box_sides
from ....compiler.ir import Arith, Effector, Fact, Function, JointKind, Number, Problem, Term, Var
from ....compiler.physics.frames import GRAVITY, node_weights, poses, rotation
from ....compiler.physics.outlines import driven_away, foot_radius
from ....compiler.physics.records import CONTACTS
from ....compiler.physics.safety import safety_of
from ....compiler.physics.structure import WORLD, Edge, Node, Structure, driven, node_of, stated_at, structure
from ....compiler.remembering import remembered
from ....langs.frozen import dataclass
from ...skeleton import Array, Breach, Violation, start_configuration
from .nearness import AS_PLACED, NOWHERE, Joined, radius_of
from .settings import STATICS


@dataclass(frozen=True, slots=True)
class Site:
    """A point fixed to a node, in its frame."""

    node: Node
    point: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Region:
    """Where an end must come to: corners `(N, 2)` of what its middle is over, and how far beside them it may be."""

    end: Site
    corners: tuple[tuple[float, float], ...]
    beside: float


def far_out(
    problem: Problem, mode: frozenset[Fact], added: frozenset[Fact], still: Joined, phase: int
) -> list[Violation]:
    """What no posture bears at the switch at which literals are `added`: joints and pairs, each with the least moment,
    N m. `still` tells of the pairs kept there how near their frames are."""
    return [
        Violation(
            phase, kind, edge.names, safety_of(problem.options) * moment - most, "N m", stated_at(problem, edge),
            load=(moment, safety_of(problem.options), most), when="at the switch in any posture",
        )
        for edge, kind, moment, most in _least(problem, mode, added, still)
        if safety_of(problem.options) * moment > most
    ]  # fmt: skip


@remembered(8)
def _least(
    problem: Problem, mode: frozenset[Fact], added: frozenset[Fact], still: Joined
) -> tuple[tuple[Edge, Breach, float, float], ...]:
    """What bears moments on the way to ends that must come to known places: kind, least moment, and the most that it
    bears."""
    return tuple(
        borne for region in _regions(problem, added, still) for borne in least_moments(problem, mode, still, region)
    )


def least_moments(
    problem: Problem, mode: frozenset[Fact], still: Joined, region: Region
) -> list[tuple[Edge, Breach, float, float]]:
    """The same of an end that must come to a region."""
    built = structure(problem, mode)
    if built.loops:
        return []
    tree = _BearingTree(problem, built, still, region.end.node)
    return [] if tree.root is None else list(tree.moments(region))


def _regions(problem: Problem, added: frozenset[Fact], still: Joined) -> Iterator[Region]:
    """What rows of switches tell about where ends come to: over a top, or against something that lies still."""
    for literal in sorted(added):
        predicate = problem.motions[literal[0]]
        given = {v.name: name for v, name in zip(predicate.variables, literal[1:], strict=True)}
        for row in predicate.rows:
            left = row.left
            if row.when != "switch" or not isinstance(left, Function) or left.name not in ("inside", "gap"):
                continue
            first, second = (given.get(a.name) if isinstance(a, Var) else None for a in left.args)
            most = row.right.value if isinstance(row.right, Number) else NOWHERE
            if left.name == "inside" and row.operator == ">=" and _positive(row.right):
                yield from _over(problem, first, second, still, 0.0, level=True)
            elif left.name == "gap" and row.operator in ("=", "<=") and math.isfinite(most):
                yield from _over(problem, first, second, still, max(most, 0.0))
                yield from _over(problem, second, first, still, max(most, 0.0))


def _over(
    problem: Problem, end: str | None, below: str | None, still: Joined, apart: float, *, level: bool = False
) -> Iterator[Region]:
    """An end whose middle is over something `level` that lies still, or whose shape is so far `apart` from its."""
    effector = None if end is None else problem.world.effector(end)
    body = None if below is None else problem.world.bodies.get(below)
    if effector is None or body is None or end is None or not _lies_still(problem, body.name, still):
        return
    sides = np.asarray(box_sides(body.shape)) / 2.0
    turn, place = rotation(np.asarray(body.pose[3:])), np.asarray(body.pose[:3])
    signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    corners = (place + (signs * sides) @ turn.T)[:, :2]
    if level and abs(turn[2, 2]) < STATICS.level:
        return
    beside = apart + STATICS.missed + radius_of(problem, end)
    yield Region(_end_site(effector[0].name, effector[1]), tuple((float(x), float(y)) for x, y in corners), beside)


def _lies_still(problem: Problem, name: str, still: Joined) -> bool:
    """Whether a body is where the scene puts it: it cannot move, or has been kept on such a one from the start on."""
    bodies = problem.world.bodies
    if any(course.body == name for course in problem.world.courses):
        return False
    if not bodies[name].movable:
        return True
    under = (other for pair, apart in still if apart == AS_PLACED and name in pair for other in pair - {name})
    return any(other in bodies and not bodies[other].movable for other in under)


def _positive(term: Term | None) -> bool:
    """Whether a term is at least 0 wherever the robot is."""
    match term:
        case Number():
            return term.value >= 0.0
        case Function(name="least"):
            return all(_positive(a) for a in term.args)
        case Function(name="inside", args=(first, second)):
            return first == second
        case Function(name="radius"):
            return True
        case Arith(operator="+" | "*" | "/"):
            return all(_positive(o) for o in term.operands)
        case _:
            return False


def _end_site(module: str, end: Effector) -> Site:
    x, y, z = end.placement[:3]
    return Site((module, end.joint), (x, y, z))


class _BearingTree:
    """The tree that bears an end, with the length of the ways in it."""

    def __init__(self, problem: Problem, built: Structure, still: Joined, end: Node) -> None:
        self._problem, self._still = problem, dict(still)
        self._above = {e.child: e for e in built.edges}
        self._ways: dict[Node, list[tuple[Site, Site, float]]] = {}
        self._start = start_configuration(problem)
        modules = {name: row[None] for name, row in self._start.modules.items()}
        bodies = {name: row[None] for name, row in self._start.bodies.items()}
        self._at = poses(problem, modules, bodies)
        path = [end]
        while path[-1] in self._above and path[-1] != WORLD:
            path.append(self._above[path[-1]].parent)
        self.path = [self._above[node] for node in path[:-1]] if path[-1] == WORLD else []
        self._edges = built.edges
        for edge in built.edges:
            if edge.parent != WORLD:
                near, far, apart = self._joined(edge)
                self._ways.setdefault(near.node, []).append((near, far, apart))
                self._ways.setdefault(far.node, []).append((far, near, apart))
        self.root = self._anchor(self.path[-1]) if self.path else None

    def _anchor(self, edge: Edge) -> tuple[Site, Array, float] | None:
        """A point of the robot whose place in the world is known, and how far from there it may be."""
        if edge.is_joint:
            joint = self._problem.world.modules[edge.names[0]].type.joints[edge.joint]
            return Site(edge.child, (0.0, 0.0, 0.0)), self._at.places[edge.child][0], 2.0 * joint.slide
        if self._still.get(frozenset(edge.names)) != AS_PLACED:
            return None
        own = next((n for n in edge.names if node_of(self._problem, n) == edge.child), None)
        if own is None:
            return None
        site = self._site(own)
        return site, self._placed(site), 0.0

    def _site(self, name: str) -> Site:
        found = self._problem.world.effector(name)
        return Site((name, -1), (0.0, 0.0, 0.0)) if found is None else _end_site(found[0].name, found[1])

    def _placed(self, site: Site) -> Array:
        """Where a point is at the start."""
        return np.asarray(self._at.places[site.node][0] + self._at.turns[site.node][0] @ np.asarray(site.point))

    def _joined(self, edge: Edge) -> tuple[Site, Site, float]:
        """The points where parent and child of an edge are joined, and how far these are from each other at most."""
        if edge.is_joint:
            joint = self._problem.world.modules[edge.names[0]].type.joints[edge.joint]
            x, y, z = joint.placement[:3]
            base, moving = Site((edge.names[0], joint.parent), (x, y, z)), Site((edge.names[0], edge.joint), (0.0,) * 3)
            near, far = (base, moving) if edge.child == moving.node else (moving, base)
            return near, far, joint.slide
        first, second = (self._site(name) for name in edge.names)
        near, far = (first, second) if second.node == edge.child else (second, first)
        apart = self._still.get(frozenset(edge.names), NOWHERE)
        if apart == AS_PLACED:
            apart = float(np.linalg.norm(self._placed(near) - self._placed(far)))
        return near, far, apart

    def _lengths(self, site: Site) -> dict[Node, tuple[float, Array]]:
        """How far it is at most from a point to where one comes to each node, and that point."""
        found = {site.node: (0.0, np.asarray(site.point))}
        waiting = [site.node]
        while waiting:
            node = waiting.pop()
            far, entry = found[node]
            for here, there, apart in self._ways.get(node, []):
                if there.node not in found:
                    way = far + float(np.linalg.norm(entry - np.asarray(here.point))) + apart
                    found[there.node] = way, np.asarray(there.point)
                    waiting.append(there.node)
        return found

    def moments(self, region: Region) -> Iterator[tuple[Edge, Breach, float, float]]:
        """What the pairs and joints on the way to the end bear at least."""
        assert self.root is not None
        site, place, loose = self.root
        out = _farthest(place[:2], region) - loose
        if out <= 0.0:
            return
        from_root, from_end = self._lengths(site), self._lengths(region.end)
        beyond: set[Node] = set()
        weights = node_weights(self._problem, [e.child for e in self._edges])
        children: dict[Node, list[Node]] = {}
        for edge in self._edges:
            children.setdefault(edge.parent, []).append(edge.child)
        for edge in self.path:
            waiting = [edge.child]
            while waiting:
                node = waiting.pop()
                if node not in beyond:
                    beyond.add(node)
                    waiting += children.get(node, [])
            bearing = _bearing(self._problem, edge, sum(weights[n].mass for n in beyond if n in weights))
            if bearing is None:
                continue
            at, slack = self._meets(edge)
            near = _length(from_root, at.node, np.asarray(at.point)) + slack
            own, moment = self._lengths(at), 0.0
            for node in beyond & weights.keys():
                weight = weights[node]
                behind = _length(own, node, weight.centre) + slack
                least = max(out - _length(from_end, node, weight.centre) - near, -behind)
                moment += weight.mass * GRAVITY * least
            if math.isfinite(moment) and moment > 0.0:
                yield edge, bearing[0], moment, bearing[1]

    def _meets(self, edge: Edge) -> tuple[Site, float]:
        """The point about which an edge bears moments, and how far from there that may be."""
        if edge.is_joint:
            return Site((edge.names[0], edge.joint), (0.0, 0.0, 0.0)), 0.0
        found = self._problem.world.effector(edge.place)
        if found is not None and edge.manner in CONTACTS and driven_away(found):
            return Site((found[0].name, driven(found[0].type, found[1].joint)), (0.0, 0.0, 0.0)), 0.0
        return self._site(edge.place), radius_of(self._problem, edge.place)


def _length(known: Mapping[Node, tuple[float, Array]], node: Node, point: Array) -> float:
    if node not in known:
        return NOWHERE
    far, entry = known[node]
    return far + float(np.linalg.norm(entry - point))


def _farthest(place: Array, region: Region) -> float:
    """How far all of a region is from a place at least, over the ground: along the best of some directions."""
    angles = 2.0 * math.pi * np.arange(STATICS.directions) / STATICS.directions
    directions = np.stack([np.cos(angles), np.sin(angles)])
    return float(((np.asarray(region.corners) - place) @ directions).min(axis=0).max()) - region.beside


def _bearing(problem: Problem, edge: Edge, mass: float) -> tuple[Breach, float] | None:
    """The greatest moment, N m, that a joint or a pair bears in any direction."""
    if edge.is_joint:
        joint = problem.world.modules[edge.names[0]].type.joints[edge.joint]
        along = joint.strength(still=True) if joint.kind == JointKind.REVOLUTE else 0.0
        most = math.hypot(along, joint.bearing)
        return (Breach.BEARING, most) if math.isfinite(most) else None
    hold = edge.hold
    if hold is None:
        return None
    if edge.manner not in CONTACTS:
        most = math.hypot(hold.moment, hold.twist)
        return (Breach.DOCK, most) if math.isfinite(most) else None
    most = hold.moment
    sticks = hold.force if edge.manner == "pad" else 0.0
    if not math.isfinite(most) and math.isfinite(sticks):
        most = foot_radius(problem, edge.place) * (sticks + mass * GRAVITY)
    return (Breach.FOOT, most) if math.isfinite(most) else None


