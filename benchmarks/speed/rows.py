"""The rows of the benchmark of speed: what is run, and the goals."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TASKS = Path(__file__).resolve().parent / "tasks"
TWICE = """
import sys, time
from tamplang.api import load
for again in range(2):
    started = time.process_time()
    result = load(sys.argv[1], seed=int(sys.argv[3]), **dict([sys.argv[2].split("=")])).solve()
    spent = time.process_time() - started
print(result.status, spent)
sys.exit(result.status != "solved")
"""
"""Solves a task twice and tells the CPU seconds of the second time."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line: arguments of an interpreter, where {plan}, {folder} and {seed} are put in. `first` makes what the row
    needs, by this row's build, and is not counted.

    Goals: `cpu` and `memory` are ratios to the other build, `seconds` CPU seconds, `megabytes` of peak memory, `file`
    the ratio of the sizes of the plan files; None is no goal. `against` names the row whose time in the other build
    counts instead of this row's; `growth` a row of this build and the largest ratio to it.
    """

    name: str
    arguments: tuple[str, ...]
    cpu: float | None = None
    memory: float | None = None
    seconds: float | None = None
    megabytes: float | None = None
    file: float | None = None
    first: tuple[str, ...] = ()
    against: str | None = None
    growth: tuple[str, float] | None = None
    inner: bool = False
    long: bool = False


def _text(name: str) -> str:
    own = TASKS / f"{name}.tamp"
    return str(own if own.exists() else EXAMPLES / f"{name}.tamp")


def _solve(file: str, limit: float, *arguments: str) -> tuple[str, ...]:
    parameters = [f"-p{a}" if "=" in a and not a.startswith("-") else a for a in arguments]
    fixed = ("--seed", "{seed}", "--time", str(limit), "--out", "{plan}")
    return ("-m", "tamplang", "solve", _text(file), *fixed, *parameters)


def _row(
    file: str, *arguments: str, cpu: float | None = None, memory: float | None = None, seconds: float | None = None,
    megabytes: float | None = None, file_size: float | None = None, growth: tuple[str, float] | None = None,
    limit: float = 120.0, long: bool = False,
) -> Row:  # fmt: skip
    name = " ".join((file, *arguments))
    return Row(
        name, _solve(file, limit, *arguments), cpu, memory, seconds, megabytes, file_size, growth=growth, long=long
    )


def _verify(file: str, *arguments: str, memory: float | None = None, long: bool = False) -> Row:
    name = " ".join(("verify", file, *arguments))
    first = _solve(file, 300.0, *arguments)
    return Row(name, ("-m", "tamplang", "verify", "{plan}"), cpu=0.5, memory=memory, first=first, long=long)


ROWS = [
    Row("version", ("-m", "tamplang", "--version"), seconds=0.1),
    Row("import tamplang.api", ("-c", "import tamplang.api"), cpu=1.0),
    Row("check climb", ("-m", "tamplang", "check", _text("climb")), cpu=0.7),
    Row("compile climb n=8", ("-m", "tamplang", "compile", _text("climb"), "--emit", "ground"), cpu=0.7),
    _row("climb", "n=8", cpu=0.6),
    Row(
        "climb n=8, again in one process",
        ("-c", TWICE, _text("climb"), "n=8", "{seed}"),
        cpu=0.3,
        against="climb n=8",
        inner=True,
    ),
    *(_row("climb", f"n={n}", cpu=0.6) for n in (1, 2, 4, 16, 32, 64)),
    *(_row("climb", "crawlers=1", f"n={n}", cpu=0.6) for n in (1, 2, 4, 8, 16, 32, 64)),
    *(_row("rendezvous", f"n={n}", cpu=0.6) for n in (1, 2, 4, 8)),
    *(_row("mobile_manipulator", f"objects={n}", cpu=0.6) for n in (1, 2, 4, 8)),
    *(_row("pick_and_place", f"objects={n}", cpu=0.6) for n in (3, 8)),
    _row("pick_and_place", "objects=16", "--horizon", "4", cpu=0.45),
    *(_row("quadruped", f"steps={n}", cpu=0.4) for n in (1, 2)),
    _row("chain_climb", "modules=4", cpu=0.6),
    _verify("climb", "n=8"),
    _verify("pick_and_place", "objects=3"),
    _verify("mobile_manipulator", "objects=8"),
    _verify("quadruped"),
    _row("bodies", "fixed=10"),
    _row("bodies", "fixed=5000", growth=("bodies fixed=10", 1.3)),
    *(_row("climb", f"n={n}", long=True) for n in (128, 256)),
    _row("climb", "n=512", cpu=0.5, limit=300, long=True),
    _row("climb", "n=1024", seconds=25.0, limit=300, long=True),
    _row("climb", "n=4096", seconds=150.0, megabytes=2048.0, limit=600, long=True),
    _row("climb", "crawlers=1", "n=256", seconds=300.0, limit=300, long=True),
    *(_row("chain_climb", f"modules={n}", seconds=s, limit=s, long=True) for n, s in ((12, 60), (16, 120), (24, 300))),
    *(_row("crowd", f"crawlers={n}", seconds=60.0, long=True) for n in (8, 32)),
    _row("mobile_manipulator", "objects=64", cpu=0.5, memory=0.35, file_size=0.16, limit=300, long=True),
    _verify("mobile_manipulator", "objects=64", memory=0.35, long=True),
    _row("mobile_manipulator", "objects=256", "--horizon", "auto", seconds=150.0, limit=600, long=True),
    _verify("climb", "n=256", long=True),
]
