"""Time: seconds of motion with one action after the other, and with robots that work at once.

    python benchmarks/time.py [--baseline PYTHON] [--seeds N] [--only NAME]

Every task is solved by `tamplang solve` as the `baseline` does (the Python of another build; this one without an
objective, unless it is given), and by this build with `--minimise makespan`, in turn. Profiles are judged by toppra,
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
    output = subprocess.run(command, capture_output=True, text=True, env=environment, check=False).stdout
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


def row(
    task: tuple[str, Sequence[str], float], baseline: str | None, seeds: int, folder: Path
) -> tuple[str, list[float]]:
    """The line of a task, and its phases' seconds over those of toppra."""
    example, parameters, wanted = task
    pairs, ratios, gaps, judged = [], [], [], []
    verified = 0
    for seed in range(seeds):
        own = folder / "own.plan.json"
        before = solved(baseline or sys.executable, example, parameters, seed, folder / "before.plan.json")
        after = solved(sys.executable, example, parameters, seed, own, "--minimise", "makespan")
        verified += before["verified"] and after["verified"]
        if not (before["verified"] and after["verified"]):
            continue
        pairs.append((before["motion"], after["motion"]))
        ratios.append(after["cpu"] / before["cpu"])
        bound = after["objective"]["bounds"]["these actions"]
        gaps.append(100.0 * (after["motion"] - bound) / after["motion"])
        with contextlib.suppress(ImportError):
            judged += profiles(own)
    name = f"{example} {' '.join(parameters)}".strip()
    if not pairs:
        return f"| {name} | {wanted:g} | – | – | – | – | – | 0 of {seeds} |", judged
    old, new = (statistics.median(p[i] for p in pairs) for i in (0, 1))
    gain = statistics.median(a / b for a, b in pairs)
    return (
        f"| {name} | {wanted:g} | {old:.2f} | {new:.2f} | {gain:.2f} | {statistics.median(gaps):.1f} % "
        f"| {statistics.median(ratios):.2f} | {verified} of {seeds} |"
    ), judged


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--baseline", help="the Python of the build to compare with")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="tasks whose name and parameters hold this text")
    arguments = parser.parse_args()
    print(f"{datetime.date.today()}, {platform.machine()}, {os.cpu_count()} cores, {arguments.seeds} seeds\n")
    print("| task | at least | motion before, s | now, s | times shorter | above its own bound | CPU | verified |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    judged: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        for task in TASKS:
            if arguments.only in f"{task[0]} {' '.join(task[1])}":
                line, more = row(task, arguments.baseline, arguments.seeds, Path(folder))
                judged += more
                print(line, flush=True)
    if judged:
        print(f"\nSeconds of {len(judged)} phases over those of toppra: median {statistics.median(judged):.3f}, "
              f"most {max(judged):.3f}")  # fmt: skip


if __name__ == "__main__":
    main()
