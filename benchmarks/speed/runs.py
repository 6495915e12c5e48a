"""Runs of rows by two builds, alternating, kept in a file as they end."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from benchmarks.speed.rows import Row

Run = dict[str, float]
"""`cpu` in seconds, `memory` in MB, `file` in bytes of the plan, `ended` 1 where the command said 0."""
Runs = dict[str, dict[str, list[Run]]]
"""By row, then by build, one for each seed."""
LONGEST = 900.0
"""Seconds after which a command is ended, whatever its own limit."""


def measured(
    rows: Sequence[Row], builds: Mapping[str, Path], seeds: Iterable[int], folder: Path, out: Path | None
) -> Runs:
    """All runs of the rows; those that are in `out` stay as they are. A build is warmed once, so that its byte code and
    its grammar are cached."""
    runs: Runs = json.loads(out.read_text()) if out is not None and out.exists() else {}
    warm = Row("warm", rows[0].arguments, first=("-m", "tamplang", "--version"))
    for name, python in builds.items():
        for row in (warm, *rows[:1]):
            _run(row, name, python, 0, folder)
    for seed in seeds:
        for row in rows:
            for name, python in builds.items():
                found = runs.setdefault(row.name, {}).setdefault(name, [])
                if any(run["seed"] == seed for run in found):
                    continue
                run = _run(row, name, python, seed, folder)
                found.append(run)
                told = f"{row.name}, {name}, seed {seed}: {run['cpu']:.2f} CPU s, {run['memory']:.0f} MB"
                print(told + ("" if run["ended"] else ", failed"), file=sys.stderr, flush=True)
                if out is not None:
                    part = out.with_suffix(".part")
                    part.write_text(json.dumps(runs, indent=1))
                    part.replace(out)
    return runs


def _run(row: Row, build: str, python: Path, seed: int, folder: Path) -> Run:
    plan = folder / f"{build}.json"
    put_in = {"{plan}": str(plan), "{folder}": str(folder), "{seed}": str(seed)}
    plan.unlink(missing_ok=True)
    if row.first:
        _process(python, [put_in.get(a, a) for a in row.first], folder)
    run = _process(python, [put_in.get(a, a) for a in row.arguments], folder)
    size = float(plan.stat().st_size) if plan.exists() else 0.0
    if row.inner:
        run["cpu"] = run["told"]
    return {"seed": float(seed), "file": size, **run}


def _process(python: Path, arguments: Sequence[str], folder: Path) -> Run:
    """One process and what it took: CPU seconds with its children's, peak memory in MB, the last number it printed."""
    one = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **one, "PYTHONPYCACHEPREFIX": str(folder / "bytecode")}
    for name in ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH"):
        environment.pop(name, None)
    with (folder / "printed").open("w+b") as printed:
        process = subprocess.Popen(
            ["timeout", str(LONGEST), str(python), *arguments],
            stdout=printed, stderr=subprocess.DEVNULL, env=environment, cwd=folder,
        )  # fmt: skip
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        printed.seek(0)
        last = printed.read().split()[-1:]
    told = float(last[0]) if last and last[0].replace(b".", b"", 1).isdigit() else float("nan")
    return {
        "cpu": round(usage.ru_utime + usage.ru_stime, 4),
        "memory": round(usage.ru_maxrss / 1024, 1),
        "ended": float(process.returncode == 0),
        "told": told,
    }
