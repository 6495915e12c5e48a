"""The command `sweep`: results that do not depend on where they are made, kept through whatever ends a run."""

from __future__ import annotations

import fcntl
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tamplang.cli import run
from tamplang.cli.instances import instances, read_program, solve_instance

from .conftest import CLIMB, ROOT, SMALL, lines, session, start, sweep, sweep_here, timeless, wait_until


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder and the output of a sweep in one process."""
    folder = tmp_path_factory.mktemp("reference")
    return folder, sweep(folder, *SMALL, "--seeds", "0,1", "--plans", "plans")[0]


def test_one_line_and_one_plan_each(reference: tuple[Path, str]) -> None:
    folder, _ = reference
    records = lines(folder / "climb.sweep.jsonl")
    assert {(r["parameters"]["n"], r["seed"]) for r in records} == {(1, 0), (1, 1), (2, 0), (2, 1)}
    assert all(r["status"] == "solved" and r["verified"] and r["length"] >= 2 for r in records)
    assert all(r["cpu_seconds"] > 0 and r["seconds"]["total"] > 0 for r in records)
    assert not {"plan", "plans", "report"} & set(records[0])
    plans = sorted((folder / "plans").iterdir())
    assert [plan.name for plan in plans][:2] == [f"climb-n=1-crawlers=1-seed={seed}.plan.json" for seed in (0, 1)]
    assert len(plans) == 4
    verify = [sys.executable, "-m", "tamplang", "verify", str(plans[0])]
    assert subprocess.run(verify, env={**os.environ, "PYTHONPATH": str(ROOT)}, timeout=60).returncode == 0


def test_the_table(reference: tuple[Path, str]) -> None:
    rows = [line.split() for line in reference[1].splitlines()]
    assert rows[1][:3] == ["n", "crawlers", "solved"]
    assert [row[:5] for row in rows if "%" in row] == [[n, "1", "2/2", "100", "%"] for n in ("1", "2")]


def test_processes_give_the_same_results(reference: tuple[Path, str], tmp_path: Path) -> None:
    sweep(tmp_path, *SMALL, "--seeds", "0,1", "--jobs", 2)
    assert timeless(lines(tmp_path / "climb.sweep.jsonl")) == timeless(lines(reference[0] / "climb.sweep.jsonl"))


def test_a_sweep_goes_on_where_it_ended(reference: tuple[Path, str], tmp_path: Path) -> None:
    whole = (reference[0] / "climb.sweep.jsonl").read_text().splitlines(keepends=True)
    path = tmp_path / "climb.sweep.jsonl"
    path.write_text("".join(whole[:3]) + whole[3][:200])
    out, err = sweep(tmp_path, *SMALL, "--seeds", "0,1", "--json")
    assert "3 instances of 4 stand" in err
    assert "1/1" in err
    assert timeless(lines(path)) == timeless([json.loads(line) for line in whole])
    answer = json.loads(out)
    assert (answer["status"], answer["instances"], answer["solved"]) == ("solved", 4, 4)
    assert [group["parameters"]["n"] for group in answer["groups"]] == ["1", "2"]
    assert all(group["success"] == 1.0 and group["median_seconds"] > 0 for group in answer["groups"])


def test_other_options_are_other_instances_and_what_failed_is_tried_again(tmp_path: Path) -> None:
    path = tmp_path / "climb.sweep.jsonl"
    one = ("-p", "n=1", "-p", "crawlers=1", "--bound", "seq")
    sweep_here(tmp_path, *one)
    (first,) = lines(path)
    path.write_text(json.dumps(first | {"status": "lost"}) + "\n")
    sweep_here(tmp_path, *one)
    assert timeless(lines(path))[0] == timeless([first])[0] | {"status": "lost"}
    assert [r["status"] for r in lines(path)] == ["lost", "solved"]
    sweep_here(tmp_path, *one, "--nodes", 1000)
    sweep_here(tmp_path, *one, "--nodes", 1000, "--time", "inf")
    assert len({r["key"] for r in lines(path)}) == 3


def test_instances_that_cannot_be_solved_are_told(tmp_path: Path) -> None:
    out, err = sweep_here(tmp_path, "-p", "n=1", "-p", "crawlers=0,1", "--bound", "seq", "--json", status=4)
    assert json.loads(out)["status"] == "unsolved"
    assert [group["solved"] for group in json.loads(out)["groups"]] == [0, 1]
    assert "error: " in err or "infeasible" in err


LIT = """predicate (lit)
rule light() { pre not (lit) post (lit) }
task t() { object b: hull("b.obj") at (0, 0, 1 m) goal (lit) }
"""


def test_another_mesh_is_another_program_and_goes_with_the_work(tmp_path: Path) -> None:
    program, mesh, results = tmp_path / "lit.tamp", tmp_path / "b.obj", tmp_path / "t.sweep.jsonl"
    program.write_text(LIT, encoding="utf-8")
    for height in (1, 1, 2):
        corners = f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 {height}\n"
        mesh.write_text(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n", encoding="utf-8")
        assert run(["sweep", str(program), "--out", str(results)]) == 0
    first, second = lines(results)
    assert first["source"] != second["source"] and first["status"] == second["status"] == "solved"
    read = read_program(program, None)
    mesh.unlink()
    (instance,) = instances(read, {}, [0], {}, with_plan=False)
    assert solve_instance(instance)[0]["status"] == "solved"


def test_the_end_of_the_time_is_told_with_a_code(tmp_path: Path) -> None:
    for told in range(2):
        out, err = sweep_here(tmp_path, "-p", "n=64", "--nodes", 1, status=4)
        assert "S0003" in out and ("S0003" in err) == (told == 0)
    out, _ = sweep_here(tmp_path, "-p", "n=64", "--nodes", 1, "--json", status=4)
    assert [group["codes"] for group in json.loads(out)["groups"]] == [{"S0003": 1}]


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_interrupted_sweep_keeps_what_is_finished_and_leaves_no_process(tmp_path: Path, jobs: int) -> None:
    path = tmp_path / "climb.sweep.jsonl"
    with start(tmp_path, *SMALL, "--seeds", "0..99", "--jobs", jobs) as process:
        wait_until(lambda: path.exists() and path.read_text().count("\n") >= 1)
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    wait_until(lambda: not session(process.pid), 10)
    assert {r["status"] for r in lines(path)} == {"solved"}
    assert "left)" in out


def test_a_killed_sweep_leaves_no_process(tmp_path: Path) -> None:
    path = tmp_path / "climb.sweep.jsonl"
    with start(tmp_path, *SMALL, "--seeds", "0..99", "--jobs", 2) as process:
        wait_until(lambda: path.exists() and path.read_text().count("\n") >= 1)
        process.kill()
    wait_until(lambda: not session(process.pid), 20)
    assert lines(path)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["-p", "crawler=1..2"], "did you mean `crawlers`"),
        (["climbs"], "did you mean `climb`"),
        (["--seed", "1"], "--seeds"),
        (["-p", "n=3..1"], "did you mean `1..3`"),
        (["-p", "n=1.."], "no range"),
        (["-p", "n=1,,2"], "missing"),
        (["-p", "n=1,many"], "not a number"),
        (["--seeds", "0..x"], "no range"),
        (["--seeds", "-1"], "no seed"),
        (["--seeds", "0..100000"], "at most 100000 instances"),
        (["-p", "n=1..1000", "--seeds", "0..999"], "at most 100000 instances"),
        (["--jobs", "0"], "--jobs"),
        (["--jobs", "2", "--cluster", "tcp://127.0.0.1:1"], "exclude each other"),
        (["--cluster", "here"], "tcp://HOST:PORT"),
        (["--out", "."], "it is a folder"),
        (["--out", str(CLIMB)], "also the input"),
        (["--out", str(ROOT / "README.md")], "it holds no result"),
        (["--plans", str(CLIMB)], "cannot write"),
    ],
)
def test_bad_input_is_refused_before_the_work(tmp_path: Path, arguments: list[str], word: str) -> None:
    before = CLIMB.read_bytes(), (ROOT / "README.md").read_bytes()
    out, err = sweep_here(tmp_path, *arguments, status=2)
    assert (CLIMB.read_bytes(), (ROOT / "README.md").read_bytes()) == before
    assert out == ""
    assert word in err


def test_errors_of_the_program_end_the_sweep(tmp_path: Path) -> None:
    program = tmp_path / "wrong.tamp"
    program.write_text("task wrong() { goal (held ball) }")
    command = [sys.executable, "-m", "tamplang", "sweep", str(program), "--json"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60)
    assert process.returncode == 1
    assert "wrong.tamp:1" in process.stderr
    assert json.loads(process.stdout)["status"] == "error"
    assert [path.name for path in tmp_path.iterdir()] == ["wrong.tamp"]


def test_a_file_that_another_sweep_writes_is_refused(tmp_path: Path) -> None:
    with open(tmp_path / "x.jsonl", "w") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        _, err = sweep_here(tmp_path, "--out", "x.jsonl", status=2)
    assert "another sweep" in err


def test_a_full_disk_is_told(tmp_path: Path) -> None:
    command = 'ulimit -f 0; trap "" XFSZ; exec "$@"'
    arguments = [sys.executable, "-m", "tamplang", "sweep", str(CLIMB), *SMALL, "--bound", "seq", "--jobs", "2"]
    process = subprocess.run(
        ["bash", "-c", command, "bash", *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert process.returncode == 2, process.stderr
    assert "cannot write" in process.stderr
