"""What each optional mechanism of the planner buys: the same tasks and seeds with all of them, and without each.

    tamplang bench ablation [--seeds 2] [--rows TEXT] [--time S] [--out FILE.json] [--markdown FILE.md]

One process `tamplang solve` for each mechanism, task and seed, one after the other, on one core. With --out, runs are
kept in FILE.json as they end and not run again. --rows takes the mechanisms whose name contains TEXT.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import _runs as bench
from _mechanisms import MECHANISMS, switch

SAME = 0.05
"""A share of the CPU time that is within what runs differ by."""
LIMIT = 300.0
"""Seconds by the wall of a run: so many that no run of a few CPU seconds ends by them on a busy machine."""
ALL = "all"
Task = tuple[str, tuple[tuple[str, int], ...], tuple[str, ...]]
TASKS: tuple[Task, ...] = (
    ("pick_and_place", (("objects", 8),), ()),
    ("strut_bridge", (), ()),
    ("climb", (("n", 16), ("crawlers", 2)), ("--horizon", "4")),
    ("mobile_manipulator", (("objects", 8),), ()),
    ("terraces", (), ()),
    ("climb", (("n", 16), ("crawlers", 2)), ()),
    ("quadruped", (), ()),
    ("quadruped", (("steps", 2),), ()),
    ("chain_climb", (("modules", 6),), ()),
    ("zoo/inchworm", (), ("own",)),
    ("zoo/climber", (), ("own",)),
    ("zoo/snake", (), ("place8",)),
    ("real_bridge", (), ()),
)


def name_of(task: Task) -> str:
    file, parameters, arguments = task
    return " ".join((file, *(f"{name}={value}" for name, value in parameters), *arguments))


def run_of(mechanism: str, task: Task, limit: float, seed: int, folder: Path) -> bench.Run:
    file, parameters, arguments = task
    more = MECHANISMS[mechanism].arguments if mechanism != ALL else ()
    program = ("-m", "tamplang") if mechanism == ALL else (str(Path(__file__).resolve()), "--without", mechanism)
    plan = folder / "plan.json"
    return bench.solve(file, parameters, seed, limit, plan, *arguments, *more, program=program)


def goes(mechanism: str, task: Task) -> bool:
    """A horizon goes with one process only."""
    return mechanism == ALL or not (MECHANISMS[mechanism].arguments and "--horizon" in task[2])


def key(mechanism: str, task: Task) -> str:
    return f"{mechanism}: {name_of(task)}"


def asked(run: bench.Run) -> int:
    """How often bounds were asked: it does not depend on the load of the machine."""
    bounds = run.get("bounds")
    return sum(b["solved"] + b["refused"] for b in bounds.values()) if isinstance(bounds, dict) else 0


def cell(base: Sequence[bench.Run], runs: Sequence[bench.Run]) -> str:
    """Solved and verified runs, and their CPU time and bounds asked over those of the same seeds with everything."""
    if not runs:
        return ""
    seen = base[: len(runs)]
    ratio = sum(float(str(r["cpu"])) for r in runs) / sum(float(str(b["cpu"])) for b in seen)
    bounds = f"{sum(map(asked, runs))}/{sum(map(asked, seen))}"
    lost = len(bench.good(seen)) - len(bench.good(runs))
    return f"{'' if not lost else f'{-lost:+d} solved, '}{ratio:.2f}, {bounds}"


def buys(base: Sequence[Sequence[bench.Run]], runs: Sequence[Sequence[bench.Run]]) -> str:
    """What is lost without a mechanism, over all rows: solved runs, and CPU seconds."""
    seconds = [sum(float(str(r["cpu"])) for row in rows for r in row) for rows in (base, runs)]
    solved = [sum(len(bench.good(row)) for row in rows) for rows in (base, runs)]
    return f"{solved[0] - solved[1]:+d} of {solved[0]} solved, {seconds[1] - seconds[0]:+.1f} s of {seconds[0]:.1f} s"


def commit() -> str:
    found = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, cwd=bench.ROOT)
    return found.stdout.strip()


def markdown(runs: bench.Runs, seeds: int) -> str:
    def of(mechanism: str, task: Task) -> list[bench.Run]:
        found = runs.get(key(mechanism, task), {})
        return [found[str(seed)] for seed in range(seeds) if str(seed) in found]

    base = [of(ALL, task) for task in TASKS]
    text = [
        "# What each mechanism buys", "",
        "Made by `tamplang bench ablation --markdown docs/ablation.md`: one process `tamplang solve` for each "
        "mechanism, task and seed, one after the other, on one core.", "",
        f"{bench.today()}, commit {commit()}, {bench.machine()}, seeds 0 to {seeds - 1}. A cell holds the CPU time "
        "without the mechanism over that with all, how often bounds were asked without and with it (which no load of "
        "the machine changes), and how many runs more or fewer were solved and verified where that differs. CPU times "
        f"within {100 * SAME:g} % say nothing. `speculation` is off as a rule: its row is with it.",
    ]  # fmt: skip
    text += bench.table("with everything", ["", *map(name_of, TASKS)])
    text.append(f"| solved | {' | '.join(f'{len(bench.good(row))} of {len(row)}' for row in base)} |")
    text.append(f"| CPU s | {' | '.join(bench.number(bench.middle(row, 'cpu')) for row in base)} |")
    text += bench.table("without", ["", "what", "buys", *map(name_of, TASKS)])
    for name, mechanism in MECHANISMS.items():
        found = [of(name, task) for task in TASKS]
        if any(found):
            cells = [cell(b, r) for b, r in zip(base, found, strict=True)]
            seen = [b[: len(r)] for b, r in zip(base, found, strict=True)]
            text.append(f"| {' | '.join((name, mechanism.text, buys(seen, found), *cells))} |")
    return "\n".join(text) + "\n"


def main() -> None:
    arguments = bench.options("ablation", __doc__ or "", LIMIT)
    names = [ALL, *MECHANISMS]
    kept = bench.chosen(names, arguments.rows)
    tasks = {
        key(name, task): partial(run_of, name, task, arguments.time)
        for task in TASKS for name, keep in zip(names, kept, strict=True) if keep and goes(name, task)
    }  # fmt: skip
    tasks = {k: (lambda seed, folder, run=run: run(seed=seed, folder=folder)) for k, run in tasks.items()}
    runs = bench.measure(tasks, arguments.seeds, arguments.out)
    bench.tell(markdown(runs, arguments.seeds), arguments.markdown)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--without"]:
        from tamplang.__main__ import main as command

        switch(sys.argv[2])
        sys.argv = ["tamplang", *sys.argv[3:]]
        command()
    else:
        main()
