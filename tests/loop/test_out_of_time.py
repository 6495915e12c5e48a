"""What is left to do when the time ends late: at the verifier, or with the report."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from tamplang.api import load
from tamplang.cli import run as command
from tamplang.runtime.planner.lgp import Progress
from tamplang.runtime.simulation.results import RunProgress

ROOT = Path(__file__).parents[2]
SLOTS = ROOT / "tests" / "horizon" / "slots.tamp"
LEAVING = ROOT / "examples" / "failing_module.tamp"
MANIPULATOR = ROOT / "examples" / "mobile_manipulator.tamp"
CLIMB = ROOT / "examples" / "climb.tamp"
LATE = 1e6


class Clock:
    """The clock of the machine, which may jump."""

    def __init__(self) -> None:
        self.late = 0.0
        self._real = time.monotonic

    def __call__(self) -> float:
        return self._real() + self.late

    def at_verifier(self, progress: Progress) -> None:
        if progress.stage == "verify":
            self.late = LATE

    def in_run(self, progress: RunProgress) -> None:
        if progress.done:
            self.late = LATE


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(time, "monotonic", made)
    return made


@pytest.mark.parametrize("horizon", [None, 2])
def test_a_plan_without_time_for_the_verifier_is_not_called_verified(clock: Clock, horizon: int | None) -> None:
    result = load(SLOTS).solve(horizon=horizon, time=1000.0, progress=clock.at_verifier)
    assert clock.late and result.status == "budget" and result.plan is None
    assert result.refused is not None and result.refused.record.verdict is None
    assert [d.code for d in result.explanation] == ["S0011"]


def test_a_run_without_time_for_the_verifier_is_not_called_verified(clock: Clock) -> None:
    result = load(LEAVING, "leaving_module", n=1).run(time=1000.0, progress=clock.in_run)
    assert clock.late and result.status == "budget" and result.record.phases
    assert result.record.verdict is None and [d.code for d in result.explanation] == ["S0003", "S0011"]


@pytest.mark.parametrize("horizon", [None, 2])
@pytest.mark.parametrize("call", [0, 2, 4])
def test_every_end_by_time_is_told_with_a_code(clock: Clock, horizon: int | None, call: int) -> None:
    calls = iter(range(1000))

    def late(progress: Progress) -> None:
        clock.late = LATE if next(calls) >= call and progress.stage != "verify" else clock.late

    result = load(SLOTS).solve(horizon=horizon, time=1000.0, progress=late)
    assert clock.late and result.status == "budget"
    assert result.explanation[0].code in ("S0003", "S0011")


def test_the_time_may_end_after_refusals(clock: Clock) -> None:
    def late(progress: Progress) -> None:
        clock.late = LATE if progress.candidates > 1 else 0.0

    result = load(MANIPULATOR, height="2 m", objects=1).solve(time=1000.0, progress=late)
    assert result.status == "budget" and {d.code for d in result.explanation[1:]} == {"S0002"}
    assert result.explanation[0].code == "S0003" and "refusals" in result.explanation[0].message


def test_the_end_of_a_run_is_told_with_a_code(clock: Clock) -> None:
    def late(progress: RunProgress) -> None:
        clock.late = LATE

    result = load(LEAVING, "leaving_module", n=1).run(time=1000.0, progress=late)
    assert result.status == "budget" and not result.record.phases and result.explanation[0].code == "S0003"


def test_a_plan_that_is_carried_out_is_verified_in_time() -> None:
    task = load(SLOTS)
    plan = task.solve(time=1000.0).plan
    assert plan is not None
    result = task.run(plan=plan.record, time=1e-6)
    assert (result.status, result.record.verdict) == ("budget", None)
    assert [d.code for d in result.explanation] == ["S0011"]


def test_a_report_for_which_there_is_no_time_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, report, real = tmp_path / "plan.json", tmp_path / "plan.html", time.monotonic
    monkeypatch.setattr(time, "monotonic", lambda: real() + LATE * plan.exists())
    arguments = ["solve", str(CLIMB), "-p", "n=2", "-p", "crawlers=1", "--time", "1000"]
    assert command([*arguments, "--out", str(plan), "--report", str(report)]) == 0
    told = capsys.readouterr()
    assert "S0003" in told.err and f"before the report {report} was written" in told.err and "report:" not in told.out
    assert plan.exists() and not report.exists()
