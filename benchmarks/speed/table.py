"""The table of the benchmark of speed."""

from __future__ import annotations

import datetime
import math
import os
import platform
import statistics
from collections.abc import Sequence

from benchmarks.speed.rows import Row
from benchmarks.speed.runs import Run, Runs

HEADINGS = (
    "work", "other CPU s", "this CPU s", "ratio", "least … most", "other MB", "this MB", "ratio", "plan files", "done",
    "goal", "met",
)  # fmt: skip


def markdown(rows: Sequence[Row], runs: Runs) -> str:
    """Medians of each row, and its goals."""
    machine = f"{os.cpu_count()}-core {platform.machine()}, {platform.system()}, Python {platform.python_version()}"
    lines = [
        "# Speed and size against another build",
        "",
        "Made by `tamplang bench speed --baseline PYTHON --markdown docs/benchmarks-speed.md`: whole processes, byte "
        "code cached, one core, both builds in turn on the same texts and seeds.",
        "",
        f"{datetime.date.today().isoformat()}, {machine}. CPU seconds and peak memory are medians over the runs of "
        "each build, least and most those of the ratios run by run, *done* the runs that ended well, of the other "
        "build and of this.",
        "",
        f"| {' | '.join(HEADINGS)} |",
        "|---" * len(HEADINGS) + "|",
        *(_line(row, runs) for row in rows),
    ]
    ratios = [r for row in rows if not math.isnan(r := _ratio(row, runs, "cpu")) and row.growth is None]
    if ratios:
        lines += ["", f"Geometric mean of the ratios of CPU seconds: {statistics.geometric_mean(ratios):.2f}."]
    return "\n".join(lines) + "\n"


def _line(row: Row, runs: Runs) -> str:
    sides = [runs[row.name].get(name, []) for name in ("other", "this")]
    pairs = [b["cpu"] / a["cpu"] for a, b in zip(*sides, strict=False) if a["ended"] and b["ended"] and a["cpu"]]
    spread = f"{min(pairs):.2f} … {max(pairs):.2f}" if pairs and row.against is None else "–"
    done = " / ".join(f"{sum(r['ended'] for r in side):.0f} of {len(side)}" for side in sides)
    cells = (
        row.name, _shown(_middle(sides[0], "cpu")), _shown(_middle(sides[1], "cpu")), _shown(_ratio(row, runs, "cpu")),
        spread, _shown(_middle(sides[0], "memory"), 0), _shown(_middle(sides[1], "memory"), 0),
        _shown(_ratio(row, runs, "memory")), _shown(_ratio(row, runs, "file")), done, *_goals(row, runs),
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def _goals(row: Row, runs: Runs) -> tuple[str, str]:
    """What is aimed at, and whether it is reached."""
    mine = runs[row.name].get("this", [])
    asked = [
        (f"CPU ≤ {row.cpu}", _ratio(row, runs, "cpu"), row.cpu),
        (f"memory ≤ {row.memory}", _ratio(row, runs, "memory"), row.memory),
        (f"≤ {row.seconds} s", _middle(mine, "cpu"), row.seconds),
        (f"≤ {row.megabytes} MB", _middle(mine, "memory"), row.megabytes),
        (f"file ≤ {row.file}", _ratio(row, runs, "file"), row.file),
    ]
    if row.growth is not None:
        name, most = row.growth
        grown = _middle(mine, "cpu") / _middle(runs.get(name, {}).get("this", []), "cpu")
        asked.append((f"≤ {most} times {name}", grown, most))
    goals = [(text, value, most) for text, value, most in asked if most is not None]
    done = all(run["ended"] for run in mine)
    met = done and all(value <= most for _, value, most in goals)
    return ", ".join(text for text, _, _ in goals) or "–", ("yes" if met else "no") if goals else "–"


def _ratio(row: Row, runs: Runs, key: str) -> float:
    """This build's median by the other's; none where one of them did not get to the end."""
    other = runs.get(row.against or row.name, {}).get("other", [])
    above, below = _middle(runs[row.name].get("this", []), key), _middle(other, key)
    return above / below if below else float("nan")


def _middle(side: Sequence[Run], key: str) -> float:
    """The median over the runs that ended well."""
    return statistics.median([run[key] for run in side if run["ended"]] or [float("nan")])


def _shown(value: float, digits: int = 2) -> str:
    return "–" if math.isnan(value) else f"{value:.{digits}f}"
