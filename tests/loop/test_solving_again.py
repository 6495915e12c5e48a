"""The same task again in one process: what was found before is found again, and nothing else is."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tamplang.api import load
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.bounds.kept_answers import KEPT, KeptAnswers
from tamplang.runtime.planner.bounds.requests import Question
from tamplang.runtime.planner.bounds.settings import BOUNDS
from tamplang.runtime.skeleton import Skeleton

CLIMB = Path(__file__).resolve().parents[2] / "examples" / "climb.tamp"
FRESH = """
import sys
from tamplang.api import load
for height, out in ((1, sys.argv[2]), (2, sys.argv[3])):
    load(sys.argv[1], n=height, crawlers=1).solve().plan.save(out)
"""


def plan(file: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(file.read_text())
    del found["timing"]
    return found


def solved(height: int, file: Path) -> dict[str, Any]:
    result = load(CLIMB, n=height, crawlers=1).solve()
    assert result.plan is not None
    result.plan.save(file)
    return plan(file)


def test_what_is_kept_changes_no_plan(tmp_path: Path) -> None:
    fresh = [tmp_path / f"fresh{n}.json" for n in (1, 2)]
    subprocess.run([sys.executable, "-c", FRESH, CLIMB, *fresh], check=True)
    first, other = (solved(n, tmp_path / "plan.json") for n in (2, 1))
    known = len(KEPT)
    again = solved(2, tmp_path / "plan.json")
    assert first == plan(fresh[1]) and other == plan(fresh[0])
    assert again == first and len(KEPT) == known


@dataclass(frozen=True)
class Large(Question[bytes]):
    """A question with a long answer."""

    number: int
    size: int

    def solved(self, skeleton: Skeleton, budget: Budget) -> bytes:
        return bytes(self.size)


def test_what_is_kept_is_bounded() -> None:
    skeleton, kept = Skeleton(load(CLIMB, n=1).problem, (), frozenset()), KeptAnswers()
    size = BOUNDS.largest_answer - 1000
    questions = [Large(number, size) for number in range(BOUNDS.kept_answers // size + 2)]
    for question in [Large(-1, BOUNDS.largest_answer), *questions]:
        kept.keep(skeleton, question, question.solved(skeleton, Budget(None)))
    there = [q.number for q in (Large(-1, BOUNDS.largest_answer), *questions) if kept.answer(skeleton, q) is not None]
    assert there == [q.number for q in questions[-len(kept) :]] and len(kept) == BOUNDS.kept_answers // size


def test_a_text_compiled_before_is_verified_as_anew(tmp_path: Path) -> None:
    (tmp_path / "task.tamp").write_text(CLIMB.read_text())
    plan = load(tmp_path / "task.tamp", n=1, crawlers=1).solve().plan
    assert plan is not None
    first = plan.verify()
    for height in range(2, 8):
        load(CLIMB, n=height)
    assert plan.verify() == first
    assert {r.place.file for r in first.residuals if r.place is not None} <= {s.path for s in plan.record.task.sources}
