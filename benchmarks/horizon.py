"""Receding horizon: the thesis' table 7 and beyond, time to the first motion, and growth from window to window.

    tamplang bench horizon [--seeds 5] [--rows TEXT] [--time S] [--out FILE.json] [--markdown FILE.md]

One process `tamplang solve --horizon` per row and seed, one after the other, on one core, with path bound, collisions
and verification of the whole run. With --out, runs are kept in FILE.json as they end and not run again. --rows takes
the rows whose name contains TEXT, such as "rendezvous" or "beyond".
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FACTOR, LONG, SHORT_GOAL = 20, 40.0, 2.0
"""A row must take at most a 20th of the thesis' time where that is above 40 s, else 2 s without process start."""

Run = dict[str, object]
Runs = dict[str, dict[str, Run]]
"""By row, then by seed."""


@dataclass(frozen=True, slots=True)
class Row:
    """Our task with its horizon, and what the thesis has there: seconds, expanded nodes, length; None where it found
    nothing or did not try."""

    table: str
    file: str
    parameters: tuple[tuple[str, int], ...]
    horizon: str
    thesis: tuple[float, int, int] | None

    @property
    def name(self) -> str:
        values = (f"{name}={value}" for name, value in self.parameters)
        return " ".join((self.file, *values, f"H={self.horizon}"))

    @property
    def goal(self) -> float | None:
        """Seconds of the whole process; None where only a short time without process start counts."""
        return self.thesis[0] / FACTOR if self.thesis is not None and self.thesis[0] > LONG else None


def _row(table: str, file: str, horizon: str, thesis: tuple[float, int, int] | None, **parameters: int) -> Row:
    return Row(table, file, tuple(parameters.items()), horizon, thesis)


TABLE, BEYOND, FIRST = "table 7", "beyond", "first motion"
ROWS = [
    _row(TABLE, "climb", "6", (273.61, 353, 33), n=32, crawlers=1),
    _row(TABLE, "climb", "8", (391.04, 283, 49), n=45, crawlers=1),
    _row(TABLE, "climb", "3", (362.40, 274, 13), n=32, crawlers=2),
    _row(TABLE, "climb", "4", None, n=64, crawlers=2),
    _row(TABLE, "rendezvous", "4", (72.62, 286, 14), n=8),
    _row(TABLE, "rendezvous", "8", (95.97, 154, 21), n=25),
    _row(TABLE, "mobile_manipulator", "4", (5.87, 53, 17), objects=8),
    _row(TABLE, "mobile_manipulator", "4", (20.62, 172, 33), objects=16),
    _row(BEYOND, "climb", "4", None, n=256, crawlers=2),
    _row(BEYOND, "mobile_manipulator", "4", None, objects=64),
    _row(BEYOND, "rendezvous", "8", None, n=64),
    _row(FIRST, "climb", "1", None, n=64, crawlers=2),
    _row(FIRST, "climb", "2", None, n=64, crawlers=2),
    _row(FIRST, "climb", "auto", None, n=64, crawlers=2),
    _row(FIRST, "climb", "2", None, n=64, crawlers=1),
    _row(FIRST, "rendezvous", "2", None, n=64),
]


def solve(row: Row, seed: int, limit: float, folder: str) -> Run:
    """One process: what it printed, its wall and CPU seconds, and its windows."""
    plan = Path(folder) / "plan.json"
    plan.unlink(missing_ok=True)
    command = [sys.executable, "-m", "tamplang", "solve", str(ROOT / "examples" / f"{row.file}.tamp"), "--json"]
    command += ["--seed", str(seed), "--time", str(limit), "--horizon", row.horizon, "--out", str(plan)]
    command += [f"-p{name}={value}" for name, value in row.parameters]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    started = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment, cwd=folder)
    assert process.stdout is not None
    output = process.stdout.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.monotonic() - started
    answer = json.loads(output) if output.startswith("{") else {"status": "error"}
    kept = ("status", "verified", "length", "tree_nodes", "expanded_nodes", "seconds", "bounds")
    measured = {"wall": round(wall, 3), "cpu": round(usage.ru_utime + usage.ru_stime, 3)}
    windows = [
        (window["reason"], window["motions"], len(window["actions"]), len(window["unmet"]), window["seconds"])
        for window in (json.loads(plan.read_text())["windows"] if plan.exists() else [])
    ]
    peak = {"peak_mb": round(usage.ru_maxrss / 1024)}
    return {**measured, **peak, **{key: answer.get(key) for key in kept}, "windows": windows}


def measure(rows: Sequence[Row], seeds: int, limit: float, out: Path | None) -> Runs:
    """All runs that are not yet in `out`, one after the other; the file is rewritten after each."""
    runs: Runs = json.loads(out.read_text())["runs"] if out is not None and out.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        for row in rows:
            for seed in range(seeds):
                if str(seed) in runs.get(row.name, {}):
                    continue
                run = solve(row, seed, limit, folder)
                runs.setdefault(row.name, {})[str(seed)] = run
                shown = f"{run['status']}, verified {run['verified']}, length {run['length']}"
                times = f"{run['wall']} s, {run['cpu']} s of CPU"
                print(f"{row.name} seed {seed}: {times}, {shown}", file=sys.stderr, flush=True)
                if out is not None:
                    temporary = out.with_suffix(".part")
                    temporary.write_text(json.dumps({"machine": machine(), "date": today(), "runs": runs}, indent=1))
                    temporary.replace(out)
    return runs


