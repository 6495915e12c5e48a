"""solve, verify and report on small instances, as files, JSON and exit statuses."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import tamplang as package
from tamplang.runtime.budget import OutOfTime

from .conftest import ROOT, Tamplang, begin, environment

CLIMB = ROOT / "examples" / "climb.tamp"
SMALL = ("solve", CLIMB, "-p", "n=2", "-p", "crawlers=1")
FIELDS = {
    "status": str,
    "actions": list,
    "length": int,
    "optimal": bool,
    "tree_nodes": int,
    "expanded_nodes": int,
    "bounds": dict,
    "cost": float,
    "seconds": dict,
    "verified": bool,
    "worst": dict,
    "plan": str,
    "plans": list,
    "explanation": list,
}
OUT_OF_REACH = """import std.crawler
import std.rules

task far() {
    base ground: box(1 m, 1 m, 0.05 m) at (0, 0, 0)
    base island: box(0.3 m, 0.3 m, 0.05 m) at (9 m, 0, 0)
    object ball: sphere(4 cm) at (9 m, 0, 0.8 m)
    fact (grippable ball)
    crawler c: A on ground
    goal (held ball)
}
"""


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any], str]:
    """The folder, the JSON and the progress of one run."""
    folder = tmp_path_factory.mktemp("solved")
    process = subprocess.run(
        [sys.executable, "-m", "tamplang", *map(str, SMALL), "--json", "--report", "climb.html"],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert process.returncode == 0, process.stderr
    return folder, json.loads(process.stdout), process.stderr


def test_the_json_is_one_object_with_every_field(solved: tuple[Path, dict[str, Any], str]) -> None:
    _, answer, _ = solved
    assert {name: type(answer[name]) for name in FIELDS} == FIELDS
    assert answer["status"] == "solved"
    assert answer["verified"] is True
    assert answer["length"] == len(answer["actions"]) >= 2
    assert {"total", "compile", "search", "seq", "seq_path", "path", "verify"} <= set(answer["seconds"])
    assert all({"solved", "refused"} <= set(bound) for bound in answer["bounds"].values())
    assert {"position_m", "slip_m", "penetration_m", "joint_limit_rad"} <= set(answer["worst"])


def test_the_files_stand(solved: tuple[Path, dict[str, Any], str]) -> None:
    folder, answer, _ = solved
    assert answer["plan"] == "climb.plan.json"
    assert sorted(path.name for path in folder.iterdir()) == ["climb.html", "climb.plan.json"]
    assert "<html" in (folder / "climb.html").read_text(encoding="utf-8")


def test_progress_goes_to_standard_error_in_plain_lines(solved: tuple[Path, dict[str, Any], str]) -> None:
    _, _, progress = solved
    assert "s left" in progress
    assert "\x1b" not in progress


def test_verify_agrees(tamplang: Tamplang, solved: tuple[Path, dict[str, Any], str]) -> None:
    folder, answer, _ = solved
    process = tamplang("verify", folder / "climb.plan.json", "--json")
    assert process.returncode == 0
    verdict = json.loads(process.stdout)
    assert verdict["verified"] is True
    assert verdict["failures"] == []
    assert set(verdict["worst"]) == set(answer["worst"])


def test_verify_refuses_a_bent_plan(
    tamplang: Tamplang, tmp_path: Path, solved: tuple[Path, dict[str, Any], str]
) -> None:
    folder, _, _ = solved
    plan = json.loads((folder / "climb.plan.json").read_text())
    plan["tracks"][0]["joints"][len(plan["times"]) // 2][1] += 0.3
    (tmp_path / "bent.plan.json").write_text(json.dumps(plan))
    process = tamplang("verify", "bent.plan.json", "--json")
    assert process.returncode == 5
    verdict = json.loads(process.stdout)
    assert verdict["verified"] is False
    assert verdict["failures"]


def test_report_draws_a_plan_file(tamplang: Tamplang, tmp_path: Path, solved: tuple[Path, dict[str, Any], str]) -> None:
    folder, _, _ = solved
    process = tamplang("report", folder / "climb.plan.json", "-o", "again.html")
    assert process.returncode == 0, process.stderr
    assert (tmp_path / "again.html").stat().st_size > 100_000
    refused = tamplang("report", folder / "climb.plan.json", "-o", folder / "climb.plan.json")
    assert refused.returncode == 2


@pytest.mark.parametrize("content", [None, b"", b"\x00\xff", b"{}", b"[" * 100_000])
@pytest.mark.parametrize("command", ["verify", "report"])
def test_files_that_are_no_plans(tamplang: Tamplang, tmp_path: Path, command: str, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "x.plan.json").write_bytes(content)
    process = tamplang(command, "x.plan.json", *(["-o", "x.html"] if command == "report" else []))
    assert process.returncode == 1
    assert "x.plan.json" in process.stderr
    assert not (tmp_path / "x.html").exists()


def test_the_seq_bound_gives_actions_without_motion(tamplang: Tamplang) -> None:
    process = tamplang(*SMALL, "--bound", "seq", "--json")
    answer = json.loads(process.stdout)
    assert (process.returncode, answer["status"], answer["plan"]) == (0, "solved", None)
    assert answer["actions"]


def test_several_solutions(tamplang: Tamplang, tmp_path: Path) -> None:
    process = tamplang(*SMALL, "--solutions", "2", "--out", "two.json", "--json")
    answer = json.loads(process.stdout)
    assert process.returncode == 0
    assert answer["plans"] == ["two.json", "two.2.json"]
    assert all((tmp_path / name).is_file() for name in answer["plans"])


def test_a_task_that_cannot_be_solved_says_why(tamplang: Tamplang, tmp_path: Path) -> None:
    (tmp_path / "far.tamp").write_text(OUT_OF_REACH)
    process = tamplang("solve", "far.tamp", "--json", "--time", "20")
    answer = json.loads(process.stdout)
    assert (process.returncode, answer["status"]) in {(3, "infeasible"), (4, "exhausted")}
    assert answer["explanation"]
    assert answer["plan"] is None
    assert not (tmp_path / "far.plan.json").exists()


def test_a_spent_budget(tamplang: Tamplang) -> None:
    process = tamplang("solve", CLIMB, "--time", "0.001", "--json")
    assert (process.returncode, json.loads(process.stdout)["status"]) == (4, "budget")


def test_ctrl_c_ends_with_what_was_found(tmp_path: Path) -> None:
    arguments = ["solve", CLIMB, "-p", "n=30", "--solutions", "1000", "--time", "100", "--json"]
    process = begin(tmp_path, "-m", "tamplang", *arguments)
    assert process.stderr is not None
    process.stderr.readline()
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert json.loads(output)["status"] == "interrupted"


@pytest.mark.parametrize("loaded", ["click", "tamplang.cli.app", "tamplang.runtime.planner.lgp"])
def test_ctrl_c_is_quiet_while_the_command_still_loads(tmp_path: Path, loaded: str) -> None:
    arguments = ["solve", CLIMB, "-p", "n=60", "--solutions", "9"]
    process = begin(tmp_path, "-X", "importtime", "-m", "tamplang", *arguments)
    assert process.stderr is not None
    while loaded not in (line := process.stderr.readline()):
        assert line
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors[-500:]
    assert "Traceback" not in errors


INTERRUPTING = """
import os, signal, sys

