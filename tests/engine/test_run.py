"""Runs whose world is MuJoCo."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tamplang.api import Task
from tamplang.compiler.pipeline import compile_problem, compile_text

from .test_simulate import TEXT

ROOT = Path(__file__).resolve().parents[2]


def run(grip: str, drive: str = "60 N m", physics: str = "dynamics") -> object:
    return Task(*compile_text(TEXT.format(drive=drive, grip=grip, physics=physics), "t.tamp")).run(
        engine="mujoco", horizon=1, time=60.0
    )


def test_windows_are_carried_out_by_the_engine_and_the_goal_holds() -> None:
    result = run("200 N")
    assert result.status == "solved" and result.record.verdict.verified and result.replans >= 1
    carried = result.carried
    assert carried is not None and carried.seconds > result.record.times[-1] and not carried.broken
    assert 0.0 < carried.tracking < 5e-3 and carried.base < 1e-2
    assert max(j.worst for j in result.deviations.joints) == pytest.approx(carried.tracking, rel=0.5)


def test_what_gives_way_ends_the_run() -> None:
    weak = run("4 N", physics="none")
    assert weak.status == "stuck" and [d.code for d in weak.explanation] == ["S0016"]
    assert "item gave way" in weak.explanation[0].message and weak.carried.broken[0][2] > 1.0
    lost = run("200 N", drive="6 N m", physics="none")
    assert lost.status == "stuck" and [d.code for d in lost.explanation] == ["S0016"]
    assert "from where the run has it" in lost.explanation[0].message


def test_without_the_engine_or_in_a_scene_that_moves_it_is_told(tmp_path: Path) -> None:
    def told(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", f"{code}from tamplang.__main__ import main; main()", "run", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)

    (tmp_path / "t.tamp").write_text(TEXT.format(drive="60 N m", grip="200 N", physics="none"))
    missing = told("import sys; sys.modules['mujoco'] = None; ", "t.tamp", "--engine", "mujoco")
    assert missing.returncode == 1 and "S0012" in missing.stderr and "tamplang[sim]" in missing.stderr
    moving = told("", str(ROOT / "examples" / "moving_stairs.tamp"), "--engine", "mujoco")
    assert moving.returncode == 2 and "move by themselves" in moving.stderr and "Traceback" not in moving.stderr


def test_a_hand_moves_what_has_no_drive() -> None:
    result = Task(*compile_problem(ROOT / "examples" / "mechanisms.tamp", "drawer")).run(engine="mujoco", time=60.0)
    assert result.status == "solved" and ("d", "slide") not in result.carried.peaks
    assert result.carried.tracking < 5e-3 and any(p.rule == "pullOut" for p in result.record.phases)
