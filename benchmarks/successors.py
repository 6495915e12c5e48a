"""Speed of the symbolic layer: successors per second, and the time to an optimal skeleton.

    python benchmarks/successors.py

One line per task: preparation (successor functions and estimate), first search, its size, then successors per second
with all rows built. CPU seconds, the front end left out.
"""

from __future__ import annotations

import gc
import random
import time
from pathlib import Path

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import SkeletonSearch

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
TASKS = (
    ("climb.tamp", {"n": "8", "crawlers": "1"}),
    ("climb.tamp", {"n": "8", "crawlers": "2"}),
    ("climb.tamp", {"n": "64", "crawlers": "2"}),
    ("climb.tamp", {"n": "256", "crawlers": "2"}),
    ("climb.tamp", {"n": "64", "crawlers": "3"}),
    ("climb.tamp", {"n": "64", "crawlers": "4"}),
    ("pick_and_place.tamp", {"objects": "8"}),
)
STATES = 20000
MANY = """
import std.crawler
import std.rules

task many(objects: int = 64) {
    base pedestal: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    object table: box(0.8 m, 1.6 m, 0.04 m) at (0.65 m, 0, 0.02 m)
    object goal_tray: box(0.5 m, 0.3 m, 0.04 m) at (0, -0.6 m, 0.02 m)
    fact (tray goal_tray)
    for i in 1 .. objects {
        object item[i]: box(0.02 m, 0.02 m, 0.02 m) on table at (0, 0.022 m * (i - (objects + 1) / 2))
        fact (grippable item[i])
    }
    crawler c: A on pedestal
    goal  forall i in 1 .. objects { (on goal_tray item[i]) }
}
"""


def states(successors: Successors) -> list[int]:
    """States met on random walks, the same on every run."""
    chance = random.Random(0)
    found = []
    state = successors.initial
    while len(found) < STATES:
        found.append(state)
        following = successors.expand(state)
        state = chance.choice(following)[0] if following and len(found) % 100 else successors.initial
    return found


def rate(successors: Successors) -> float:
    """Successors per second over states whose rows are built."""
    visited = states(successors)
    started = time.process_time()
    count = sum(len(successors.expand(state)) for state in visited)
    return count / (time.process_time() - started)


def measure(name: str, problem: Problem) -> None:
    gc.collect()
    gc.freeze()
    started = time.process_time()
    successors = Successors(problem)
    search = SkeletonSearch(problem, successors, "astar", Budget(60))
    prepared = time.process_time()
    candidate = search.next()
    found = time.process_time()
    length = "none" if candidate is None else f"{len(candidate.actions)}{'' if candidate.optimal else '?'}"
    print(
        f"{name:34} {(prepared - started) * 1e3:8.1f} {(found - prepared) * 1e3:8.1f} {length:>7} "
        f"{search.expanded_nodes:9} {search.tree_nodes:8} {rate(successors) / 1e6:8.2f}",
        flush=True,
    )


def main() -> None:
    print(f"{'task':34} {'prep ms':>8} {'search':>8} {'length':>7} {'expanded':>9} {'nodes':>8} {'M succ/s':>8}")
    for file, parameters in TASKS:
        problem, _ = compile_problem(EXAMPLES / file, None, parameters)
        measure(f"{file} {' '.join(f'{k}={v}' for k, v in parameters.items())}", problem)
    problem, _ = compile_text(MANY)
    measure("pick and place, 64 objects", problem)


if __name__ == "__main__":
    main()
