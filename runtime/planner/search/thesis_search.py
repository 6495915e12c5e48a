"""The thesis' own search (algorithm 1), to replay its tables: best-first by the cost-to-go of the task's guide alone.

No state is ever recognised again, no cost of actions counts, and a child with a high cost-to-go stays in the tree, so
that the size of the tree is the root and all children of the nodes that were expanded.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, field

from ....compiler.ir import Action, Problem
from ....compiler.symbolic.costs import CostToGo
from ....compiler.symbolic.successors import Successors


@dataclass(frozen=True, slots=True)
class _Node:
    state: int
    parent: int
    action: int | None


@dataclass(slots=True)
class PlainSearch:
    """`tree_nodes` counts all nodes with the root, `expanded_nodes` those expanded after the root, as the thesis does.
    `most_nodes` bounds the tree."""

    problem: Problem
    successors: Successors
    most_nodes: int
    expanded_nodes: int = -1
    nodes: list[_Node] = field(default_factory=list)

    @property
    def tree_nodes(self) -> int:
        return len(self.nodes)

    def goals(self) -> Iterator[tuple[Action, ...]]:
        """The plans in the order in which their last node leaves the queue; ends when the tree is full."""
        guide, successors = CostToGo(self.problem, self.successors), self.successors
        self.nodes.append(_Node(successors.initial, -1, None))
        queue = [(guide.start, 0)]
        while queue and len(self.nodes) < self.most_nodes:
            value, index = heapq.heappop(queue)
            node = self.nodes[index]
            if successors.is_goal(node.state):
                yield self._plan(index)
                continue
            self.expanded_nodes += 1
            for following, action in successors.expand(node.state):
                change = guide.change(node.state, action, node.action)
                heapq.heappush(queue, (value + change, len(self.nodes)))
                self.nodes.append(_Node(following, index, action))

    def _plan(self, index: int) -> tuple[Action, ...]:
        actions = []
        while (action := self.nodes[index].action) is not None:
            actions.append(self.successors.action(action))
            index = self.nodes[index].parent
        return tuple(reversed(actions))
