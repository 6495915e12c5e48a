"""Which robot goes first, where one that arrives would block the way of another for good."""

from __future__ import annotations

import numpy as np

from tamplang.api import loads
from tamplang.compiler.ir import Action
from tamplang.runtime.planner.schedule.clearance import SegmentClearances
from tamplang.runtime.planner.schedule.dependencies import precedence
from tamplang.runtime.planner.schedule.list_schedule import scheduled, tails
from tamplang.runtime.planner.schedule.stage import configurations
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.skeleton import PhasePath, start_configuration

ROBOTS = """
import "benchmarks/together/movers.tamp"
task pass() {
    scene walled(side = 10 m)
    disc(range = 6 m) a: W on ground at (-1 m, 0)
    disc(range = 6 m) b: W on ground at (0, 3 m)
    spot back: box(1 cm, 1 cm, 1 cm) at (-3 m, 0, 5.1 cm)
    spot far: box(1 cm, 1 cm, 1 cm) at (1 m, 0, 5.1 cm)
    spot middle: box(1 cm, 1 cm, 1 cm) at (0, 0, 5.1 cm)
    fact (assigned a.M back)
    fact (assigned a.M far)
    fact (assigned b.M middle)
    goal (been back), (been far), (been middle)
}
"""
LEGS = ("a", "back", (-2.0, 0.0), 2.0), ("a", "far", (4.0, 0.0), 4.0), ("b", "middle", (0.0, -3.0), 5.0)
"""A goes back, then far, past the middle, to which B comes more slowly: mover, spot, way in metres, seconds."""


def test_one_that_would_block_the_only_way_lets_the_other_pass() -> None:
    problem = loads(ROBOTS).problem
    skeleton = build_skeleton(problem, [Action("visit", (f"{mover}.M", spot)) for mover, spot, _, _ in LEGS])
    now = {name: rows.copy() for name, rows in start_configuration(problem).modules.items()}
    paths = []
    for mover, _, way, seconds in LEGS:
        share = np.linspace(0.0, 1.0, round(seconds / 0.01) + 1)[:, None]
        share = share * share * (3.0 - 2.0 * share)
        rows = {name: np.repeat(row[None], len(share), axis=0) for name, row in now.items()}
        rows[mover][:, 7:9] += share * way
        paths.append(PhasePath(rows, {}, seconds))
        now = {name: row[-1].copy() for name, row in rows.items()}
    order = precedence(skeleton, paths, 0.01)
    clearances = SegmentClearances(skeleton, order, configurations(skeleton, paths), 0.02)
    priority = tails(order)
    assert priority[2] > priority[1]  # hence B is put before A's second motion, and is there before A comes
    found = scheduled(order, clearances, priority)
    assert found is not None
    starts = found.starts
    assert starts[0] == 0 and starts[1] == 200 and starts[2] is not None
    assert 0 < starts[2] < 400 and found.end < 900
