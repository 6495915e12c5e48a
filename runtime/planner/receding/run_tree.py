"""The tree of a run for drawing: what was executed stays in it, and every window's search hangs below (thesis, figure
5)."""

from __future__ import annotations

from collections.abc import Sequence

from ...plan import SearchNode
from ..search.settings import SEARCH
from .window import Window


def grown(windows: Sequence[Window]) -> list[SearchNode]:
    """The nodes of all windows that stand: each search begins at the last action done before it. Every window has
    the same share of the nodes that are kept."""
    share = max(1, SEARCH.recorded_nodes // max(1, len(windows)))
    nodes = [SearchNode(0, -1, "", 0.0, "executed")]
    root = 0
    for window in windows:
        numbers = {-1: -1}
        for node in window.tree[:share]:
            if node.parent not in numbers:
                continue
            if node.parent == -1:
                numbers[node.id] = root
                continue
            numbers[node.id] = len(nodes)
            nodes.append(SearchNode(len(nodes), numbers[node.parent], node.action, node.estimate, node.status))
        for phase in window.skeleton.phases:
            root = _step(nodes, root, str(phase.action))
    return nodes


def _step(nodes: list[SearchNode], above: int, action: str) -> int:
    """The node of an executed action below another one: the one that a search has met, or a new one."""
    for node in nodes[above + 1 :]:
        if node.parent == above and node.action == action:
            nodes[node.id] = SearchNode(node.id, above, action, node.estimate, "executed")
            return node.id
    nodes.append(SearchNode(len(nodes), above, action, nodes[above].estimate, "executed"))
    return len(nodes) - 1
