"""Speed of the motion layer, side by side with a C++ peer (rai's KOMO, PyPI package `robotic`).

    tamplang bench motion [--rows REGEX] [--seeds N] [--quick] [--json FILE] [--peer PYTHON]

Both sides get the same crawler, scene, skeleton, slices and seeds. Times are CPU seconds, medians over the seeds; both
sides' motions are judged by the same checks (benchmarks/peer/judge.py), and what is solved with collisions also by
tamplang's verifier. With --json, runs that the file already holds are not repeated.

The peer runs in a process and a virtual environment of its own:

    python3 -m venv ~/.cache/tamplang/peer && ~/.cache/tamplang/peer/bin/pip install robotic==0.4.2
    sudo apt-get install liblapack3
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")
HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import numpy as np  # noqa: E402
from peer import cases, judge, ours  # noqa: E402

Record = dict[str, Any]
PEER = Path.home() / ".cache" / "tamplang" / "peer" / "bin" / "python"
COLLISIONS = "path with collisions"
FEASIBLE_MISS = 1e-6
INSET = 0.03
"""By how much P_seq keeps away from joint limits, radians: what it refuses for that alone is told apart."""
PEER_LIMIT = 200.0
"""Wall seconds for one run of the peer."""


@dataclass(frozen=True)
class Row:
    """One line of the table. `ours` and `theirs` give the record of one seed; `verdict` the goal and whether it is met
    from the records of both sides."""

    name: str
    ours: Callable[[int], Record]
    theirs: Callable[[int], Record] | None
    verdict: Callable[[list[Record], list[Record]], tuple[str, bool | None]]
    seeds: int = 0
    """Seeds of our side when they are not the usual number."""


# --- one run ---------------------------------------------------------------------------------------------------------


def judged(case: cases.Case, answer: Record, crawler: Any, items: Any, bound: str) -> Record:
    """The answer with what the judge says, without the motion."""
    slices = answer["slices"]
    accepted, worst = judge.judge(case, crawler, items, slices, bound == COLLISIONS)
    return {**answer, "judged": accepted, "worst": worst, "cost": judge.cost(crawler, case.phases, slices)}


def solve(kind: str, size: int, bound: str, seed: int) -> Record:
    """Our side of one case and bound."""
    case = CASES[kind](size, seed)
    prepared = ours.BUILDERS[kind](case)
    answer = ours.solve(prepared, bound, seed)
    paths = answer.pop("paths", None)
    if not paths:
        return {**answer, "judged": False}
    record = judged(case, answer, *ours.motion(prepared, paths), bound)
    if bound == COLLISIONS:
        record["verified"] = ours.verified(prepared, paths)
    return record


def solve_together(crawlers: int, steps: int, seed: int) -> Record:
    """Crawlers that connect and climb together; the verifier judges."""
    prepared = ours.climb_together(cases.climb(steps, seed), crawlers)
    answer = ours.solve(prepared, COLLISIONS, seed)
    paths = answer.pop("paths", None)
    answer["verified"] = answer["judged"] = bool(paths) and ours.verified(prepared, paths)
    return answer


class Peer:
    """The other side: one process per run."""

    def __init__(self, python: Path) -> None:
        self.python = python
        self.missing = self._missing()

    def _missing(self) -> str:
        """Why there is no peer, or nothing."""
        if not self.python.is_file():
            return f"no {self.python}"
        command = [str(self.python), "-c", "import robotic"]
        found = subprocess.run(command, capture_output=True, text=True, check=False)
        return found.stderr.strip().rpartition("\n")[2] if found.returncode else ""

    def solve(self, kind: str, size: int, bound: str, seed: int) -> Record:
        """One case and bound; a run that takes too long or dies counts as not solved."""
        case = CASES[kind](size, seed)
        with tempfile.TemporaryDirectory() as folder:
            job, result = Path(folder, "job.json"), Path(folder, "result.json")
            job.write_text(json.dumps({"case": case.record(), "bound": bound, "seed": seed}))
            command = [str(self.python), str(HERE / "peer" / "komo.py"), str(job), str(result)]
            failed = {"cpu": float("nan"), "feasible": False, "judged": False}
            try:
                done = subprocess.run(command, capture_output=True, text=True, timeout=PEER_LIMIT, check=False)
            except subprocess.TimeoutExpired:
                return {**failed, "cpu": PEER_LIMIT, "why": "out of time"}
            if done.returncode:
                return {**failed, "why": done.stderr.strip()[-300:]}
            answer = json.loads(result.read_text())
        crawler, items = np.array(answer.pop("crawler")), np.array(answer.pop("items"))
        return judged(case, answer, crawler, items, bound)


def refuse(steps: int, seed: int) -> Record:
    """P_seq of steps whose last one is 1.5 m long."""
    prepared = ours.climb(cases.too_far(steps, seed))
    answer = ours.solve(prepared, "seq", seed)
    answer.pop("paths", None)
    return {**answer, "judged": not answer["feasible"]}


def random_step(seed: int) -> Record:
    """One step to anywhere, without collisions: whether P_seq says what many starts of least squares find."""
    case = cases.single_step(seed)
    prepared = ours.climb(case)
    answer = ours.solve(prepared, "seq", seed)
    paths = answer.pop("paths", None)
    wrong, miss = "", None
    if answer["feasible"]:
        kept = bool(paths) and judge.judge(case, *ours.motion(prepared, paths), 1, False)[0]
        wrong = "" if kept else "acceptance"
    else:
        miss = judge.nearest_miss(case)
        if miss < FEASIBLE_MISS:
            wrong = "refusal" if judge.nearest_miss(case, inset=INSET) < FEASIBLE_MISS else "limit"
    return {**answer, "judged": not wrong, "wrong": wrong, "miss": miss}


def growth(steps: int, seed: int) -> Record:
    """The path with collisions in a process of its own, with the memory that it adds."""
    command = [sys.executable, __file__, "--alone", str(steps), str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def alone(steps: int, seed: int) -> None:
    """What `growth` runs: its record on standard output."""
    warm_up()
    before = memory("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from now on
    prepared = ours.climb(cases.climb(steps, seed))
    answer = ours.solve(prepared, COLLISIONS, seed)
    answer["megabytes"] = memory("VmHWM") - before
    answer["judged"] = bool(answer.pop("paths", None))
    print(json.dumps(answer))


def memory(field: str) -> float:
    """A figure of this process in megabytes, as Linux tells it."""
    status = Path("/proc/self/status").read_text()
    return int(next(line.split()[1] for line in status.splitlines() if line.startswith(f"{field}:"))) / 1024


def warm_up() -> None:
    """Imports and stage functions of the crawler, which are made once per process."""
    for kind in ("climb", "pick"):
        prepared = ours.BUILDERS[kind](CASES[kind](2, 0))
        for bound in ("seq", "path", COLLISIONS):
            ours.solve(prepared, bound, 0)
    ours.solve(ours.climb_together(cases.climb(1, 0), 2), COLLISIONS, 0)


CASES: dict[str, Callable[[int, int], cases.Case]] = {"climb": cases.climb, "pick": cases.pick}


# --- the rows --------------------------------------------------------------------------------------------------------


def median(records: list[Record], key: str = "cpu") -> float:
    values = [r[key] for r in records if r.get(key) is not None]
    return statistics.median(values) if values else float("nan")


def share(records: list[Record], key: str) -> float:
    return sum(bool(r.get(key)) for r in records) / len(records) if records else 0.0


def cost_ratio(mine: list[Record], theirs: list[Record]) -> float:
    """Median ratio of the costs, over the seeds that both sides solved."""
    ratios = [a["cost"] / b["cost"] for a, b in zip(mine, theirs, strict=False) if a["judged"] and b["judged"]]
    return statistics.median(ratios) if ratios else float("nan")


def ratio(mine: list[Record], theirs: list[Record]) -> float:
    return median(mine) / median(theirs) if theirs else float("nan")


Verdict = Callable[[list[Record], list[Record]], tuple[str, bool | None]]


def beside_peer(most: float, cost: float | None, key: str = "judged", least: float = 1.0) -> Verdict:
    """At most `most` times the peer's time and `cost` times its cost; a share `least` of the runs is right."""

    def verdict(mine: list[Record], theirs: list[Record]) -> tuple[str, bool | None]:
        goal = f"ratio ≤ {most:g}" + (f", cost ≤ {cost:g}×" if cost else "") + f", {least:.0%} {key}"
        if not theirs:
            return goal, None if share(mine, key) >= least else False
        cheap = cost is None or not cost_ratio(mine, theirs) > cost
        return goal, ratio(mine, theirs) <= most and cheap and share(mine, key) >= least

    return verdict


