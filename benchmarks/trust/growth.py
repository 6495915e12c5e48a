"""Growth: the CPU time of families of programs against their size, or the coded limit that ends them.

A family is measured at its three largest sizes through `check` and every stage of `compile` that grows with it. The
exponent is the slope of log time against log size between the smallest and the largest of those that gave a result;
a size that ends with a coded limit (exit status 1 and one of the codes in LIMITS) counts as kept. Other work on the
machine only adds to a time: what seems to grow too fast is measured again, and the least time counts.
"""

from __future__ import annotations

import math
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.trust.families import FAMILIES, MAIN
from benchmarks.trust.journal import Line, Record, Settings

ROOT = Path(__file__).resolve().parents[2]
STAGES = ("check", "ir", "successors", "pddl")
LIMITS = frozenset({"E0008", "E0015", "E0314", "E0510"})
EXPONENT = 1.2
SECONDS = 60
"""CPU seconds after which a command is ended: nothing in the families may come near."""
LEAST = 0.25
"""CPU seconds above an empty program below which a time says nothing about growth."""
AGAIN = 3
"""How often a family that seems to grow too fast is measured again."""
_CODE = re.compile(r"\b([EWS]\d{4})\b")


def measure(name: str, size: int, stage: str) -> Record:
    """CPU seconds, exit status and codes of one command on one program of a family."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in FAMILIES[name].make(size).items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        arguments = ["check", "--format", "concise", MAIN] if stage == "check" else ["compile", MAIN, "--emit", stage]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        process = subprocess.run(
            [sys.executable, "-m", "tamplang", *arguments], cwd=folder, capture_output=True, text=True, check=False,
            env={**os.environ, "PYTHONPATH": str(ROOT)}, preexec_fn=_bounded,
        )  # fmt: skip
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    told = process.stdout if stage == "check" else process.stderr
    return {
        "cpu": round(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, 3),
        "status": process.returncode,
        "codes": sorted(set(_CODE.findall(told))),
        "traceback": "Traceback" in process.stderr or process.returncode not in (0, 1),
    }


def _bounded() -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))


def limited(record: Record) -> bool:
    """Whether a command ended with a coded limit."""
    return record["status"] == 1 and bool(LIMITS & set(record["codes"]))


def exponent(found: Sequence[tuple[int, float]]) -> float:
    """The slope between the smallest and the largest size, of times above an empty program, or 0."""
    if len(found) < 2 or found[-1][1] < LEAST:
        return 0.0
    (small, early), (large, late) = found[0], found[-1]
    return math.log(late / max(early, LEAST / 4)) / math.log(large / small)


def _seconds(record: Record) -> float:
    return float(record["cpu"])


def _slope(name: str, kept: Mapping[int, Record], empty: float) -> float:
    return exponent([(FAMILIES[name].parts(size), _seconds(record) - empty) for size, record in kept.items()])


def run(settings: Settings) -> list[Line]:
    """One line for the families: the worst exponent, and what broke the promise."""
    names = list(FAMILIES)[: settings.count]
    keys = [f"{name}|{size}|{stage}" for name in names for stage in STAGES for size in FAMILIES[name].sizes]
    journal = settings.journal("growth")
    empty = min(measure("nested groups", 1, "check")["cpu"] for _ in range(3))

    def measured(key: str) -> Record:
        name, size, stage, *_ = key.split("|")
        return measure(name, int(size), stage)

    list(journal.fill(keys, measured))
    worst, broken, ended = 0.0, [], 0
    for name in names:
        for stage in STAGES:
            rows = {size: journal.records[f"{name}|{size}|{stage}"] for size in FAMILIES[name].sizes}
            ended += sum(limited(record) for record in rows.values())
            kept = {size: record for size, record in rows.items() if not limited(record)}
            slope = _slope(name, kept, empty)
            for number in range(AGAIN):
                if slope > EXPONENT:
                    again = journal.fill([f"{name}|{size}|{stage}|{number}" for size in kept], measured)
                    kept = {s: min(kept[s], r, key=_seconds) for s, r in zip(list(kept), again, strict=True)}
                    slope = _slope(name, kept, empty)
            worst = max(worst, slope)
            if slope > EXPONENT or any(r["traceback"] for r in rows.values()):
                broken.append(f"{name} ({stage}): {slope:.2f}")
    result = f"exponent at most {worst:.2f}; {ended} of {len(keys)} ended by a coded limit"
    what = f"growth of CPU time with size, {len(names)} families, at most {EXPONENT}"
    return [Line("growth", what, "; ".join([result, *broken]), not broken)]
