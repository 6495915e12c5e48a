"""Receding horizon: the thesis' table 7 and beyond, time to the first motion, and growth from window to window.

    tamplang bench horizon [--seeds 5] [--rows TEXT] [--time S] [--out FILE.json] [--markdown FILE.md]

One process `tamplang solve --horizon` per row and seed, one after the other, on one core, with path bound, collisions
and verification of the whole run. With --out, runs are kept in FILE.json as they end and not run again. --rows takes
the rows whose name contains TEXT, such as "rendezvous" or "beyond".
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import _runs as bench


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
        return bench.goal_of(None if self.thesis is None else self.thesis[0])


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


def run_of(row: Row, limit: float, seed: int, folder: Path) -> bench.Run:
    """One run, and its windows."""
    plan = folder / "plan.json"
    run = bench.solve(row.file, row.parameters, seed, limit, plan, "--horizon", row.horizon)
    told = json.loads(plan.read_text()) if plan.exists() else {"windows": [], "timing": {"windows": []}}
    windows = [
        (window["reason"], window["motions"], len(window["actions"]), len(window["unmet"]), seconds)
        for window, seconds in zip(told["windows"], told["timing"]["windows"], strict=True)
    ]
    return {**run, "windows": windows}


def halves(runs: Sequence[bench.Run]) -> tuple[float, float]:
    """Median seconds per window in the first and in the second half of the runs."""
    early: list[float] = []
    late: list[float] = []
    for run in runs:
        windows = run.get("windows")
        taken = [float(window[4]) for window in windows] if isinstance(windows, list) else []
        early += taken[: len(taken) // 2]
        late += taken[len(taken) // 2 :]
    return bench.median(early), bench.median(late)


HEADINGS = (
    "task and horizon", "thesis s", "expanded", "length", "ours s", "worst s", "without start s", "CPU s", "expanded",
    "length", "windows", "first motion s", "s per window, early", "late", "MB at most",
    "MB early", "late", "verified", "thesis / ours", "goal s",
    "met",
)  # fmt: skip


def line(row: Row, runs: Sequence[bench.Run]) -> str:
    solved = bench.good(runs)
    wall, inside = bench.middle(solved, "wall"), bench.median([bench.seconds(run, "total") for run in solved])
    goal = f"{row.goal:.1f}" if row.goal is not None else f"{bench.SHORT_GOAL:g} + start"
    met = "yes" if solved and (wall <= row.goal if row.goal is not None else inside <= bench.SHORT_GOAL) else "no"
    first = bench.median([bench.seconds(run, "first_motion") for run in solved])
    if row.thesis is None:
        goal, met = "solved", "yes" if len(solved) == len(runs) else "no"
    if row.table == FIRST:
        goal, met = "first in 1 s", "yes" if first <= 1.0 else "no"
    theirs = [f"{row.thesis[0]:g}", *map(str, row.thesis[1:])] if row.thesis is not None else ["–"] * 3
    counts = [bench.median([len(run["windows"]) for run in solved if isinstance(run["windows"], list)])]
    ours = [bench.number(x) for x in (wall, bench.worst(solved), inside, bench.middle(solved, "cpu"))]
    counts = [bench.middle(solved, "expanded_nodes"), bench.middle(solved, "length"), *counts]
    ours += [bench.number(x, 0) for x in counts]
    ours += [bench.number(x) for x in (first, *halves(solved))]
    ours += [bench.number(bench.middle(solved, key), 0) for key in ("peak_mb", "early_mb", "late_mb")]
    ratio = bench.number(row.thesis[0] / wall, 1) if row.thesis is not None and solved else "–"
    return f"| {' | '.join((row.name, *theirs, *ours, f'{len(solved)}/{len(runs)}', ratio, goal, met))} |"


def markdown(rows: Sequence[Row], runs: bench.Runs, seeds: int) -> str:
    """One table for table 7, one for what goes beyond it, and one for the first motion."""
    text = [
        "# Receding horizon",
        "",
        "Made by `tamplang bench horizon --markdown docs/benchmarks-horizon.md`: one process `tamplang solve --horizon "
        "H` per row and seed, one after the other, on one core, with path bound, collisions and verification of the "
        "whole run.",
        "",
        f"{bench.today()}, {bench.machine()}, seeds 0 to {seeds - 1}. Times are medians over seeds, by the wall; the "
        f"goal is a {bench.FACTOR}th of the thesis' time where that is above {bench.LONG:g} s, else "
        f"{bench.SHORT_GOAL:g} s without process start. "
        "`first motion` is when the motion of the first window stands, process start left out. Seconds per window are "
        "medians over the windows in the first and in the second half of each run; resident memory, MB, is the median "
        "over the first and over the second half of the time between the first motion and the verification.",
    ]
    title = ""
    for row in rows:
        if row.table != title:
            title = row.table
            text += bench.table(title, HEADINGS)
        found = [run for seed, run in runs.get(row.name, {}).items() if int(seed) < seeds]
        if found:
            text.append(line(row, found))
    return "\n".join(text) + "\n"


def main() -> None:
    given = bench.options("horizon", __doc__ or "", 180.0)
    names = [f"{row.table}: {row.name}" for row in ROWS]
    rows = [row for row, taken in zip(ROWS, bench.chosen(names, given.rows), strict=True) if taken]
    runs = bench.measure({row.name: partial(run_of, row, given.time) for row in rows}, given.seeds, given.out)
    bench.tell(markdown(rows, runs, given.seeds), given.markdown)


if __name__ == "__main__":
    main()
