"""Every solve gets a report, also one that finds nothing."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FAR = """import std.rules
import std.crawler

## Out of <reach>.
task far() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object b: sphere(4 cm) at (0, 0.3 m, 3 m)
    crawler c: A on ground at (0.5 m, 0)
    fact (grippable b)
    goal (held b)
}
"""


def solved(folder: Path, *arguments: str) -> tuple[int, str]:
    """The status of a solve, and the text of its report."""
    done = subprocess.run(
        [sys.executable, "-m", "tamplang", "solve", *arguments, "--report", "page.html"], cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr
    return done.returncode, (folder / "page.html").read_text(encoding="utf-8")


def body(page: str) -> str:
    """The page as it is read, without scripts and styles."""
    return re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.DOTALL)


def test_a_proof_that_there_is_no_plan(tmp_path: Path) -> None:
    (tmp_path / "far.tamp").write_text(FAR)
    status, page = solved(tmp_path, "far.tamp")
    assert status == 3
    text = body(page)
    assert "no plan: proved" in text and 'class="verdict refused"' in text
    assert "1.94 m too little" in text and "never applicable where it would help" in text
    assert "Scene at the start" in text
    assert "Out of &lt;reach&gt;" in text


@pytest.mark.parametrize("more", [("--nodes", "2"), ("--bound", "seq", "--nodes", "2")])
def test_a_search_that_was_not_finished_is_amber(tmp_path: Path, more: tuple[str, ...]) -> None:
    status, page = solved(tmp_path, str(ROOT / "examples" / "climb.tamp"), "-p", "n=4", *more)
    assert status == 4
    text = body(page)
    assert "unfinished" in text and 'class="verdict unfinished"' in text
    assert "S0003" in text


def test_refused_candidates_stand_in_the_report(tmp_path: Path) -> None:
    """The gripper cannot go below the slab on which the ball lies: every candidate is refused by a row."""
    (tmp_path / "shut.tamp").write_text(SHUT)
    status, page = solved(tmp_path, "shut.tamp", "--nodes", "40")
    text = body(page)
    assert status in (3, 4)
    assert "Why there is no plan" in text
    assert re.search(r"grasp\(", text)


SHUT = (
    FAR.replace("far()", "shut()")
    .replace("(0, 0.3 m, 3 m)", "(0, 0.3 m, 7 cm)")
    .replace(
        "    fact (grippable b)",
        "    base lid: box(30 cm, 30 cm, 2 cm) at (0, 0.3 m, 13 cm)\n    fact (grippable b)",
    )
)
