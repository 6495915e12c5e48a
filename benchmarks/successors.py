"""Speed of the symbolic layer: successors per second, and the time to an optimal skeleton.

    python benchmarks/successors.py

One line per task: preparation (successor functions and estimate), first search, its size, then successors per second
with all rows built. Seconds are wall time on this machine, the front end left out.
"""

from __future__ import annotations

import random
import time
from pathlib import Path

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.search import SkeletonSearch

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
TASKS = (
    ("climb.tamp", {"n": "8", "crawlers": "1"}),
    ("climb.tamp", {"n": "8", "crawlers": "2"}),
    ("climb.tamp", {"n": "64", "crawlers": "2"}),
    ("climb.tamp", {"n": "256", "crawlers": "2"}),
    ("climb.tamp", {"n": "64", "crawlers": "3"}),
    ("climb.tamp", {"n": "64", "crawlers": "4"}),
    ("pick_and_place.tamp", {"objects": "8"}),
    ("pick_and_place.tamp", {"objects": "64"}),
)
STATES = 20000


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
    started = time.perf_counter()
    count = sum(len(successors.expand(state)) for state in visited)
    return count / (time.perf_counter() - started)


def measure(name: str, problem: Problem) -> None:
    started = time.perf_counter()
    successors = Successors(problem)
    search = SkeletonSearch(problem, successors, "astar", Budget(60))
    prepared = time.perf_counter()
    candidate = search.next()
    found = time.perf_counter()
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


if __name__ == "__main__":
    main()
