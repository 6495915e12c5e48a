"""`nodes` bounds the search trees: all windows and plans together."""

from __future__ import annotations

from pathlib import Path

import pytest

import tamplang

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
WIDEST = 100
"""No state of the task below has so many successors: the last expansion may go so far beyond the limit."""


@pytest.mark.parametrize("nodes", [1, 40, 300])
def test_the_tree_grows_no_larger(nodes: int) -> None:
    result = tamplang.load(EXAMPLES / "rendezvous.tamp", n=8).solve(bound="seq", search="bfs", nodes=nodes, time=100)
    assert result.status == "budget"
    assert nodes <= result.statistics.tree_nodes < nodes + WIDEST
    assert [d.code for d in result.explanation][:1] == ["S0003"]


def test_windows_share_the_nodes() -> None:
    task = tamplang.load(EXAMPLES / "climb.tamp", n=6, crawlers=1)
    free = task.solve(horizon=2, time=200)
    assert free.status == "solved"
    most = free.statistics.tree_nodes // 2
    bounded = task.solve(horizon=2, time=200, nodes=most)
    assert bounded.status == "budget"
    assert most <= bounded.statistics.tree_nodes < most + WIDEST


def test_further_plans_share_the_nodes() -> None:
    task = tamplang.load(EXAMPLES / "climb.tamp", n=4, crawlers=1)
    first = task.solve(bound="seq", time=100)
    both = task.solve(bound="seq", time=100, solutions=50, nodes=first.statistics.tree_nodes + 10)
    assert both.status == "solved" and [d.code for d in both.explanation] == ["S0003"]
    assert both.statistics.tree_nodes < first.statistics.tree_nodes + 10 + WIDEST
