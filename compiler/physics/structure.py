"""What bears what while some motion literals hold: rigid nodes (the world, moving frames, bodies) and what joins them
(joints, kept pairs), as trees that grow out of the world, and the pairs left over, which close loops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ...langs.frozen import dataclass
from ...langs.source import Span
from ..ir import IDENTITY, Fact, Hold, JointKind, ModuleType, Problem
from ..kept_pairs import kept_pairs
from ..motion.bolted import bolted
from ..remembering import remembered
from .records import CONTACTS, NOTHING, weaker

Node = tuple[str, int]
"""A module and the joint whose moving frame it is (-1: the module frame), or a body and -1. The world is WORLD."""
WORLD: Node = ("", -1)
STRAIGHT = IDENTITY[3:]


@dataclass(frozen=True, slots=True)
class Edge:
    """`child` is borne by `parent`. Of a joint `joint` is its index in the module of `child`; of a kept pair `manner`
    tells how it holds, `hold` how strongly (None: without limit), `names` are its two objects and `place` is the one
    whose frame and shape tell where they meet; `turned`: the first of them hangs on the second."""

    parent: Node
    child: Node
    joint: int = -1
    names: tuple[str, str] = ("", "")
    manner: str = ""
    hold: Hold | None = None
    place: str = ""
    turned: bool = False

    @property
    def is_joint(self) -> bool:
        return self.joint >= 0


@dataclass(frozen=True, slots=True)
class Structure:
    """`edges` of the trees, each behind the one that bears its parent; `loops` close loops among nodes of the trees.
    Loads may be taken by `loops` in any share."""

    edges: tuple[Edge, ...]
    loops: tuple[Edge, ...]

    @property
    def all(self) -> tuple[Edge, ...]:
        return (*self.edges, *self.loops)


@remembered(8)
def structure(problem: Problem, mode: frozenset[Fact]) -> Structure:
    """The structure while `mode` holds. What is joined to nothing at rest is left out: it lies where it lies."""
    still = {(name, -1): WORLD for name in bolted(problem, mode)}
    links = [
        replace(edge, parent=still.get(edge.parent, edge.parent), child=still.get(edge.child, edge.child))
        for edge in (*_joints(problem), *_pairs(problem, mode))
    ]
    around: dict[Node, list[tuple[Edge, Node]]] = {}
    for edge in links:
        around.setdefault(edge.parent, []).append((edge, edge.child))
        around.setdefault(edge.child, []).append((edge, edge.parent))
    reached, edges, used = {WORLD}, list[Edge](), set[int]()
    for foot, first in around.get(WORLD, []):
        if first in reached:
            continue
        waiting = [(foot, WORLD, first)]
        while waiting:
            edge, parent, child = waiting.pop(0)
            if child in reached:
                continue
            reached.add(child)
            used.add(id(edge))
            edges.append(edge if edge.child == child else _turned(edge))
            waiting += [(e, child, n) for e, n in around[child] if n != WORLD and n not in reached and n != parent]
    loops = [e for e in links if id(e) not in used and e.parent in reached and e.child in reached]
    return Structure(tuple(edges), tuple(loops))


def _turned(edge: Edge) -> Edge:
    return Edge(edge.child, edge.parent, edge.joint, edge.names, edge.manner, edge.hold, edge.place, not edge.turned)


def _joints(problem: Problem) -> list[Edge]:
    return [
        Edge((name, joint.parent), (name, index), index, (name, joint.name))
        for name, module in problem.world.modules.items()
        for index, joint in enumerate(module.type.joints)
    ]


def _pairs(problem: Problem, mode: frozenset[Fact]) -> list[Edge]:
    """One edge for each pair whose relative pose is kept, but for those that bear nothing."""
    borne: dict[frozenset[str], str] = {}
    for literal in sorted(mode):
        manner = problem.motions[literal[0]].borne
        if manner is not None:
            borne.setdefault(frozenset(literal[1:3]), manner)
    found: dict[frozenset[str], Edge] = {}
    for pair in kept_pairs(problem, mode):
        if frozenset(pair) in found:
            continue
        manner = borne.get(frozenset(pair), "")
        below, above = node_of(problem, pair[0]), node_of(problem, pair[1])
        if manner == NOTHING or below == above:
            continue
        names = pair
        if above == WORLD or (below != WORLD and manner in CONTACTS and _rests_on(problem, pair, mode)):
            below, above, names = above, below, (pair[1], pair[0])
        place = names[1] if names[1] in problem.world.bodies or problem.world.effector(names[1]) else names[0]
        if problem.world.effector(names[0]) and names[1] in problem.world.bodies:
            place = names[0]
        hold = weaker(_hold(problem, pair[0], manner), _hold(problem, pair[1], manner), manner)
        found[frozenset(pair)] = Edge(below, above, -1, names, manner, hold, place)
    return list(found.values())


def _rests_on(problem: Problem, pair: tuple[str, str], mode: frozenset[Fact]) -> bool:
    """Whether the first of a pair is the one that rests on the second: the literal that says how it is borne names it
    first."""
    return any(problem.motions[f[0]].borne in CONTACTS and f[1:3] == pair for f in mode)


def node_of(problem: Problem, name: str) -> Node:
    found = problem.world.effector(name)
    if found is not None:
        return found[0].name, found[1].joint
    if name in problem.world.modules:
        return name, -1
    return (name, -1) if problem.world.bodies[name].movable else WORLD


def _hold(problem: Problem, name: str, manner: str) -> Hold | None:
    found = problem.world.effector(name)
    body = problem.world.bodies.get(name)
    holds: tuple[Hold, ...] = found[1].holds if found is not None else body.holds if body is not None else ()
    return next((h for h in holds if h.manner == manner), None)


def driven(kind: ModuleType, node: int) -> int:
    """Where what stands on a planar joint has driven to: the moving frame of the planar joint that `node` carries, or
    `node` itself where there is none."""
    for first, joint in enumerate(kind.joints[: len(kind.joints) - 2]):
        second, turn = kind.joints[first + 1 : first + 3]
        slides = joint.kind == second.kind == JointKind.PRISMATIC and joint.placement[3:] == STRAIGHT
        here = second.placement == turn.placement == IDENTITY and (second.parent, turn.parent) == (first, first + 1)
        if joint.parent == node and slides and here and turn.kind == JointKind.REVOLUTE:
            return first + 2
    return node


def stated_at(problem: Problem, edge: Edge) -> Span | None:
    """Where the strength of an edge is written."""
    if edge.is_joint:
        return problem.world.modules[edge.names[0]].type.joints[edge.joint].stated
    return None if edge.hold is None else edge.hold.span


def subtrees(found: Structure) -> Mapping[Node, frozenset[int]]:
    """The edges, by number, on the way from the world to each node."""
    ways: dict[Node, frozenset[int]] = {WORLD: frozenset()}
    for number, edge in enumerate(found.edges):
        ways[edge.child] = ways[edge.parent] | {number}
    return ways
