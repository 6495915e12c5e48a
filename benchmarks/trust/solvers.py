"""Our solver and IPOPT on small random skeletons: where they disagree on whether a motion exists."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from random import Random

from .journal import Line, Record, Settings
from .plans import ROOT

COUNT = 200
SECONDS = 60.0
SOLVERS = ("algn", "ipopt")
TEXT = """import std.crawler
import std.rules

# One skeleton: the rules leave one way only.
task skeleton() {{
    base ground: box(1 m, 1 m, 5 cm) at (0, 0, 0)
    {things}
    crawler({size:.3f} m) c: A on ground at (0.3 m, {side:.3f} m) heading {heading:.1f} deg
    goal {goal}
    options {{ bound = path, margin = {margin} }}
}}
"""


def program(chance: Random) -> str:
    """A crawler with one to three actions to do, some too far, too tight or too low to be done."""
    size = chance.uniform(0.7, 1.1)
    things, goal = [], []
    x = 0.0
    if chance.random() < 0.6:
        for i in range(1, chance.choice([1, 2, 2]) + 1):
            x += chance.uniform(0.4, 0.9)
            z = chance.uniform(-0.1, 0.45)
            y = chance.uniform(-0.2, 0.2)
            things.append(f"base stair[{i}]: box(30 cm, {chance.uniform(0.07, 0.5):.3f} m, 5 cm)"
                          f" at ({0.4 + x:.3f} m, {y:.3f} m, {z:.3f} m)")  # fmt: skip
        goal.append(f"exists A: gripper {{ (on stair[{len(things)}] A) }}")
    if not goal or chance.random() < 0.4:
        reach = chance.uniform(0.5, 1.5) * size
        at = f"{0.3 + x + reach * 0.6:.3f} m, {chance.uniform(-0.3, 0.3):.3f} m, {0.75 * reach:.3f} m"
        things.append(f"object ball: sphere({chance.uniform(0.02, 0.06):.3f} m) at ({at})")
        things.append("fact (grippable ball)")
        goal.append("(held ball)")
    if chance.random() < 0.4:
        things.append(f"object wall: box(3 cm, 60 cm, {chance.uniform(0.1, 0.5):.3f} m) at (0.62 m, 0, 0.3 m)")
    return TEXT.format(
        things="\n    ".join(things), size=size, side=chance.uniform(-0.2, 0.2), heading=chance.uniform(-90, 90),
        goal=" and ".join(goal), margin=chance.choice(["0", "5 mm", "1 cm"]),
    )  # fmt: skip


def answer(text: str, solver: str, folder: Path) -> Record:
    file = folder / "skeleton.tamp"
    file.write_text(text, encoding="utf-8")
    command = [
        sys.executable,
        "-m",
        "tamplang",
        "solve",
        str(file),
        f"--solver={solver}",
        f"--time={SECONDS}",
        "--json",
    ]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)
    try:
        said = json.loads(done.stdout)
    except ValueError:
        return {"status": f"exit {done.returncode}", "actions": [], "why": done.stderr[-300:]}
    told = said.get("explanation") or said.get("diagnostics") or []
    why = [f"{d.get('code', '')} {d.get('message', '')}".strip()[:160] for d in told][:3]
    return {"status": said["status"], "actions": said.get("actions"), "verified": said.get("verified"), "why": why}


def explained(found: Record) -> str:
    """Why two answers differ, as far as they tell: the budget, another way of the same task, or what refused one."""
    ours, theirs = (found[s] for s in SOLVERS)
    for name, one in zip(SOLVERS, (ours, theirs), strict=True):
        if one["status"] == "budget":
            return f"{name} spends its {SECONDS:g} s"
    lacking, name = (ours, "algn") if ours["status"] != "solved" else (theirs, "ipopt")
    return f"{name}: {lacking['status']}, " + ("; ".join(lacking["why"]) or "without a reason")


def run(settings: Settings) -> list[Line]:
    count = COUNT if settings.count is None else settings.count
    journal = settings.journal("solvers")

    def measure(key: str) -> Record:
        text = program(Random(f"{settings.seed} {key}"))
        with tempfile.TemporaryDirectory() as folder:
            found = {solver: answer(text, solver, Path(folder)) for solver in SOLVERS}
        return {**found, "text": text}

    records = list(journal.fill([f"skeleton {n}" for n in range(count)], measure))
    solved = {s: [r for r in records if r[s]["status"] == "solved"] for s in SOLVERS}
    apart = [r for r in records if (r["algn"]["status"] == "solved") != (r["ipopt"]["status"] == "solved")]
    refused = [r for r in records if all(r[s]["status"] == "error" and r[s]["why"] for s in SOLVERS)]
    broken = [
        r for r in records
        if r not in refused and any(r[s]["status"].startswith(("exit", "error", "refused")) for s in SOLVERS)
    ]  # fmt: skip
    for record in [*apart, *refused, *broken]:
        print(f"solvers: {record['key']}: {explained(record)}", file=sys.stderr)
    mine = len([r for r in apart if r["algn"]["status"] == "solved"])
    what = f"{len(records)} small random skeletons, our solver and IPOPT"
    result = f"{len(solved['algn'])} and {len(solved['ipopt'])} solved, {len(refused)} are no tasks"
    differ = f"{len(apart)} disagreements, all listed: {mine} only ours solves, {len(apart) - mine} only IPOPT"
    return [Line("solvers", what, f"{result}; {differ}", not broken)]
