"""Joints without drives: which of them can move while a mode holds, and which keep their values.

Rigid parts are the nodes of a graph, joints and what is held its edges. A joint without a drive can move only on a ring
of this graph that a driven joint is on too: else its brake holds it. Rings that share more than one part are one block,
and what moves one of its joints can move all.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from ...compiler.ir import Fact, Problem
from ...compiler.kept_pairs import keeps_pose
from ...compiler.motion.bolted import bolted
from ...compiler.remembering import remembered

Part = tuple[str, int]
"""A module or body, and the joint whose moving frame it is; -1 of the thing itself."""
WORLD: Part = ("", -1)
Edge = tuple[Part, Part]
Joint = tuple[str, int]


@remembered(8)
def braked(problem: Problem, mode: frozenset[Fact]) -> Mapping[str, frozenset[int]]:
    """By module, the joints without drives that keep their values while `mode` holds."""
    modules = [m for m in problem.world.modules.values() if any(j.passive for j in m.type.joints)]
    if not modules:
        return {}
    joints, edges = _graph(problem, mode)
    block = _blocks(edges)
    driven = {block[k] for k, (m, i) in enumerate(joints) if not problem.world.modules[m].type.joints[i].passive}
    moving = {key for k, key in enumerate(joints) if block[k] in driven and edges[k][0] != edges[k][1]}
    found = {}
    for module in modules:
        leaders = [i if j.follows is None else j.follows.leader for i, j in enumerate(module.type.joints)]
        led = {leader for i, leader in enumerate(leaders) if (module.name, i) in moving}
        passive = [leader for leader in leaders if module.type.joints[leader].passive and leader not in led]
        found[module.name] = frozenset(i for i, leader in enumerate(leaders) if leader in passive)
    return found


@remembered(8)
def ringed(problem: Problem, mode: frozenset[Fact]) -> Mapping[str, frozenset[int]]:
    """By module, the joints that lie on closed rings while `mode` holds: none of them moves alone. Where all of a ring
    keep their values, what hangs on it can move as if the ring were one rigid thing."""
    joints, edges = _graph(problem, mode)
    block = _blocks(edges)
    count = Counter(block)
    found: dict[str, set[int]] = {}
    for k, (name, i) in enumerate(joints):
        if count[block[k]] > 1 or edges[k][0] == edges[k][1]:
            found.setdefault(name, set()).add(i)
    return {name: frozenset(joints) for name, joints in found.items()}


def _graph(problem: Problem, mode: frozenset[Fact]) -> tuple[dict[Joint, Edge], list[Edge]]:
    """The edge of each joint, and all edges: those of the joints first, in their order."""
    rigid, loose = _holds(problem, mode)
    joints = {
        (name, i): (rigid[name, j.parent], rigid[name, i])
        for name, m in problem.world.modules.items() for i, j in enumerate(m.type.joints)
    }  # fmt: skip
    return joints, [*joints.values(), *loose]


def _holds(problem: Problem, mode: frozenset[Fact]) -> tuple[dict[Part, Part], list[Edge]]:
    """Every part by the one that stands for all that is rigidly held to it, and what else is held together: by rows
    that keep less than a pose, and by equations that hold all the time."""
    world = problem.world
    parts: dict[Part, Part] = {WORLD: WORLD}
    for name, module in world.modules.items():
        parts |= {(name, i): (name, i) for i in range(-1, len(module.type.joints))}
    parts |= {(name, -1): WORLD for name in bolted(problem, mode)}

    def root(part: Part) -> Part:
        while parts[part] != part:
            part = parts[part]
        return part

    def part_of(name: str) -> Part:
        end = world.effector(name)
        part = (name, -1) if end is None else (end[0].name, end[1].joint)
        if name in world.bodies:
            parts.setdefault(part, part if world.bodies[name].movable else WORLD)
        return part

    loose: list[Edge] = []
    for literal in sorted(mode):
        kept = keeps_pose(problem, literal)
        if kept is not None:
            a, b = sorted((root(part_of(kept[0])), root(part_of(kept[1]))))
            parts[b] = a
        rows = problem.motions[literal[0]].rows
        if any(row.when == "keep" or (row.when == "during" and row.operator == "=") for row in rows):
            things = [part_of(n) for n in literal[1:]]
            loose += [(a, b) for k, a in enumerate(things) for b in things[k + 1 :]] if kept is None else []
    return {part: root(part) for part in parts}, [(root(a), root(b)) for a, b in loose]


def _blocks(edges: list[Edge]) -> list[int]:
    """For each edge the number of its block: two edges have one number when some ring without a node twice goes over
    both (Hopcroft and Tarjan 1973, without recursion)."""
    at: dict[Part, list[int]] = {}
    for k, (a, b) in enumerate(edges):
        for part in {a, b}:
            at.setdefault(part, []).append(k)
    block = [-1] * len(edges)
    depth: dict[Part, int] = {}
    low: dict[Part, int] = {}
    count = 0
    for start in at:
        if start in depth:
            continue
        depth[start] = low[start] = 0
        stack: list[tuple[Part, int, int]] = [(start, -1, 0)]
        passed: list[int] = []
        while stack:
            part, came, number = stack[-1]
            if number < len(at[part]):
                stack[-1] = (part, came, number + 1)
                k = at[part][number]
                other = edges[k][0] if edges[k][1] == part else edges[k][1]
                if k == came or block[k] >= 0 or other == part:
                    continue
                if other not in depth:
                    depth[other] = low[other] = depth[part] + 1
                    passed.append(k)
                    stack.append((other, k, 0))
                elif depth[other] < depth[part]:
                    passed.append(k)
                    low[part] = min(low[part], depth[other])
                continue
            stack.pop()
            if not stack:
                continue
            above = stack[-1][0]
            low[above] = min(low[above], low[part])
            if low[part] >= depth[above]:
                while passed:
                    k = passed.pop()
                    block[k] = count
                    if k == came:
                        break
                count += 1
    for k, number in enumerate(block):
        if number < 0:
            block[k], count = count, count + 1
    return block
