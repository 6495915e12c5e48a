"""Our symbolic layer beside Fast Downward and pyperplan, on the same tasks through the PDDL export.

    python -m venv /tmp/planners && /tmp/planners/bin/pip install up-fast-downward pyperplan
    python benchmarks/planners.py --peers /tmp/planners [--tasks climb] [--sizes 8 64] [--limit 120] [--memory 8]
        [--only "FD optimal"] [--markdown FILE]

CPU seconds end to end: ours from the text of the task to an optimal skeleton (the interpreter's start left out); Fast
Downward from the PDDL to an optimal plan (A* with LM-cut) and to any plan (lazy greedy, FF); pyperplan to any plan
(greedy, FF). The export itself is not charged to anyone. A peer that is not installed is left out with a line.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.symbolic.pddl import to_pddl
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import SkeletonSearch

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
TASKS = {"climb": {"crawlers": "2"}, "rendezvous": {}}
INSTALL = "python -m venv DIR && DIR/bin/pip install up-fast-downward pyperplan; then --peers DIR"
OPTIMAL = ("--search", "astar(lmcut())")
OUT_OF_MEMORY = ("MemoryError", "bad_alloc", "Memory limit has been reached", "exit code: 20", "exit code: 22")
GREEDY = ("--evaluator", "h=ff()", "--search", "lazy_greedy([h], preferred=[h])")


@dataclass(frozen=True)
class Peer:
    """A planner: its name in the table, and its command line before the two PDDL files and after them."""

    name: str
    command: tuple[str, ...]
    options: tuple[str, ...]


def peers(root: Path) -> list[Peer]:
    """Those that are installed in the virtual environment `root`."""
    found = []
    driver = next(root.glob("lib/python*/site-packages/up_fast_downward/downward/fast-downward.py"), None)
    if driver is None:
        print(f"Fast Downward is not installed in {root} and is left out ({INSTALL})")
    else:
        command = (str(root / "bin" / "python"), str(driver))
        found += [Peer("FD optimal", command, OPTIMAL), Peer("FD greedy", command, GREEDY)]
    pyperplan = root / "bin" / "pyperplan"
    if pyperplan.exists():
        found.append(Peer("pyperplan", (str(pyperplan), "-H", "hff", "-s", "gbf"), ()))
    else:
        print(f"pyperplan is not installed in {root} and is left out ({INSTALL})")
    return found


def ours(file: str, parameters: dict[str, str]) -> tuple[float, int]:
    """CPU seconds from text to optimal skeleton, and its length."""
    started = time.process_time()
    problem, _ = compile_problem(EXAMPLES / file, None, parameters)
    candidate = SkeletonSearch(problem, Successors(problem), "astar", Budget(60)).next()
    assert candidate is not None and candidate.optimal
    return time.process_time() - started, len(candidate.actions)


def measure(peer: Peer, folder: Path, limit: float, memory: float) -> str:
    """CPU seconds of a planner and its children until a plan, or why there is none; `memory` in GB for each process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [*peer.command, str(folder / "domain.pddl"), str(folder / "task.pddl"), *peer.options]
    limits = f'ulimit -t {limit:.0f} -v {memory * 1e6:.0f}; exec "$@"'
    limited = ["bash", "-c", limits, "planner", *command]
    result = subprocess.run(limited, cwd=folder, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if "Plan length" in result.stdout + result.stderr:
        return f"{seconds:.2f}"
    if seconds >= 0.9 * limit:
        return f"none in {limit:.0f}"
    full = any(sign in result.stdout + result.stderr for sign in OUT_OF_MEMORY)
    return f"{f'more than {memory:.0f} GB' if full else 'failed'} after {seconds:.2f}"


def rows(tasks: list[str], sizes: list[str], found: list[Peer], limit: float, memory: float) -> Iterator[list[str]]:
    """One row for each task and size."""
    ours("climb.tamp", {"n": "1"})
    for n in sizes:
        for name in tasks:
            file = f"{name}.tamp"
            given = {**TASKS[name], "n": n}
            best, length = min(ours(file, given) for _ in range(3))
            with tempfile.TemporaryDirectory() as place:
                folder = Path(place)
                domain, task = to_pddl(compile_problem(EXAMPLES / file, None, given)[0])
                (folder / "domain.pddl").write_text(domain)
                (folder / "task.pddl").write_text(task)
                times = [measure(peer, folder, limit, memory) for peer in found]
            ratios = [float(t.split()[-1]) / best for t, p in zip(times, found, strict=True) if p.name == "FD optimal"]
            solved = bool(times) and times[0].replace(".", "").isdigit()
            shown = [f"{'' if solved else '> '}{r:.0f}" for r in ratios] or ["–"]
            yield [f"{name} n={n}", str(length), f"{best:.3f}", *times, *shown]


def main() -> None:
    parser = argparse.ArgumentParser(description="Our symbolic layer beside other planners.")
    parser.add_argument("--peers", type=Path, default=Path("/tmp/planners"), help="virtual environment with the peers")
    parser.add_argument("--tasks", nargs="+", choices=sorted(TASKS), default=sorted(TASKS), help="which examples")
    parser.add_argument("--sizes", nargs="+", default=["8", "64", "256"], help="numbers of stairs")
    parser.add_argument("--limit", type=float, default=120.0, help="CPU seconds for each run of a peer")
    parser.add_argument("--memory", type=float, default=8.0, help="GB of memory for each process of a peer")
    parser.add_argument("--only", nargs="+", help="the peers that are measured, by their names in the table")
    parser.add_argument("--markdown", type=Path, help="write the table there as well")
    given = parser.parse_args()
    found = [peer for peer in peers(given.peers) if not given.only or peer.name in given.only]
    head = ["task", "length", "ours s", *(f"{p.name} s" for p in found), "FD optimal / ours"]
    print("  ".join(head))
    table = [head, ["---"] * len(head)]
    for row in rows(given.tasks, given.sizes, found, given.limit, given.memory):
        table.append(row)
        print("  ".join(row), flush=True)
    if given.markdown:
        given.markdown.write_text("".join(f"| {' | '.join(row)} |\n" for row in table))


if __name__ == "__main__":
    main()
