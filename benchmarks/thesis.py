"""The experiments of the thesis (tables 3 to 6) and beyond: our figures beside the thesis' own.

    tamplang bench thesis [--seeds 5] [--rows TEXT] [--time S] [--out FILE.json] [--markdown FILE.md]

One process `tamplang solve` per row and seed, one after the other, on one core, with path bound, collisions and
verification. With --out, runs are kept in FILE.json as they end and not run again. --rows takes the rows whose name
contains TEXT, such as "climb n=8" or "table 5".
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
FACTOR, ASPIRED = 20, 50
"""By how much we must beat, and want to beat, a figure of the thesis above `LONG` seconds."""
LONG = 40.0
SHORT_GOAL = 2.0
"""Seconds, process start left out, for the rows that took the thesis less."""
Figures = tuple[float, int, int, int]
"""Of the thesis: seconds, tree nodes, expanded nodes, length of the solution."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a table: our task with its parameters, and what the thesis has there; None for a dash."""

    table: str
    file: str
    parameters: tuple[tuple[str, int], ...]
    thesis: Figures | None

    @property
    def task(self) -> str:
        return " ".join((self.file, *(f"{name}={value}" for name, value in self.parameters)))

    @property
    def name(self) -> str:
        return f"{self.table}: {self.task}"

    @property
    def goal(self) -> float | None:
        """Seconds of the whole process; None where only a short time without process start counts."""
        long = self.thesis is not None and self.thesis[0] > LONG
        return self.thesis[0] / FACTOR if self.thesis is not None and long else None


def _rows(table: str, file: str, name: str, figures: dict[int, Figures | None], **fixed: int) -> list[Row]:
    return [Row(table, file, ((name, n), *fixed.items()), thesis) for n, thesis in figures.items()]


TWO_CRAWLERS: dict[int, Figures | None] = {
    1: (0.33, 21, 3, 2), 2: (3.83, 111, 17, 7), 4: (5.38, 190, 22, 8), 8: (7.25, 309, 23, 9),
    16: (35.76, 685, 29, 12), 32: (309.43, 2488, 53, 20), 64: (470.58, 4088, 53, 27),
}  # fmt: skip
WITHOUT_HEURISTICS: dict[int, Figures | None] = {
    1: (2.31, 65, 8, 2), 2: (7.98, 211, 22, 2), 4: (350.16, 2746, 591, 5), 8: None, 16: None, 32: None, 64: None,
}  # fmt: skip
ONE_CRAWLER: dict[int, Figures | None] = {
    1: (0.09, 10, 2, 2), 2: (0.85, 57, 13, 5), 4: (0.99, 85, 13, 7), 8: (11.39, 181, 17, 10),
    16: (26.29, 505, 27, 16), 32: (423.16, 4421, 129, 43), 64: None,
}  # fmt: skip
RENDEZVOUS: dict[int, Figures | None] = {
    1: (23.13, 883, 117, 13), 2: (31.18, 1293, 157, 13), 4: (19.35, 671, 67, 11), 8: (28.35, 1157, 77, 12),
}  # fmt: skip
MOBILE: dict[int, Figures | None] = {
    1: (0.97, 7, 2, 3), 2: (2.67, 12, 4, 4), 4: (6.46, 25, 8, 9), 8: (45.61, 68, 19, 17),
}  # fmt: skip
ROWS = [
    *_rows("table 3, with heuristics, and table 4, two crawlers", "climb", "n", TWO_CRAWLERS, crawlers=2),
    *_rows("table 3, without heuristics", "climb", "n", WITHOUT_HEURISTICS, crawlers=2),
    *_rows("table 4, one crawler", "climb", "n", ONE_CRAWLER, crawlers=1),
    *_rows("table 5", "rendezvous", "n", RENDEZVOUS),
    *_rows("table 6", "mobile_manipulator", "objects", MOBILE),
    *_rows("beyond", "climb", "n", {128: None, 256: None}, crawlers=2),
    *_rows("beyond", "mobile_manipulator", "objects", {32: None, 64: None}),
    *_rows("beyond", "chain_climb", "modules", {8: None}),
]
BEYOND = "beyond"

Run = dict[str, object]
Runs = dict[str, dict[str, Run]]
"""By task, then by seed."""


def solve(row: Row, seed: int, limit: float, folder: str) -> Run:
    """One process: what it printed, and its wall and CPU seconds."""
    plan = Path(folder) / "plan.json"
    command = [sys.executable, "-m", "tamplang", "solve", str(ROOT / "examples" / f"{row.file}.tamp"), "--json"]
    command += ["--seed", str(seed), "--time", str(limit), "--bound", "path", "--out", str(plan)]
    command += [f"-p{name}={value}" for name, value in row.parameters]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    started = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment)
    assert process.stdout is not None
    output = process.stdout.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.monotonic() - started
    answer = json.loads(output) if output.startswith("{") else {"status": "error"}
    kept = ("status", "verified", "length", "tree_nodes", "expanded_nodes", "optimal", "seconds", "bounds", "worst")
    measured = {"wall": round(wall, 3), "cpu": round(usage.ru_utime + usage.ru_stime, 3)}
    return {**measured, "peak_mb": round(usage.ru_maxrss / 1024), **{key: answer.get(key) for key in kept}}


