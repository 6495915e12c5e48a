"""`solve --horizon` from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from tamplang.cli.solve import solve
from tamplang.runtime.plan_files import read_plan
from tamplang.runtime.verify import verify

SLOTS = Path(__file__).parent / "slots.tamp"


@pytest.mark.parametrize("horizon", ["0", "-3", "two", "1.5", ""])
def test_what_is_no_horizon_is_told(horizon: str) -> None:
    result = CliRunner().invoke(solve, [str(SLOTS), f"--horizon={horizon}"])
    assert result.exit_code == 2
    assert "is no horizon" in result.output and "auto" in result.output


@pytest.mark.parametrize("other", [["--solutions", "2"], ["--bound", "seq"], ["--jobs", "2"]])
def test_what_does_not_go_with_a_horizon_is_told(other: list[str]) -> None:
    result = CliRunner().invoke(solve, [str(SLOTS), "--horizon", "2", *other])
    assert result.exit_code == 2 and "--horizon" in result.output


def test_a_run_writes_one_plan_with_its_windows(tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    arguments = [str(SLOTS), "--horizon", "2", "--out", str(out), "--json"]
    result = CliRunner().invoke(solve, arguments, standalone_mode=False)
    answer = json.loads(result.stdout)
    assert answer["status"] == "solved" and answer["verified"] and answer["length"] == 4
    assert answer["seconds"]["first_motion"] < answer["seconds"]["total"]
    plan = read_plan(out)
    assert [window.motions for window in plan.windows] == [2, 2]
    assert plan.complete and verify(plan).verified


def test_time_that_ends_in_mid_run_keeps_the_windows_that_stand(tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    arguments = [str(SLOTS), "-p", "objects=5", "-p", "length=0.6 m", "--horizon", "1", "--out", str(out), "--json"]
    result = CliRunner().invoke(solve, [*arguments, "--time", "0.6"], standalone_mode=False)
    answer = json.loads(result.stdout)
    assert answer["status"] == "budget" and answer["explanation"][0]["code"] == "S0003"
    if answer["plan"] is not None:
        plan = read_plan(out)
        assert not plan.complete and plan.phases and verify(plan).verified
