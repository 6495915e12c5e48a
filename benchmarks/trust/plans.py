"""Good plans of all examples: made once, kept in the folder of results, and accepted by verifier and second checker."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .journal import Line, Record, Settings, cpu

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 120.0
"""Seconds for making one plan."""
COUNT = 300


@dataclass(frozen=True, slots=True)
class Instance:
    """A command that makes a plan: `solve` or `run`, a program, a task, and options."""

    command: str
    program: str
    task: str = ""
    options: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        name = Path(self.program).stem if not self.task else self.task
        return " ".join((self.command, name, *self.options))

    def path(self) -> Path:
        folders = ROOT / "examples", Path(__file__).parent / "tasks", ROOT / "tests" / "programs" / "good"
        return next(f / self.program for f in folders if (f / self.program).exists())


def solve(program: str, *options: str) -> Instance:
    return Instance("solve", program, "", options)


BASES = {
    "climb": solve("climb.tamp", "-pn=2"),
    "chain": solve("chain_climb.tamp"),
    "pick": solve("pick_and_place.tamp", "-pobjects=2"),
    "mobile": solve("mobile_manipulator.tamp", "-pobjects=1"),
    "strut": solve("strut_bridge.tamp"),
    "rendezvous": solve("rendezvous.tamp", "-pn=2"),
    "legs": solve("quadruped.tamp"),
    "at_once": solve("quadruped.tamp", "--minimise=makespan"),
    "terraces": solve("terraces.tamp"),
    "horizon": solve("climb.tamp", "-pn=4", "--horizon=2"),
    "stairs": Instance("run", "moving_stairs.tamp"),
    "locked": Instance("run", "failing_module.tamp", "failing_module"),
    "gone": Instance("run", "failing_module.tamp", "leaving_module"),
    "lost": Instance("run", "lost.tamp"),
    "urdf": solve("arm_from_urdf.tamp"),
    "own": solve("own_module.tamp"),
    "tow": solve("tow.tamp"),
}
"""What is tampered with: chains, closed loops, moving scenes, failures, horizons, runs that end early, URDF, loads."""


def instances() -> Iterator[Instance]:
    """All examples with more and more seeds, in turn."""
    for seed in itertools.count():
        s = f"--seed={seed}"
        for n, crawlers in ((1 + seed % 5, 2), (2 + seed % 3, 1)):
            yield solve("climb.tamp", f"-pn={n}", f"-pcrawlers={crawlers}", s)
        yield solve("chain_climb.tamp", s)
        yield solve("pick_and_place.tamp", f"-pobjects={1 + seed % 4}", s)
        yield solve("mobile_manipulator.tamp", f"-pobjects={1 + seed % 2}", s)
        yield solve("strut_bridge.tamp", s)
        yield solve("rendezvous.tamp", f"-pn={1 + seed % 4}", s)
        yield solve("terraces.tamp", s)
        yield solve("climb.tamp", f"-pn={2 + seed % 4}", f"--horizon={1 + seed % 3}", s)
        yield solve("pick_and_place.tamp", f"-pobjects={2 + seed % 3}", f"--horizon={1 + seed % 4}", s)
        yield Instance("run", "failing_module.tamp", "leaving_module", (s,))
        yield Instance("run", "climb.tamp", "climb", (f"-pn={2 + seed % 3}", s))
        if seed % 3 == 0:
            yield solve("quadruped.tamp", s)
            yield Instance("run", "failing_module.tamp", "failing_module", (s,))
            yield Instance("run", "moving_stairs.tamp", "", (s,))


def made(instance: Instance, folder: Path) -> Path | None:
    """The plan file of an instance, made where it is not there yet; None where no plan comes of it."""
    folder.mkdir(parents=True, exist_ok=True)
    name = "".join(c if c.isalnum() else "_" for c in instance.key)
    file = folder / f"{name}.plan.json"
    if not file.exists():
        command = [sys.executable, "-m", "tamplang", instance.command, str(instance.path())]
        command += [instance.task] if instance.task else []
        command += [*instance.options, f"--time={LIMIT}", "--json", "--out", str(file)]
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        answer = subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)
        (folder / f"{name}.answer").write_text(f"{answer.returncode}\n{answer.stdout}\n{answer.stderr}")
    return file if file.exists() else None


def verdict(file: Path, seconds: float | None = None) -> Record:
    """What the verifier says through its public calls: `said` is "verified", "unfinished", "refused", "unreadable",
    "time" or, where it breaks off, "traceback"."""
    from tamplang.api import read_plan
    from tamplang.runtime.budget import OutOfTime
    from tamplang.runtime.plan_files import PlanFileError

    began = cpu()
    why: list[str] = []
    try:
        plan = read_plan(file)
        found = plan.verify(seconds)
        why = [f"{f.kind}: {f.message}"[:160] for f in found.failures[:3]]
        said = "refused" if not found.verified else "verified" if plan.record.complete else "unfinished"
    except PlanFileError as error:
        said, why = "unreadable", [str(error)[:160]]
    except OutOfTime:
        said = "time"
    except Exception as error:
        said, why = "traceback", [f"{type(error).__name__}: {error}"[:300]]
    return {"said": said, "why": why, "cpu": round(cpu() - began, 3)}


def run(settings: Settings) -> list[Line]:
    from .checker import judge

    count = COUNT if settings.count is None else settings.count
    chosen = {i.key: i for i in itertools.islice(instances(), count)}
    journal = settings.journal("plans")

    def measure(key: str) -> Record:
        file = made(chosen[key], settings.folder / "plans")
        if file is None:
            return {"said": "none"}
        findings = judge(json.loads(file.read_text()))
        return {**verdict(file), "findings": [f"{f.kind}: {f.message}"[:200] for f in findings[:5]]}

    records = list(journal.fill(chosen, measure))
    there = [r for r in records if r["said"] != "none"]
    refused = [r["key"] for r in there if r["said"] not in ("verified", "unfinished")]
    doubted = [r["key"] for r in there if r["findings"]]
    for key in [*refused, *doubted]:
        print(f"plans: {key}: {journal.records[key]}", file=sys.stderr)
    what = f"{len(there)} good plans of all examples ({len(records) - len(there)} more were not found in {LIMIT:g} s)"
    result = f"{len(refused)} refused by `verify`, {len(doubted)} by the second checker"
    return [Line("plans", what, result, not refused and not doubted)]
