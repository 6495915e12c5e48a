"""Hard inputs under small budgets: every command ends in its time, with a code and without a traceback.

Forty inputs that take long somewhere, made here: texts for parser, checks, scenes, the symbolic layer and PDDL,
searches without end, motion programs, plans for the verifier, sweeps and runs; each with three budgets. Overrun is told
by the wall: on a machine with other work it says nothing.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.trust.families import FAMILIES, MAIN
from benchmarks.trust.journal import Line, Record, Settings

ROOT = Path(__file__).resolve().parents[2]
BUDGETS = (0.7, 2.0, 6.0)
SHARE, LEAST = 0.1, 0.3
"""A command may overrun its budget by this share of it, or by so many seconds where that is more."""
STATUSES = frozenset({0, 1, 3, 4, 5, 6})
Make = Callable[[Path], list[str]]
"""Writes files into a folder and gives the arguments of a command, without `--time`."""


def _family(name: str, size: int, *command: str) -> Make:
    def make(folder: Path) -> list[str]:
        for file, text in FAMILIES[name].make(size).items():
            (folder / file).write_text(text, encoding="utf-8")
        return [command[0], MAIN, *command[1:]]

    return make


def _example(name: str, command: str, *options: str) -> Make:
    def make(folder: Path) -> list[str]:
        return [command, str(ROOT / "examples" / f"{name}.tamp"), *options]

    return make


def _plan(command: str, *options: str) -> Make:
    """A command on a plan of an example, which is made without a limit."""

    def make(folder: Path) -> list[str]:
        example = str(ROOT / "examples" / "climb.tamp")
        _command(["solve", example, "-p", "n=16", "--out", "plan.json"], folder)
        return [command, "plan.json", *options]

    return make


_LARGE = (
    ("wide bodies", 4000), ("wide loop", 9000), ("wide facts", 20000), ("wide rules", 4000), ("chained rules", 2000),
    ("wide conjunction", 20000), ("wide effects", 20000), ("wide declarations", 4000),
)  # fmt: skip
HARD: dict[str, Make] = {
    **{f"check {name}": _family(name, size, "check") for name, size in _LARGE},
    **{f"ir {name}": _family(name, size, "compile", "--emit", "ir") for name, size in _LARGE[:4]},
    **{f"pddl {name}": _family(name, size, "compile", "--emit", "pddl") for name, size in _LARGE},
    **{f"successors {name}": _family(name, size, "compile", "--emit", "successors") for name, size in _LARGE},
    **{f"solve {name}": _family(name, size, "solve", "--out", "out.json") for name, size in _LARGE[:4]},
    "search bfs": _example("rendezvous", "solve", "-p", "n=64", "--search", "bfs", "--bound", "seq"),
    "search solutions": _example("climb", "solve", "-p", "n=64", "--solutions", "900", "--bound", "seq"),
    "motion": _example("quadruped", "solve", "-p", "steps=2"),
    "horizon": _example("rendezvous", "solve", "-p", "n=64", "--horizon", "auto"),
    "run": _example("moving_stairs", "run"),
    "sweep": _example("climb", "sweep", "-p", "n=64"),
    "verify": _plan("verify"),
    "report": _plan("report", "--out", "plan.html"),
}


def _command(arguments: list[str], folder: Path) -> tuple[float, subprocess.CompletedProcess[str]]:
    began = time.monotonic()
    process = subprocess.run(
        [sys.executable, "-m", "tamplang", *arguments], cwd=folder, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    return time.monotonic() - began, process


def measure(name: str, seconds: float) -> Record:
    """Wall-clock seconds of one command under one budget, and what is wrong with how it ended."""
    with tempfile.TemporaryDirectory() as folder:
        arguments = HARD[name](Path(folder))
        wall, process = _command([*arguments, "--time", str(seconds)], Path(folder))
    return {
        "wall": round(wall, 3),
        "over": round(wall - seconds, 3),
        "kept": wall <= seconds + max(SHARE * seconds, LEAST),
        "status": process.returncode,
        "sound": process.returncode in STATUSES and "Traceback" not in process.stderr,
        "coded": process.returncode != 4 or "S0" in process.stderr + process.stdout,
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