def under(seconds: float, key: str, least: float) -> Verdict:
    def verdict(mine: list[Record], theirs: list[Record]) -> tuple[str, bool | None]:
        return f"< {seconds:g} s, {least:.0%} {key}", median(mine) < seconds and share(mine, key) >= least

    return verdict


def truthful(mine: list[Record], theirs: list[Record]) -> tuple[str, bool | None]:
    accepted, refused = (sum(r["wrong"] == w for r in mine) for w in ("acceptance", "refusal"))
    close = sum(r["wrong"] == "limit" for r in mine)
    goal = f"0 wrong acceptances ({accepted}), ≤ 1 % wrong refusals ({refused}; {close} more only at the joint limits)"
    return goal, accepted == 0 and refused <= 0.01 * len(mine)


def rows(peer: Peer, seeds: int, quick: bool) -> list[Row]:
    """All rows of the table, in its order."""
    table: list[Row] = []
    lengths = (10, 20) if quick else (10, 20, 40)
    with_peer = not peer.missing

    def add(kind: str, size: int, bound: str, name: str, verdict: Verdict, count: int = 0, beside: str = "") -> None:
        def mine(seed: int) -> Record:
            return solve(kind, size, bound, seed)

        def theirs(seed: int) -> Record:
            return peer.solve(kind, size, beside or bound, seed)

        table.append(Row(name, mine, theirs if with_peer else None, verdict, count))

    for steps in lengths:
        add("climb", steps, "seq", f"P_seq K={steps}", beside_peer(1.0, 1.05))
    for steps in lengths:
        add("climb", steps, "path", f"P_path K={steps}", beside_peer(1.0, 1.05))
    for steps in lengths:
        many = 0 if quick else 20
        add("climb", steps, COLLISIONS, f"collisions K={steps}", beside_peer(0.5, None, "verified", 0.95), many)
    for items in (1, 4, 8) if quick else (1, 4, 8, 16):
        add("pick", items, "path", f"pick n={items}", beside_peer(1.0, None))
    for items in (1, 4, 8) if quick else (1, 4, 8, 16):
        verdict = beside_peer(1.0, None, "verified")
        add("pick", items, COLLISIONS, f"pick with collisions n={items}", verdict, 0, "path")
    many = seeds if quick else 20
    for crawlers, steps, limit, count in ((2, 26, 5.0, many), (5, 3, 2.0, 0)):
        name = f"{crawlers} crawlers dock, {steps} steps"
        verdict = under(limit, "verified", 0.95)
        table.append(Row(name, lambda s, n=crawlers, k=steps: solve_together(n, k, s), None, verdict, count))
    for steps in (5, 10, 20, 40) if quick else (5, 10, 20, 40, 80):
        table.append(Row(f"growth K={steps}", lambda s, k=steps: growth(k, s), None, lambda a, b: ("", None)))
    table.append(Row("refuse 1.5 m, K=1", lambda s: refuse(1, s), None, under(0.1, "judged", 1.0)))
    table.append(Row("refuse 1.5 m, K=20", lambda s: refuse(20, s), None, under(0.5, "judged", 1.0)))
    table.append(Row("random steps", random_step, None, truthful, 40 if quick else 200))
    return table