class Finder:
    def find_spec(self, name, path, target=None):
        if name == "tamplang.runtime.planner.lgp":
            sys.meta_path.remove(self)
            exec("os.kill(os.getpid(), signal.SIGINT)")

sys.meta_path.insert(0, Finder())
"""
"""Presses Ctrl-C while code runs that is compiled from a string, as that of named tuples is."""


def test_ctrl_c_within_code_from_a_string_has_the_usual_status(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(INTERRUPTING)
    process = begin(tmp_path, "-m", "tamplang", "solve", CLIMB, first=(tmp_path,))
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors[-500:]


def test_verify_ends_with_its_budget(tamplang: Tamplang, tmp_path: Path) -> None:
    result = package.load(CLIMB, n=2, crawlers=1).solve(time=60.0)
    assert result.plan is not None
    result.plan.save(tmp_path / "plan.json")
    process = tamplang("verify", str(tmp_path / "plan.json"), "--time", "0.001")
    assert process.returncode == 4
    assert "S0003" in process.stderr and "there is no verdict" in process.stderr
    with pytest.raises(OutOfTime):
        result.plan.verify(time=0.001)
    assert tamplang("verify", str(tmp_path / "plan.json"), "--time", "nan").returncode == 2


def test_the_starter_task_solves(tamplang: Tamplang) -> None:
    assert tamplang("new", "walk").returncode == 0
    process = tamplang("solve", "walk.tamp")
    assert process.returncode == 0, process.stdout + process.stderr
    assert "walk: solved" in process.stdout


def test_the_python_interface(tmp_path: Path) -> None:
    result = package.load(CLIMB, n=2, crawlers=1).solve(time=60.0)
    assert result.status == "solved"
    plan = result.plan
    assert plan is not None
    assert plan.actions == result.actions
    plan.save(tmp_path / "plan.json")
    again = package.read_plan(tmp_path / "plan.json")
    assert again.verify().verified
    again.report(tmp_path / "plan.html")
    assert (tmp_path / "plan.html").stat().st_size > 100_000


def test_a_goal_that_holds_at_the_start_gives_an_empty_verified_plan(tamplang: Tamplang, tmp_path: Path) -> None:
    process = tamplang("solve", ROOT / "examples" / "pick_and_place.tamp", "-p", "objects=0", "--report", "r.html")
    assert process.returncode == 0
    assert "the goal holds at the start" in process.stdout
    assert "\nverified" in process.stdout
    assert tamplang("verify", "pick_and_place.plan.json").returncode == 0
    assert (tmp_path / "r.html").exists()
