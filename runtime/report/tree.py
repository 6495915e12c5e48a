"""The search tree as a flat list in drawing order, with the reasons why branches ended."""

from __future__ import annotations

from collections import Counter
from dataclasses import field

from ...langs.frozen import dataclass
from ..plan import Plan, RefusalRecord, SearchNode

MOST_NODES = 2000


@dataclass(slots=True)
class Branch:
    """A node to draw: its depth, whether the plan runs through it, what hangs below, its refusals; and in which
    search it was met, for after a refusal the search starts again."""

    node: SearchNode
    depth: int
    chosen: bool
    round: int
    below: int = 0
    children: int = 0
    reasons: list[RefusalRecord] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Tree:
    branches: list[Branch]
    rounds: int
    left_out: int
    counts: list[tuple[str, int]]


def children_of(nodes: list[SearchNode]) -> tuple[list[int], dict[int, list[int]]]:
    """Positions of the roots, and of the children of every position, in the order given."""
    place = {node.id: i for i, node in reversed(list(enumerate(nodes)))}
    roots: list[int] = []
    children: dict[int, list[int]] = {}
    for i, node in enumerate(nodes):
        parent = place.get(node.parent)
        if parent is None or parent == i or node.parent == node.id:
            roots.append(i)
        else:
            children.setdefault(parent, []).append(i)
    return roots, children


def walk(nodes: list[SearchNode], actions: list[str]) -> list[tuple[Branch, tuple[str, ...]]]:
    """Branches in depth-first order, each with the actions that lead to it; nodes in a cycle are left out."""
    roots, children = children_of(nodes)
    result: list[tuple[Branch, tuple[str, ...]]] = []
    stack: list[tuple[int, int, tuple[str, ...], bool]] = [(r, 0, (), True) for r in reversed(roots)]
    started = 0
    while stack:
        at, depth, before, on_plan = stack.pop()
        node = nodes[at]
        path = (*before, node.action) if node.action else before
        chosen = on_plan and list(path) == actions[: len(path)]
        started += depth == 0
        branch = Branch(node, depth, chosen, started, children=len(children.get(at, ())))
        result.append((branch, path))
        stack += [(c, depth + 1, path, chosen) for c in reversed(children.get(at, []))]
    return result


def build_tree(plan: Plan) -> Tree:
    """The plan's search tree, at most `MOST_NODES` of it."""
    statistics = plan.statistics
    found = walk(statistics.tree, [p.action for p in plan.phases])
    refused: dict[str, list[RefusalRecord]] = {}
    for refusal in statistics.refusals:
        refused.setdefault(refusal.actions[-1] if refusal.actions else "", []).append(refusal)
    open_branches: list[Branch] = []
    for branch, path in found:
        candidates = refused.get(path[-1], []) if path else []
        own = [r for r in candidates if tuple(r.actions) == path[-len(r.actions) :]]
        branch.reasons = list({(r.bound, r.reason): r for r in own}.values())
        del open_branches[branch.depth :]
        for above in open_branches:
            above.below += 1
        open_branches.append(branch)
    counts = Counter(b.node.status for b, _ in found)
    kept = [b for b, _ in found[:MOST_NODES]]
    rounds = found[-1][0].round if found else 0
    return Tree(kept, rounds, len(found) - len(kept), sorted(counts.items(), key=lambda c: (-c[1], c[0])))
