"""The command `run`: exit status, JSON, files, and input that makes no sense."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tamplang.cli import run as command
from tamplang.runtime.plan import read_plan

EXAMPLE = Path(__file__).parents[2] / "examples" / "failing_module.tamp"


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
    assert "Error" in capsys.readouterr().err


def test_a_plan_takes_no_parameters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "missing.json"
    assert command(["run", str(missing)]) == 1
    assert "cannot read" in capsys.readouterr().err