def measure(rows: Sequence[Row], seeds: int, limit: float, out: Path | None) -> Runs:
    """All runs that are not yet in `out`, one after the other; the file is rewritten after each."""
    runs: Runs = json.loads(out.read_text())["runs"] if out is not None and out.exists() else {}
    tasks = {row.task: row for row in rows}
    with tempfile.TemporaryDirectory() as folder:
        for task, row in tasks.items():
            for seed in range(seeds):
                if str(seed) in runs.get(task, {}):
                    continue
                run = solve(row, seed, limit, folder)
                runs.setdefault(task, {})[str(seed)] = run
                shown = f"{run['status']}, verified {run['verified']}, length {run['length']}"
                times = f"{run['wall']} s, {run['cpu']} s of CPU"
                print(f"{task} seed {seed}: {times}, {shown}", file=sys.stderr, flush=True)
                if out is not None:
                    temporary = out.with_suffix(".part")
                    temporary.write_text(json.dumps({"machine": machine(), "date": today(), "runs": runs}, indent=1))
                    temporary.replace(out)
    return runs


def machine() -> str:
    return f"{os.cpu_count()}-core {platform.machine()}, {platform.system()}, Python {platform.python_version()}"


def today() -> str:
    return datetime.date.today().isoformat()


def median(runs: Sequence[Run], key: str) -> float:
    """Of the runs that ended with a verified plan."""
    found = [value for run in runs if isinstance(value := run.get(key), int | float)]
    return statistics.median(found) if found else float("nan")


def total(run: Run) -> float:
    """Seconds of a run from the start of the compiler to the verdict: process start and imports left out."""
    seconds = run.get("seconds")
    return float(seconds.get("total", 0.0)) if isinstance(seconds, dict) else float("inf")


def line(row: Row, runs: Sequence[Run]) -> str:
    good = [run for run in runs if run.get("status") == "solved" and run.get("verified")]
    wall = median(good, "wall")
    inside = statistics.median([total(run) for run in good]) if good else float("nan")
    goal, met = "–", "–"
    if row.table != BEYOND:
        goal = f"{row.goal:.1f}" if row.goal is not None else f"{SHORT_GOAL:g} + start"
        reached = wall <= row.goal if row.goal is not None else inside <= SHORT_GOAL
        met = "yes" if good and reached else "no"
        if row.thesis is None:
            goal, met = "solved", "yes" if len(good) == len(runs) else "no"
    ratio = f"{row.thesis[0] / wall:.1f}" if row.thesis is not None and good else "–"
    theirs = [f"{row.thesis[0]:g}", *map(str, row.thesis[1:])] if row.thesis is not None else ["–"] * 4
    worst = max((float(str(run["wall"])) for run in good), default=float("nan"))
    counts = (median(good, name) for name in ("tree_nodes", "expanded_nodes", "length"))
    seconds = (wall, worst, inside, median(good, "cpu"))
    ours = [_number(x, 2) for x in seconds] + [_number(x, 0) for x in counts] + [f"{len(good)}/{len(runs)}"]
    return f"| {' | '.join((row.task, *theirs, *ours, ratio, goal, met))} |"


def _number(value: float, digits: int) -> str:
    """A dash where no run gave a figure."""
    return "–" if value != value else f"{value:.{digits}f}"


HEADINGS = (
    "task", "thesis s", "tree", "expanded", "length", "ours s", "worst s", "without start s", "CPU s", "tree",
    "expanded", "length", "verified", "thesis / ours", "goal s", "met",
)  # fmt: skip


def markdown(rows: Sequence[Row], runs: Runs, seeds: int) -> str:
    """One table per table of the thesis."""
    chosen = {task: [run for seed, run in found.items() if int(seed) < seeds] for task, found in runs.items()}
    peak = max((int(str(run["peak_mb"])) for found in chosen.values() for run in found), default=0)
    text = [
        "# The experiments of the thesis, and beyond",
        "",
        "Made by `tamplang bench thesis --markdown docs/benchmarks-thesis.md`: one process per row and seed, one after "
        "the other, on one core, with path bound, collisions and verification.",
        "",
        f"{today()}, {machine()}, seeds 0 to {seeds - 1}; at most {peak} MB. Times are medians over seeds; the goal "
        f"is a {FACTOR}th of the thesis' time (a {ASPIRED}th is aspired to) where that is above {LONG:g} s, else "
        f"{SHORT_GOAL:g} s without process start. Rows without heuristics use the default search."
    ]
    table = ""
    for row in rows:
        if row.table != table:
            table = row.table
            text += ["", f"**{table[0].upper()}{table[1:]}**", ""]
            text += [f"| {' | '.join(HEADINGS)} |", "|---" * len(HEADINGS) + "|"]
        if row.task in chosen:
            text.append(line(row, chosen[row.task]))
    return "\n".join(text) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(prog="tamplang bench thesis", description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=5, help="how many seeds per row, from 0")
    parser.add_argument("--rows", default="", help="only rows whose name contains this text")
    parser.add_argument("--time", type=float, default=120.0, help="seconds per run")
    parser.add_argument("--out", type=Path, help="JSON file that keeps the runs")
    parser.add_argument("--markdown", type=Path, help="write the table there instead of on standard output")
    options = parser.parse_args()
    rows = [row for row in ROWS if options.rows in row.name]
    if not rows:
        parser.error(f"no row contains {options.rows!r}; the rows are:\n" + "\n".join(row.name for row in ROWS))
    runs = measure(rows, options.seeds, options.time, options.out)
    text = markdown(rows, runs, options.seeds)
    if options.markdown is not None:
        options.markdown.write_text(text, encoding="utf-8")
    else:
        print(text, end="")


if __name__ == "__main__":
    main()
