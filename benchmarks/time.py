"""Time: seconds of motion with one action after the other, and with robots that work at once.

    python benchmarks/time.py [--baseline PYTHON] [--seeds N] [--only NAME]

Every task is solved by `tamplang solve` as the `baseline` does (the Python of another build), by this build without an
objective, and with `--minimise makespan`, in turn: how many times shorter motions are than the baseline's (or this
build's without an objective, where none is given), and user seconds over those of both. Profiles are judged by toppra,
where it is installed: seconds of each phase that a module moves alone over those of the fastest law through the same
curve, with the same limits.
"""

from __future__ import annotations

import argparse
import contextlib
import datetime
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
TASKS: Sequence[tuple[str, Sequence[str], float]] = (
    ("quadruped", (), 2.8),
    ("quadruped", ("steps=2",), 2.0),
    ("chain_climb", ("modules=4",), 1.6),
    ("chain_climb", ("modules=8",), 2.3),
    ("rendezvous", ("n=8",), 1.25),
    ("mobile_manipulator", ("objects=2",), 1.45),
    ("mobile_manipulator", ("objects=16",), 1.45),
    ("shared_table", ("arms=2", "things=4"), 1.6),
    ("shared_table", ("arms=4", "things=4"), 3.0),
    ("climb", (), 1.10),
    ("pick_and_place", (), 1.10),
)
"""Example, parameters, and how many times shorter its motion is to be."""


def solved(python: str, example: str, parameters: Sequence[str], seed: int, plan: Path, *more: str) -> dict[str, Any]:
    """What came of one process: seconds of motion, CPU seconds, verified or not, and what was told."""
    command = [python, "-m", "tamplang", "solve", str(ROOT / "examples" / f"{example}.tamp"), "--json"]
    command += ["--seed", str(seed), "--time", "600", "--out", str(plan), *more]
    command += [part for p in parameters for part in ("-p", p)]
    plan.unlink(missing_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    output = subprocess.run(  # elsewhere, or `-m` would find the package that lies here
        command, capture_output=True, text=True, env=environment, check=False, cwd=plan.parent
    ).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    told = json.loads(output) if output else {}
    motion = json.loads(plan.read_text(encoding="utf-8"))["times"][-1] if plan.exists() else None
    return {"cpu": after.ru_utime - before.ru_utime, "motion": motion, "verified": bool(told.get("verified")), **told}


def profiles(plan: Path) -> list[float]:
    """Seconds over those of toppra, of every spline of a plan that moves through no switch."""
    import toppra
    import toppra.algorithm
    import toppra.constraint
    from scipy.interpolate import CubicSpline

    toppra.setup_logging("ERROR")
    record = json.loads(plan.read_text(encoding="utf-8"))
    joints = {m["name"]: m["joints"] for m in record["modules"]}
    found = []
    alone = [s for s in record["splines"] if sum(s["knots"][0] < o["knots"][-1] and o["knots"][0] < s["knots"][-1]
                                                 for o in record["splines"]) == 1]  # fmt: skip
    for spline in alone:
        values = np.asarray(spline["values"])
        moved = np.ptp(values, axis=0) > 1e-9
        limits = [j for j, moves in zip(joints[spline["module"]], moved, strict=True) if moves]
        speed, change = (np.array([j.get(k, 1e6) for j in limits]) for k in ("speed", "acceleration"))
        curve = CubicSpline(np.linspace(0, 1, len(values)), values[:, moved], bc_type="clamped")
        dense = curve(np.linspace(0, 1, 4001))
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
        even = np.linspace(0.0, length[-1], 101)
        points = np.stack([np.interp(even, length, column) for column in dense.T], axis=1)
        grid = 0.5 * (1.0 - np.cos(np.pi * np.linspace(0.0, 1.0, 401)))
        rules = toppra.constraint
        kept = [
            rules.JointVelocityConstraint(np.column_stack([-speed, speed])),
            rules.JointAccelerationConstraint(
                np.column_stack([-change, change]), discretization_scheme=rules.DiscretizationType.Interpolation
            ),
        ]
        path = toppra.SplineInterpolator(even / length[-1], points)
        _, rates, _ = toppra.algorithm.TOPPRA(kept, path, gridpoints=grid).compute_parameterization(0, 0)
        if rates is not None:
            least = float((2.0 * np.diff(grid) / (rates[1:] + rates[:-1])).sum())
            found.append((spline["knots"][-1] - spline["knots"][0]) / least)
    return found


@dataclass
class Row:
    """What came of a task, by seed that all builds solved."""

    gains: list[float] = field(default_factory=list)
    gaps: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    plain: list[float] = field(default_factory=list)
    motions: list[float] = field(default_factory=list)
    profiles: list[float] = field(default_factory=list)


def measured(example: str, parameters: Sequence[str], baseline: str | None, seeds: int, folder: Path) -> Row:
    """A task by seeds. Without a baseline, plans of this build without an objective are what is compared with."""
    found = Row()
    for seed in range(seeds):
        own = folder / "own.plan.json"
        plain = solved(sys.executable, example, parameters, seed, folder / "plain.plan.json")
        before = solved(baseline, example, parameters, seed, folder / "before.plan.json") if baseline else plain
        after = solved(sys.executable, example, parameters, seed, own, "--minimise", "makespan")
        if not (before["verified"] and plain["verified"] and after["verified"]):
            continue
        found.motions.append(after["motion"])
        found.gains.append(before["motion"] / after["motion"])
        found.ratios.append(after["cpu"] / before["cpu"])
        found.plain.append(after["cpu"] / plain["cpu"])
        bound = after["objective"]["bounds"]["these actions"]
        found.gaps.append(100.0 * (after["motion"] - bound) / after["motion"])
        with contextlib.suppress(ImportError):
            found.profiles += profiles(own)
    return found


def line(task: tuple[str, Sequence[str], float], found: Row, seeds: int) -> str:
    """The line of a task in the table."""
    name = ", ".join([task[0], *task[1]])
    if not found.gains:
        return f"| {name} | {task[2]:g} | – | – | – | – | – | – | 0 of {seeds} |"
    middle = statistics.median
    by_seed, motions = (" ".join(f"{x:.2f}" for x in row) for row in (found.gains, found.motions))
    return (
        f"| {name} | {task[2]:g} | {middle(found.gains):.2f} | {by_seed} | {motions} | {middle(found.gaps):.1f} % "
        f"| {middle(found.ratios):.2f} | {middle(found.plain):.2f} | {len(found.gains)} of {seeds} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--baseline", help="the Python of the build to compare with")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="tasks whose name and parameters begin with this text")
    arguments = parser.parse_args()
    print(f"{datetime.date.today()}, {platform.machine()}, {os.cpu_count()} cores, {arguments.seeds} seeds\n")
    print("| task | at least | median | by seed | seconds | above its own bound | CPU / baseline | CPU / without "
          "| verified |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    judged: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        for task in TASKS:
            if ", ".join([task[0], *task[1]]).startswith(arguments.only):
                found = measured(task[0], task[1], arguments.baseline, arguments.seeds, Path(folder))
                judged += found.profiles
                print(line(task, found, arguments.seeds), flush=True)
    if judged:
        print(f"\nSeconds of {len(judged)} phases over those of toppra: median {statistics.median(judged):.3f}, "
              f"most {max(judged):.3f}")  # fmt: skip


if __name__ == "__main__":
    main()
