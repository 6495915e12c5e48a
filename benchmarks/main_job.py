"""The main job, whole processes: solve with verification, check and --version; wall seconds and peak memory.

    python benchmarks/main_job.py [--seeds 5] [--json FILE]

Prints one Markdown table: per row the median and worst wall time over the seeds, the peak memory of the process, and
whether every plan was verified.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SOLVES = [
    ("climb n=8 crawlers=1", "climb.tamp", {"n": 8, "crawlers": 1}, 10.0),
    ("climb n=8 crawlers=2", "climb.tamp", {"n": 8, "crawlers": 2}, 10.0),
    ("pick_and_place objects=3", "pick_and_place.tamp", {"objects": 3}, 10.0),
]


def run(arguments: list[str]) -> tuple[float, float, int, str]:
    """Wall seconds, peak resident memory in MB, exit status and standard output of one `tamplang` process."""
    started = time.monotonic()
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, "-m", "tamplang", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
    )
    assert process.stdout is not None
    output = process.stdout.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    return time.monotonic() - started, usage.ru_maxrss / 1024, os.waitstatus_to_exitcode(status), output


def solve_row(name: str, file: str, parameters: dict[str, int], seeds: int, goal: float) -> dict[str, object]:
    walls, peaks, lengths, solved = [], [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(seeds):
            arguments = ["solve", str(ROOT / "examples" / file), "--seed", str(seed), "--json"]
            arguments += [f"-p{key}={value}" for key, value in parameters.items()]
            wall, peak, status, output = run([*arguments, "--out", f"{folder}/{seed}.json"])
            answer = json.loads(output) if status == 0 else {}
            solved += bool(answer.get("verified"))
            lengths.append(answer.get("length", 0))
            walls.append(wall)
            peaks.append(peak)
    return {"row": name, "median_s": statistics.median(walls), "worst_s": max(walls), "goal_s": goal,
            "peak_mb": max(peaks), "verified": f"{solved} of {seeds}", "lengths": lengths}


def command_row(name: str, arguments: list[str], seeds: int, goal: float) -> dict[str, object]:
    runs = [run(arguments) for _ in range(seeds + 1)][1:]
    return {"row": name, "median_s": statistics.median(r[0] for r in runs), "worst_s": max(r[0] for r in runs),
            "goal_s": goal, "peak_mb": max(r[1] for r in runs), "verified": "", "lengths": []}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows = [solve_row(name, file, parameters, options.seeds, goal) for name, file, parameters, goal in SOLVES]
    for example in sorted((ROOT / "examples").glob("*.tamp")):
        rows.append(command_row(f"check {example.name}", ["check", str(example)], options.seeds, 0.5))
    rows.append(command_row("--version", ["--version"], options.seeds, 0.2))
    machine = f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    print(f"{machine}, seeds 0 to {options.seeds - 1}\n")
    print("| what | median s | worst s | goal s | peak MB | verified | lengths |")
    print("|---|---|---|---|---|---|---|")
    for r in rows:
        print(f"| {r['row']} | {r['median_s']:.2f} | {r['worst_s']:.2f} | {r['goal_s']} | {r['peak_mb']:.0f} "
              f"| {r['verified']} | {' '.join(map(str, r['lengths']))} |")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=2))


if __name__ == "__main__":
    main()