def machine() -> str:
    return f"{os.cpu_count()}-core {platform.machine()}, {platform.system()}, Python {platform.python_version()}"


def today() -> str:
    return datetime.date.today().isoformat()


def stage(run: Run, name: str) -> float:
    """Seconds of a stage of a run; process start and imports are left out of all of them."""
    seconds = run.get("seconds")
    return float(seconds.get(name, float("nan"))) if isinstance(seconds, dict) else float("nan")


def halves(runs: Sequence[Run]) -> tuple[float, float]:
    """Median seconds per window in the first and in the second half of the runs."""
    early: list[float] = []
    late: list[float] = []
    for run in runs:
        windows = run.get("windows")
        seconds = [float(window[4]) for window in windows] if isinstance(windows, list) else []
        middle = len(seconds) // 2
        early += seconds[:middle]
        late += seconds[middle:]
    return _median(early), _median(late)


def _median(values: Sequence[float]) -> float:
    return statistics.median(values) if values else float("nan")


def _number(value: float, digits: int = 2) -> str:
    """A dash where no run gave a figure."""
    return "–" if value != value else f"{value:.{digits}f}"


HEADINGS = (
    "task and horizon", "thesis s", "expanded", "length", "ours s", "worst s", "without start s", "CPU s", "expanded",
    "length", "windows", "first motion s", "s per window, early", "late", "MB", "verified", "thesis / ours", "goal s",
    "met",
)  # fmt: skip


def line(row: Row, runs: Sequence[Run]) -> str:
    good = [run for run in runs if run.get("status") == "solved" and run.get("verified")]

    def middle(key: str) -> float:
        return _median([float(str(run[key])) for run in good])

    wall, inside = middle("wall"), _median([stage(run, "total") for run in good])
    goal = f"{row.goal:.1f}" if row.goal is not None else f"{SHORT_GOAL:g} + start"
    met = "yes" if good and (wall <= row.goal if row.goal is not None else inside <= SHORT_GOAL) else "no"
    first = _median([stage(run, "first_motion") for run in good])
    if row.thesis is None:
        goal, met = "solved", "yes" if len(good) == len(runs) else "no"
    if row.table == FIRST:
        goal, met = "first in 1 s", "yes" if first <= 1.0 else "no"
    theirs = [f"{row.thesis[0]:g}", *map(str, row.thesis[1:])] if row.thesis is not None else ["–"] * 3
    worst = max((float(str(run["wall"])) for run in good), default=float("nan"))
    counts = [_median([len(run["windows"]) for run in good if isinstance(run["windows"], list)])]
    early, late = halves(good)
    ours = [_number(x) for x in (wall, worst, inside, middle("cpu"))]
    ours += [_number(x, 0) for x in (middle("expanded_nodes"), middle("length"), *counts)]
    ours += [_number(x) for x in (first, early, late)] + [_number(middle("peak_mb"), 0)]
    ratio = _number(row.thesis[0] / wall, 1) if row.thesis is not None and good else "–"
    return f"| {' | '.join((row.name, *theirs, *ours, f'{len(good)}/{len(runs)}', ratio, goal, met))} |"


def markdown(rows: Sequence[Row], runs: Runs, seeds: int) -> str:
    """One table for table 7, one for what goes beyond it, and one for the first motion."""
    text = [
        "# Receding horizon",
        "",
        "Made by `tamplang bench horizon --markdown docs/benchmarks-horizon.md`: one process `tamplang solve --horizon "
        "H` per row and seed, one after the other, on one core, with path bound, collisions and verification of the "
        "whole run.",
        "",
        f"{today()}, {machine()}, seeds 0 to {seeds - 1}. Times are medians over seeds, by the wall; the goal is a "
        f"{FACTOR}th of the thesis' time where that is above {LONG:g} s, else {SHORT_GOAL:g} s without process start. "
        "`first motion` is when the motion of the first window stands, process start left out. Seconds per window are "
        "medians over the windows in the first and in the second half of each run.",
    ]
    table = ""
    for row in rows:
        if row.table != table:
            table = row.table
            text += ["", f"**{table[0].upper()}{table[1:]}**", ""]
            text += [f"| {' | '.join(HEADINGS)} |", "|---" * len(HEADINGS) + "|"]
        found = [run for seed, run in runs.get(row.name, {}).items() if int(seed) < seeds]
        if found:
            text.append(line(row, found))
    return "\n".join(text) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(prog="tamplang bench horizon", description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=5, help="how many seeds per row, from 0")
    parser.add_argument("--rows", default="", help="only rows whose name contains this text")
    parser.add_argument("--time", type=float, default=180.0, help="seconds per run")
    parser.add_argument("--out", type=Path, help="JSON file that keeps the runs")
    parser.add_argument("--markdown", type=Path, help="write the table there instead of on standard output")
    options = parser.parse_args()
    rows = [row for row in ROWS if options.rows in f"{row.table}: {row.name}"]
    if not rows:
        names = "\n".join(f"{row.table}: {row.name}" for row in ROWS)
        parser.error(f"no row contains {options.rows!r}; the rows are:\n{names}")
    runs = measure(rows, options.seeds, options.time, options.out)
    text = markdown(rows, runs, options.seeds)
    if options.markdown is not None:
        options.markdown.write_text(text, encoding="utf-8")
    else:
        print(text, end="")


if __name__ == "__main__":
    main()