# --- the table -------------------------------------------------------------------------------------------------------


class Store:
    """Records by row, side and seed, kept in a file as they come."""

    def __init__(self, file: Path | None) -> None:
        self.file = file
        self.runs: dict[str, Record] = {}
        if file is not None and file.is_file():
            self.runs = json.loads(file.read_text())["runs"]

    def get(self, key: str, run: Callable[[], Record]) -> Record:
        if key not in self.runs:
            started = time.monotonic()
            self.runs[key] = run()
            wall = time.monotonic() - started
            print(f"{key}: {self.runs[key]['cpu']:.3f} s CPU, {wall:.1f} s in all", file=sys.stderr)
            if self.file is not None:
                self.file.write_text(json.dumps({"machine": machine(), "runs": self.runs}, indent=1))
        return self.runs[key]


def machine() -> str:
    return f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def line(row: Row, mine: list[Record], theirs: list[Record]) -> str:
    """One row of the Markdown table."""
    goal, met = row.verdict(mine, theirs)
    right = f"{sum(bool(r.get('verified', r['judged'])) for r in mine)} of {len(mine)}"
    peer = f"{sum(bool(r['judged']) for r in theirs)} of {len(theirs)}" if theirs else ""
    numbers = [median(mine), median(theirs), ratio(mine, theirs), cost_ratio(mine, theirs)]
    shown = [f"{n:.3f}" if np.isfinite(n) else "" for n in numbers]
    word = {True: "yes", False: "**no**", None: ""}[met]
    return f"| {row.name} | {shown[0]} | {shown[1]} | {shown[2]} | {shown[3]} | {right} | {peer} | {goal} | {word} |"


