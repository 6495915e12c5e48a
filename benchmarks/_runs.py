"""Runs of `tamplang solve` for benchmarks: one process each, one after the other, on one core, kept in a file as they
end; and what tables of them have in common."""

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
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FACTOR, LONG, SHORT_GOAL = 20, 40.0, 2.0
"""A row must take at most a 20th of the thesis' time where that is above 40 s, else 2 s without process start."""
LOOK = 0.02
"""Seconds between looks at the memory of a process."""
KEPT = ("status", "verified", "length", "tree_nodes", "expanded_nodes", "optimal", "seconds", "bounds", "worst")

Parameters = Sequence[tuple[str, int]]
Run = dict[str, object]
Runs = dict[str, dict[str, Run]]
"""By task, then by seed."""


def goal_of(thesis: float | None) -> float | None:
    """Seconds of the whole process, from those of the thesis; None where only a short time without process start
    counts."""
    return thesis / FACTOR if thesis is not None and thesis > LONG else None


def solve(
    file: str, parameters: Parameters, seed: int, limit: float, plan: Path, *arguments: str,
    program: Sequence[str] = ("-m", "tamplang"),
) -> Run:  # fmt: skip
    """One process of a `program` of Python that takes the commands of tamplang: what it printed, its wall and CPU
    seconds, its largest memory, and its memory in the first and in the second half of the time between the first motion
    of a run and the verdict, MB."""
    command = [sys.executable, *program, "solve", str(ROOT / "examples" / f"{file}.tamp"), "--json"]
    command += ["--seed", str(seed), "--time", str(limit), "--out", str(plan), *arguments]
    command += [f"-p{name}={value}" for name, value in parameters]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    plan.unlink(missing_ok=True)
    started = time.monotonic()
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment, cwd=plan.parent
    )
    assert process.stdout is not None
    looks: list[tuple[float, float]] = []
    ended = threading.Event()
    watcher = threading.Thread(target=_watch, args=(process.pid, started, looks, ended))
    watcher.start()
    output = process.stdout.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    wall = time.monotonic() - started
    ended.set()
    watcher.join()
    answer = json.loads(output) if output.startswith("{") else {"status": "error"}
    run: Run = {"wall": round(wall, 3), "cpu": round(usage.ru_utime + usage.ru_stime, 3)}
    peak = max((memory for _, memory in looks), default=usage.ru_maxrss / 1024)
    run |= {"peak_mb": round(peak), **{key: answer.get(key) for key in KEPT}}
    begin = wall - seconds(run, "total") + seconds(run, "first_motion")
    end = wall - seconds(run, "verify")
    half = (begin + end) / 2
    return {**run, "early_mb": _memory(looks, begin, half), "late_mb": _memory(looks, half, end)}


def _watch(process: int, started: float, looks: list[tuple[float, float]], ended: threading.Event) -> None:
    """The resident memory of a process by seconds, in MB, where the system tells it."""
    page = os.sysconf("SC_PAGE_SIZE") / 1024**2
    while not ended.wait(LOOK):
        try:
            pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
        except (OSError, IndexError):
            return
        looks.append((time.monotonic() - started, pages * page))


def _memory(looks: Sequence[tuple[float, float]], begin: float, end: float) -> float | None:
    """The median between two times; None where there are no looks."""
    found = [memory for at, memory in looks if begin <= at <= end]
    return round(statistics.median(found), 1) if found else None


def measure(tasks: Mapping[str, Callable[[int, Path], Run]], seeds: int, out: Path | None) -> Runs:
    """All runs of tasks, from seed and folder, that are not yet in `out`, one after the other; the file is rewritten
    after each."""
    runs: Runs = json.loads(out.read_text())["runs"] if out is not None and out.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        for name, task in tasks.items():
            for seed in range(seeds):
                if str(seed) in runs.get(name, {}):
                    continue
                run = task(seed, Path(folder))
                runs.setdefault(name, {})[str(seed)] = run
                shown = f"{run['status']}, verified {run['verified']}, length {run['length']}"
                times = f"{run['wall']} s, {run['cpu']} s of CPU"
                print(f"{name} seed {seed}: {times}, {shown}", file=sys.stderr, flush=True)
                if out is not None:
                    temporary = out.with_suffix(".part")
                    temporary.write_text(json.dumps({"machine": machine(), "date": today(), "runs": runs}, indent=1))
                    temporary.replace(out)
    return runs


def machine() -> str:
    return f"{os.cpu_count()}-core {platform.machine()}, {platform.system()}, Python {platform.python_version()}"


def today() -> str:
    return datetime.date.today().isoformat()


def good(runs: Sequence[Run]) -> list[Run]:
    """Those that ended with a verified plan."""
    return [run for run in runs if run.get("status") == "solved" and run.get("verified")]


def seconds(run: Run, stage: str) -> float:
    """Seconds of a stage of a run; process start and imports are left out of all of them."""
    stages = run.get("seconds")
    return float(stages.get(stage, float("nan"))) if isinstance(stages, dict) else float("nan")


def median(values: Sequence[float]) -> float:
    return statistics.median(values) if values else float("nan")


def middle(runs: Sequence[Run], key: str) -> float:
    """The median of a figure of runs."""
    return median([value for run in runs if isinstance(value := run.get(key), int | float)])


def worst(runs: Sequence[Run]) -> float:
    """The longest run by the wall."""
    return max((float(str(run["wall"])) for run in runs), default=float("nan"))


def number(value: float, digits: int = 2) -> str:
    """A dash where no run gave a figure."""
    return "–" if value != value else f"{value:.{digits}f}"


def table(title: str, headings: Sequence[str]) -> list[str]:
    """The lines above the rows of a table."""
    return ["", f"**{title[0].upper()}{title[1:]}**", "", f"| {' | '.join(headings)} |", "|---" * len(headings) + "|"]


def options(name: str, documentation: str, limit: float) -> argparse.Namespace:
    """What the command line says."""
    parser = argparse.ArgumentParser(prog=f"tamplang bench {name}", description=documentation.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=5, help="how many seeds per row, from 0")
    parser.add_argument("--rows", default="", help="only rows whose name contains this text")
    parser.add_argument("--time", type=float, default=limit, help="seconds per run")
    parser.add_argument("--out", type=Path, help="JSON file that keeps the runs")
    parser.add_argument("--markdown", type=Path, help="write the table there instead of on standard output")
    return parser.parse_args()


def chosen(names: Sequence[str], text: str) -> list[bool]:
    """Which rows the text chooses; ends the program where it chooses none."""
    found = [text in name for name in names]
    if not any(found):
        sys.exit(f"no row contains {text!r}; the rows are:\n" + "\n".join(names))
    return found


def tell(text: str, file: Path | None) -> None:
    if file is not None:
        file.write_text(text, encoding="utf-8")
    else:
        print(text, end="")
