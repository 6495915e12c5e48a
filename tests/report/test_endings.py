"""Every solve gets a report, also one that finds nothing."""

from __future__ import annotations

import base64
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
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
        [sys.executable, "-m", "tamplang", "solve", *arguments, "--report", "page.html", "--time", "110"], cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr
    return done.returncode, (folder / "page.html").read_text(encoding="utf-8")


def body(page: str) -> str:
    """The page as it is read, without scripts and styles."""
    return re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.DOTALL)


def drawn(page: str) -> dict[str, Any]:
    """What the player gets."""
    found = re.search(r'<script type="application/json" id="replay-data">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    shown: dict[str, Any] = json.loads(found[1])
    return shown


def test_a_proof_that_there_is_no_plan(tmp_path: Path) -> None:
    (tmp_path / "far.tamp").write_text(FAR)
    status, page = solved(tmp_path, "far.tamp")
    assert status == 3
    text = body(page)
    assert "no plan: proved" in text and 'class="verdict refused"' in text
    assert "1.94 m too little" in text and "never applicable where it would help" in text
    assert ">Show where that is</button>" in text
    (start, far) = drawn(page)["marks"]
    assert start == [[], []] and far[1] == ["ground", "b"], "what is too far from what"
    assert "Out of &lt;reach&gt;" in text
    assert text.index("--&gt; far.tamp:10:10") < text.index("a rule that achieves it"), "the goal comes first"


def test_files_are_called_as_on_any_machine(tmp_path: Path) -> None:
    scene = FAR.replace("box(2 m, 2 m, 5 cm)", "box(1 m, 1 m, 10 cm)").replace("at (0.5 m, 0)", "at (0, 0)")
    scene = scene.replace("sphere(4 cm) at (0, 0.3 m, 3 m)", "cylinder(3 cm, 10 cm) at (1.2 m, 0, 0.97 m)")
    (tmp_path / "up.tamp").write_text(scene)
    status, page = solved(tmp_path, str(tmp_path / "up.tamp"))
    assert status == 4 and "`b` is put here" in body(page)
    assert "::: up.tamp:7:5" in body(page) and str(tmp_path) not in body(page)


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
    shown = drawn(page)
    overlaps = [mark for mark, phase in zip(shown["marks"], shown["phases"], strict=True) if "overlap" in phase[2]]
    assert overlaps and all(len(paths) == 2 and not apart for paths, apart in overlaps), "the two that would overlap"
    assert re.search(r"grasp\(", text)


def test_the_nearest_posture_is_drawn_with_the_joints_that_would_have_to_go_on(tmp_path: Path) -> None:
    """The arm leans to the ball as far as its joints go, and dots show what is missing."""
    (tmp_path / "stiff.tamp").write_text(STIFF)
    status, page = solved(tmp_path, "stiff.tamp")
    assert status == 4 and "Nearest postures" in body(page)
    shown = drawn(page)
    (second,) = [k for k, phase in enumerate(shown["phases"]) if "grasp(c.B, b)" in phase[2]]
    assert "past the limit" in shown["phases"][second][2]
    paths, apart = shown["marks"][second]
    assert apart == ["c.B", "b"] and {"module0/frame2", "module0/frame3"} <= set(paths), "what j2 and j3 move"
    joints = np.frombuffer(base64.b64decode(shown["joints"][0]), "<f4").reshape(len(shown["phases"]), 3)
    assert np.allclose(np.abs(joints[second, 1:]), np.radians(20.0), atol=1e-2), "both bend as far as they may"
    text = body(page)
    assert text.count(">Show the nearest posture</button>") == text.count('class="posture"') - 1 >= 1


STIFF = """import std.rules
module stiff {
    effector A: gripper sphere(0.05 m) normal (0, 0, -1)
    joint j1: revolute(z) in -3.1 rad .. 3.1 rad
    link 0.3 m: capsule(0.04 m)
    joint j2: revolute(y) in -20 deg .. 20 deg
    link 0.3 m: capsule(0.04 m)
    joint j3: revolute(y) in -20 deg .. 20 deg
    link 0.3 m: capsule(0.04 m)
    effector B: gripper sphere(0.05 m)
    fact (linked A B)
}
task stiff() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object b: sphere(4 cm) at (0, 0.5 m, 30 cm)
    stiff c: A on ground at (0, 0)
    fact (grippable b)
    goal (held b)
}
"""
SHUT = (
    FAR.replace("far()", "shut()")
    .replace("(0, 0.3 m, 3 m)", "(0, 0.3 m, 7 cm)")
    .replace(
        "    fact (grippable b)",
        "    base lid: box(30 cm, 30 cm, 2 cm) at (0, 0.3 m, 13 cm)\n    fact (grippable b)",
    )
)
