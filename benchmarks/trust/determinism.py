"""The same plan, byte by byte but for its timing, whatever the hash seed, threads, jobs, and load of the machine."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .journal import Line, Record, Settings
from .plans import LIMIT, ROOT

TASKS = {
    "climb": ("climb.tamp", "-pn=3"),
    "chain": ("chain_climb.tamp",),
    "pick": ("pick_and_place.tamp", "-pobjects=2"),
    "strut": ("strut_bridge.tamp",),
    "rendezvous": ("rendezvous.tamp", "-pn=2"),
    "horizon": ("climb.tamp", "-pn=4", "--horizon=2"),
    "loads": ("real_bridge.tamp",),
}
WAYS: dict[str, tuple[dict[str, str], tuple[str, ...], int]] = {
    "hash seed 0": ({"PYTHONHASHSEED": "0"}, (), 0),
    "hash seed 1": ({"PYTHONHASHSEED": "1"}, (), 0),
    "hash seed by chance": ({"PYTHONHASHSEED": "random"}, (), 0),
    "two threads": ({"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "MKL_NUM_THREADS": "2"}, (), 0),
    "two jobs": ({}, ("--jobs=2",), 0),
    "loaded machine": ({}, (), 2),
}
"""Environment, options, and processes that keep the machine busy meanwhile."""


@contextmanager
def _busy(count: int) -> Iterator[None]:
    others = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()


def plan_of(task: str, way: str, seed: int) -> str | None:
    """The plan file but for `timing`, as text; None where there is none."""
    environment, options, load = WAYS[way]
    program, *parameters = TASKS[task]
    if "--jobs=2" in options and any(p.startswith("--horizon") for p in parameters):
        options = ()
    with tempfile.TemporaryDirectory() as folder, _busy(load):
        file = Path(folder) / "plan.json"
        command = [sys.executable, "-m", "tamplang", "solve", str(ROOT / "examples" / program), *parameters, *options]
        command += [f"--seed={seed}", f"--time={LIMIT}", "--out", str(file)]
        one = {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        settings = {**os.environ, **one, **environment}
        subprocess.run(command, capture_output=True, cwd=folder, env=settings, check=False)
        if not file.exists():
            return None
        plan = json.loads(file.read_text(encoding="utf-8"))
    plan.pop("timing", None)
    return json.dumps(plan, ensure_ascii=False)


def differing(one: str, other: str) -> list[str]:
    """The top-level fields in which two plans differ; the order of fields counts, too."""
    first, second = json.loads(one), json.loads(other)
    fields = [k for k in {**first, **second} if json.dumps(first.get(k)) != json.dumps(second.get(k))]
    return fields or ["order"] * (one != other)


def run(settings: Settings) -> list[Line]:
    tasks = list(TASKS)[: settings.count]
    journal = settings.journal("determinism")
    first: dict[str, str | None] = {}

    def measure(key: str) -> Record:
        task, way = key.split("/")
        if task not in first:
            first[task] = plan_of(task, "hash seed 0", settings.seed)
        found, wanted = plan_of(task, way, settings.seed), first[task]
        if found is None or wanted is None:
            return {"made": False, "differs": []}
        return {"made": True, "differs": differing(wanted, found)}

    records = list(journal.fill([f"{task}/{way}" for task in tasks for way in WAYS], measure))
    other = [r for r in records if r["differs"] or not r["made"]]
    for record in other:
        print(f"determinism: {record}", file=sys.stderr)
    what = f"{len(tasks)} tasks, each {len(WAYS)} times: {', '.join(WAYS)}"
    return [Line("determinism", what, f"{len(other)} plans that are not the same, byte by byte", not other)]
