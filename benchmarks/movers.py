"""Several movers in the plane: seconds to the first plan, and what plans are worth after a while.

    python benchmarks/movers.py [--seconds N] [--only NAME]

The tasks of `benchmarks/together` are those of a benchmark of others (multirobot-pathplanning-benchmark of ETH Zürich),
written anew; cost is theirs: the length of the way in configuration space, at every instant of the robot that goes
farthest. Seconds are of CPU, from reading the text on.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from tamplang.api import Plan, load

FOLDER = Path(__file__).resolve().parent / "together"
TASKS = (
    ("unordered", "unordered"), ("unordered", "square"), ("unordered", "circle"), ("unassigned", "tsp"),
    ("piano", "piano"), ("piano", "anyone"), ("hallway", "hallway"), ("random", "random"), ("handover", "handover"),
)  # fmt: skip


def cost(plan: Plan) -> float:
    """The length of the way of all robots, at every instant of the one that goes farthest."""
    rows = [np.asarray(track.joints, dtype=float) for track in plan.record.tracks]
    steps = np.array([np.linalg.norm(np.diff(r, axis=0), axis=1) for r in rows])
    return float(steps.max(axis=0).sum())


def row(file: str, task: str, seconds: float) -> str:
    """The line of one task."""
    began = time.process_time()
    met: list[tuple[float, float]] = []
    result = load(FOLDER / f"{file}.tamp", task).solve(
        time=20.0 * seconds, minimise="makespan",
        found=lambda plan: met.append((time.process_time() - began, cost(plan))),
    )  # fmt: skip
    spent = time.process_time() - began
    if not met:
        return f"| {task} | – | – | – | {spent:.1f} | {result.status} |"
    best = min(c for t, c in met if t <= max(seconds, met[0][0]))
    return (
        f"| {task} | {met[0][0]:.2f} | {met[0][1]:.2f} | {best:.2f} | {min(c for _, c in met):.2f} | {spent:.1f} "
        f"| {result.status} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    print(f"| task | first, s | its cost | after {arguments.seconds:g} s | at the end | after, s | status |")
    print("|---|---|---|---|---|---|---|", flush=True)
    for file, task in TASKS:
        if arguments.only in task:
            print(row(file, task, arguments.seconds), flush=True)


if __name__ == "__main__":
    main()
