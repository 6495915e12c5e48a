"""Claims that tests hold: one-line mutations of a copy of the tree, each of which the tests of its room must find.

    tamplang bench mutants [--only TEXT] [--list] [--seconds S] [--jobs N] [--markdown FILE.md]

The checkout itself is never changed. The tests of a mutation pass on the copy as it is, else nothing is said of it.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

import _runs as bench
from _mutations import MUTATIONS, Mutation

SECONDS = 300.0
"""What the tests of one mutation may take; one that hangs is found too."""


@dataclass(frozen=True, slots=True)
class Outcome:
    mutation: Mutation
    result: str
    """killed, killed (time), survived, or not judged: its tests fail on the tree as it is."""


def copied(folder: Path) -> Path:
    """A copy of what git knows of the tree, with its links."""
    listed = subprocess.run(
        ["git", "-C", str(bench.ROOT), "ls-files", "-z"], capture_output=True, check=True, text=True
    ).stdout
    tree = folder / "tree"
    for name in filter(None, listed.split("\0")):
        place = tree / name
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(bench.ROOT / name, place, follow_symlinks=False)
    return tree


def passes(tree: Path, tests: Sequence[str], seconds: float) -> bool | None:
    """Whether the tests pass in the copy; None when they take too long."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    environment = {
        **os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1",
        "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1",
    }  # fmt: skip
    try:
        done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return None
    return done.returncode == 0


def judge(tree: Path, mutation: Mutation, seconds: float) -> str:
    place = tree / mutation.file
    text = place.read_text(encoding="utf-8")
    if text.count(mutation.old) != 1:
        raise SystemExit(f"{mutation.name}: the old text is {text.count(mutation.old)} times in {mutation.file}")
    place.write_text(text.replace(mutation.old, mutation.new), encoding="utf-8")
    try:
        found = passes(tree, mutation.tests, seconds)
    finally:
        place.write_text(text, encoding="utf-8")
    return {True: "survived", False: "killed", None: "killed (time)"}[found]


def judge_all(tree: Path, tests: Sequence[str], mutations: Sequence[Mutation], seconds: float) -> list[Outcome]:
    """The outcomes of mutations that the same tests must find, one after the other in one copy."""
    sound = passes(tree, tests, seconds) is True
    outcomes = []
    for mutation in mutations:
        outcomes.append(Outcome(mutation, judge(tree, mutation, seconds) if sound else "not judged"))
        print(f"{outcomes[-1].result:14} {mutation.name}", flush=True)
    return outcomes


def run(chosen: Sequence[Mutation], seconds: float, jobs: int) -> list[Outcome]:
    """The outcomes of all, in order; each of `jobs` threads has a copy of its own."""
    groups: dict[tuple[str, ...], list[Mutation]] = {}
    for mutation in chosen:
        groups.setdefault(mutation.tests, []).append(mutation)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(jobs) as pool:
        trees: SimpleQueue[Path] = SimpleQueue()
        for number in range(jobs):
            trees.put(copied(Path(folder) / str(number)))

        def judged(group: tuple[tuple[str, ...], list[Mutation]]) -> list[Outcome]:
            tree = trees.get()
            try:
                return judge_all(tree, *group, seconds)
            finally:
                trees.put(tree)

        found = [outcome for outcomes in pool.map(judged, groups.items()) for outcome in outcomes]
    return sorted(found, key=lambda o: chosen.index(o.mutation))


def head() -> str:
    command = ["git", "-C", str(bench.ROOT), "rev-parse", "--short", "HEAD"]
    return subprocess.run(command, capture_output=True, check=True, text=True).stdout.strip()


def markdown(outcomes: Sequence[Outcome], commit: str) -> str:
    killed = sum(o.result.startswith("killed") for o in outcomes)
    lines = [
        "# Claims that tests hold",
        "",
        f"Made by `tamplang bench mutants --markdown docs/mutants.md`, {bench.today()}, commit {commit}: of "
        f"{len(outcomes)} one-line mutations {killed} are killed by the tests of their room.",
        "",
        "| mutation | file | tests | result |",
        "|---|---|---|---|",
    ]
    for outcome in outcomes:
        m = outcome.mutation
        why = f"; {m.reason}" if m.reason and outcome.result == "survived" else ""
        tests = ", ".join(t.removeprefix("tests/") for t in m.tests if t.startswith("tests/"))
        lines.append(f"| {m.name} | {m.file} | {tests} | {outcome.result}{why} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser("tamplang bench mutants", description=__doc__)
    parser.add_argument("--only", default="", help="the mutations whose name or file contains this")
    parser.add_argument("--list", action="store_true", help="name them only")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="for the tests of one mutation")
    parser.add_argument("--jobs", type=int, default=1, help="how many are judged side by side")
    parser.add_argument("--markdown", type=Path)
    given = parser.parse_args()
    chosen = [m for m in MUTATIONS if given.only in m.name or given.only in m.file]
    if given.list:
        print("\n".join(f"{m.name}: {m.file}" for m in chosen))
        return
    commit = head()
    outcomes = run(chosen, given.seconds, given.jobs)
    killed = sum(o.result.startswith("killed") for o in outcomes)
    print(f"{killed} of {len(outcomes)} killed")
    if given.markdown:
        given.markdown.write_text(markdown(outcomes, commit), encoding="utf-8")


if __name__ == "__main__":
    main()
