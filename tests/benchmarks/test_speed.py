"""The benchmark of speed: both builds run every chosen row, and the table tells what came of it."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))


def _bench(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "tamplang", "bench", "speed", "--baseline", sys.executable, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def test_both_builds_run_in_turn_and_are_kept(tmp_path: Path) -> None:
    out, table = tmp_path / "runs.json", tmp_path / "table.md"
    first = _bench(
        "--row", "version", "--row", "check climb", "--runs", "1", "--out", str(out), "--markdown", str(table)
    )
    assert first.returncode == 0, first.stderr
    runs = json.loads(out.read_text())
    assert set(runs) == {"version", "check climb"}
    for builds in runs.values():
        for found in (builds["other"], builds["this"]):
            assert [run["ended"] for run in found] == [1.0] and found[0]["cpu"] > 0 and found[0]["memory"] > 5
    assert "| check climb | " in table.read_text() and "1 of 1 / 1 of 1" in table.read_text()
    assert "seed" not in _bench("--row", "version", "--runs", "1", "--out", str(out)).stderr


def test_a_wrong_row_is_told_with_those_there_are() -> None:
    wrong = _bench("--row", "no such row")
    assert wrong.returncode == 1 and "climb n=4096 (--long)" in wrong.stderr


def test_goals_are_met_by_what_ended_well_alone() -> None:
    from benchmarks.speed.rows import Row
    from benchmarks.speed.table import markdown

    def run(cpu: float, ended: float = 1.0) -> dict[str, float]:
        return {"seed": 0.0, "cpu": cpu, "memory": 100.0, "file": 10.0, "ended": ended, "told": 0.0}

    row = Row("work", (), cpu=0.6)
    for mine, met in (([run(1.0)], "yes"), ([run(1.3)], "no"), ([run(0.1, 0.0)], "no")):
        text = markdown([row], {"work": {"other": [run(2.0)], "this": mine}})
        assert text.splitlines()[8].endswith(f"| CPU ≤ 0.6 | {met} |")
    grown = Row("large", (), growth=("work", 1.3))
    runs = {"work": {"other": [], "this": [run(1.0)]}, "large": {"other": [], "this": [run(1.4)]}}
    assert markdown([row, grown], runs).splitlines()[9].endswith("| ≤ 1.3 times work | no |")


def test_texts_of_the_rows_are_good() -> None:
    from benchmarks.speed.rows import TASKS
    from tamplang.compiler.pipeline import check

    for text in TASKS.glob("*.tamp"):
        assert check(text) == ()
