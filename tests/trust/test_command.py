"""`tamplang bench trust` by the command line: parts, results in a folder, the table, and going on."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def bench(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tamplang", "bench", "trust", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, check=False)


def test_a_part_writes_its_table_and_goes_on(tmp_path: Path) -> None:
    done = bench(tmp_path, "--part", "programs", "--count", "6", "--markdown", "trust.md")
    assert done.returncode == 0, done.stderr
    assert "| programs | 4 mutated programs" in done.stdout and (tmp_path / "trust.md").read_text() == done.stdout
    kept = (tmp_path / "trust-results" / "programs.jsonl").read_text()
    assert len(kept.splitlines()) == 6
    again = bench(tmp_path, "--part", "programs", "--count", "6", "--resume")
    assert again.stdout == done.stdout
    assert (tmp_path / "trust-results" / "programs.jsonl").read_text() == kept


def test_unknown_part_is_refused(tmp_path: Path) -> None:
    done = bench(tmp_path, "--part", "luck")
    assert done.returncode == 2 and "luck" in done.stderr and list(tmp_path.iterdir()) == []
