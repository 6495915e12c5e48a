"""The command `run`: exit status, JSON, files, and input that makes no sense."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path

import pytest

from tamplang.cli import run as command
from tamplang.runtime.plan_files import read_plan

from .conftest import begin

EXAMPLES = Path(__file__).parents[2] / "examples"
EXAMPLE = EXAMPLES / "failing_module.tamp"


def test_a_run_and_its_plan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, report = tmp_path / "p.json", tmp_path / "p.html"
    arguments = ["run", str(EXAMPLE), "leaving_module", "-p", "n=1", "--json", "--out", str(out)]
    assert command([*arguments, "--report", str(report)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["status"] == "solved" and told["verified"] and told["complete"]
    assert told["replans"] == len(told["windows"]) - 1 >= 1
    assert 0.0 < told["latency"]["median"] <= told["latency"]["worst"]
    assert told["deviations"]["switch"] < 0.01
    assert "planning-title" in report.read_text(encoding="utf-8")
    assert read_plan(out).breakdowns[0].kind == "gone"
    assert read_plan(out).statistics.cost > 0.0

    assert command(["verify", str(out)]) == 0
    capsys.readouterr()
    assert command(["run", str(out), "--out", str(tmp_path / "again.json"), "--noise", "drive=3"]) == 0
    assert "joints off by" in capsys.readouterr().out
    assert read_plan(tmp_path / "again.json").tracks == read_plan(out).tracks


@pytest.mark.parametrize(
    "arguments",
    [
        ["--horizon", "0"],
        ["--horizon", "-2"],
        ["--noise", "wind=1"],
        ["--noise", "joint=-1"],
        ["--noise", "joint"],
        ["-p", "n=no"],
    ],
)
def test_options_that_make_no_sense(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["run", str(EXAMPLE), "leaving_module", *arguments]) == 2
    assert "error" in capsys.readouterr().err.lower()


def test_a_plan_takes_no_parameters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "missing.json"
    assert command(["run", str(missing)]) == 1
    assert "cannot read" in capsys.readouterr().err


@pytest.mark.parametrize("kept", [0, 2000])
def test_a_truncated_plan_is_no_plan(tmp_path: Path, kept: int, capsys: pytest.CaptureFixture[str]) -> None:
    whole = tmp_path / "whole.json"
    assert command(["solve", str(EXAMPLES / "climb.tamp"), "-p", "n=2", "-p", "crawlers=1", "--out", str(whole)]) == 0
    cut = tmp_path / "cut.json"
    cut.write_bytes(whole.read_bytes()[:kept])
    capsys.readouterr()
    assert command(["run", str(cut), "--out", str(tmp_path / "out.json")]) == 1
    assert "cut.json is not a plan file" in capsys.readouterr().err
    assert not (tmp_path / "out.json").exists()


@pytest.mark.parametrize("option", ["--out", "--report"])
def test_a_folder_that_is_not_there_is_told_before_the_run(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["run", str(EXAMPLE), "leaving_module", option, "no/such/folder/file"]) == 2
    told = capsys.readouterr().err
    assert "cannot write no/such/folder/file: there is no folder no/such/folder" in told and "planning" not in told


@pytest.mark.parametrize(
    ("arguments", "seen"),
    [
        (["run", EXAMPLES / "moving_stairs.tamp", "-p", "n=8"], r"[1-9]\d* done"),
        (["solve", EXAMPLES / "climb.tamp", "-p", "n=100", "--horizon", "2"], r"[1-9]\d* actions done"),
    ],
)
def test_ctrl_c_in_mid_run_writes_what_was_carried_out(tmp_path: Path, arguments: list[object], seen: str) -> None:
    process = begin(tmp_path, "-m", "tamplang", *arguments, "--out", "p.json", "--report", "p.html")
    assert process.stderr is not None
    while not re.search(seen, line := process.stderr.readline()):
        assert line
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 130 and "Traceback" not in errors
    assert "interrupted" in output and "the goal " in output and "motion verified, goal not reached: (" in output
    plan = read_plan(tmp_path / "p.json")
    assert plan.phases and not plan.complete and plan.verdict is not None and plan.verdict.verified
    assert (tmp_path / "p.html").stat().st_size > 100_000
    assert command(["verify", str(tmp_path / "p.json")]) == 6


def test_a_quiet_run_tells_its_objective_and_nothing_on_the_way(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arguments = ["run", str(EXAMPLES / "climb.tamp"), "-p", "n=1", "-p", "crawlers=1", "--quiet", "--json"]
    assert command([*arguments, "--minimise", "travel + makespan", "--out", str(tmp_path / "r.json")]) == 0
    told, on_the_way = capfd.readouterr()
    objective = json.loads(told)["objective"]
    assert on_the_way == "" and objective["minimise"] == "makespan + travel"
    assert objective["value"] == pytest.approx(sum(objective["measures"].values()))
    assert command([*arguments, "--minimise", "energy", "--out", str(tmp_path / "e.json")]) == 2
    assert "E0524" in capfd.readouterr().err and not (tmp_path / "e.json").exists()
