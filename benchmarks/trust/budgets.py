"""Hard inputs under small budgets: every command ends in its time, with a code and without a traceback.

The inputs of `hard.py`, each with three budgets. What counts is a process's own time: the wall, less what it waited
for a processor that others had (`/proc/PID/schedstat`; where the system does not tell that, the wall counts). Overrun
is the own time between the end of the budget and the end of the process. On a loaded machine a budget may end before
Python has started: then the overrun counts from where the process had the own time that an empty program takes. A sweep
has its time twice: for the program, and for its one instance.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from functools import cache
from pathlib import Path

from benchmarks.trust.hard import COMMAND, ENVIRONMENT, HARD
from benchmarks.trust.journal import Line, Record, Settings

BUDGETS = (0.7, 2.0, 6.0)
SHARE, LEAST = 0.1, 0.3
"""A command may overrun its budget by this share of it, or by so many seconds where that is more."""
STATUSES = frozenset({0, 1, 3, 4, 5, 6})


def _waited(process: subprocess.Popen[str]) -> float:
    """Seconds that the main thread of a process was ready and had no processor."""
    try:
        return int(Path(f"/proc/{process.pid}/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    except (OSError, IndexError, ValueError):
        return 0.0


@cache
def least() -> float:
    """Own seconds of a command on an empty program."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "empty.tamp").write_text("type thing\n", encoding="utf-8")
        return min(timed(["check", "empty.tamp"], Path(folder), 0.0)[1] for _ in range(3))


def timed(arguments: list[str], folder: Path, seconds: float) -> tuple[float, float, float, int, str]:
    """Runs a command: seconds of the wall, own seconds, own seconds after `seconds` of the wall, exit status, and what
    it printed."""
    with tempfile.TemporaryFile("w+", encoding="utf-8") as told:
        began = time.monotonic()
        process = subprocess.Popen(
            [*COMMAND, *arguments], cwd=folder, stdout=told, stderr=told, stdin=subprocess.DEVNULL, text=True,
            env=ENVIRONMENT,
        )  # fmt: skip
        waited = None
        while os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
            if waited is None and time.monotonic() - began >= seconds:
                waited = _waited(process)
            time.sleep(0.005)
        wall, ended = time.monotonic() - began, _waited(process)
        process.wait()
        told.seek(0)
        own = wall - ended
        after = wall - seconds if waited is None else own - (seconds - waited)
        return wall, own, after, process.returncode, told.read()


def measure(name: str, seconds: float) -> Record:
    """How one command ended under one budget, and what is wrong with that."""
    with tempfile.TemporaryDirectory() as folder:
        arguments = [*HARD[name](Path(folder)), "--time", str(seconds)]
        seconds = 2 * seconds if arguments[0] == "sweep" else seconds
        wall, own, after, status, told = timed(arguments, Path(folder), seconds)
    over = min(after, own - least())
    return {
        "wall": round(wall, 3),
        "over": round(over, 3),
        "kept": over <= max(SHARE * seconds, LEAST),
        "status": status,
        "sound": status in STATUSES and "Traceback" not in told,
        "coded": status != 4 or "S0" in told,
    }


def run(settings: Settings) -> list[Line]:
    """One line: how far commands overran, and which of them too far."""
    keys = [f"{name}|{seconds}" for name in list(HARD)[: settings.count] for seconds in BUDGETS]

    def measured(key: str) -> Record:
        name, seconds = key.split("|")
        return measure(name, float(seconds))

    records = list(settings.journal("budgets").fill(keys, measured))
    wrong = [f"{r['key']}: {r['over']:+.2f} s, status {r['status']}" for r in records
             if not (r["kept"] and r["sound"] and r["coded"])]  # fmt: skip
    worst = max(r["over"] for r in records)
    what = f"{len(keys) // len(BUDGETS)} hard inputs with {len(BUDGETS)} budgets: overrun at most 10 % or 0.3 s"
    return [Line("budgets", what, "; ".join([f"at most {worst:+.2f} s", *wrong]), not wrong)]