def growth_line(known: dict[int, list[Record]]) -> str:
    """Time per phase from the shortest to the longest, and memory."""
    times = {k: median(r) / k for k, r in known.items()}
    factor = max(times.values()) / min(times.values())
    memory = ", ".join(f"{median(r, 'megabytes'):.0f} MB at {k}" for k, r in known.items())
    each = ", ".join(f"{1e3 * t:.1f} ms at {k}" for k, t in times.items())
    return f"Growth: CPU per phase {each}: factor {factor:.2f} (goal 2); memory added {memory}."


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", default="", help="regular expression: only rows whose name it matches")
    parser.add_argument("--seeds", type=int, help="seeds per row (5, with --quick 2)")
    parser.add_argument("--quick", action="store_true", help="short rows and few seeds: minutes, not an hour")
    parser.add_argument("--json", type=Path, help="keep the runs in this file and go on from there")
    parser.add_argument("--peer", type=Path, default=PEER, help="the Python that has `robotic`")
    parser.add_argument("--alone", type=int, nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.alone:
        alone(*options.alone)
        return
    seeds = options.seeds or (2 if options.quick else 5)
    peer = Peer(options.peer)
    if peer.missing:
        print(f"no peer ({peer.missing}): see the head of {Path(__file__).name} for how to install it", file=sys.stderr)
    chosen = [r for r in rows(peer, seeds, options.quick) if re.search(options.rows, r.name)]
    store, lines, grown = Store(options.json), [], {}
    warm_up()
    for row in chosen:
        count = max(row.seeds, seeds) if options.seeds is None or row.seeds > 20 else seeds
        mine = [store.get(f"{row.name}|ours|{s}", lambda r=row, s=s: r.ours(s)) for s in range(count)]
        theirs = []
        if row.theirs is not None:
            theirs = [store.get(f"{row.name}|peer|{s}", lambda r=row, s=s: r.theirs(s)) for s in range(seeds)]
        lines.append(line(row, mine, theirs))
        if row.name.startswith("growth"):
            grown[int(row.name.rpartition("=")[2])] = mine
    print(f"{machine()}; seeds 0 to {seeds - 1}; CPU seconds, medians\n")
    print("| row | ours | peer | ratio | cost ratio | ours right | peer right | goal | met |")
    print("|---|---|---|---|---|---|---|---|---|")
    print("\n".join(lines))
    if grown:
        print("\n" + growth_line(grown))


if __name__ == "__main__":
    main()
