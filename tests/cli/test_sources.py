"""check, fmt, explain and new on good and bad files."""

from __future__ import annotations

import json
import resource
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import ROOT, Tamplang

Program = Callable[..., Path]

MISTAKES = """import std.logic
import std.rules

task t() {
    base ground: box(1 m, 1 m, 0.05 m) at (0, 0, 0)
    fact (gripable ground)
    goal (held grund)
}
"""


@pytest.mark.parametrize("example", sorted((ROOT / "examples").glob("*.tamp")), ids=lambda p: p.stem)
def test_examples_are_clean(tamplang: Tamplang, example: Path) -> None:
    process = tamplang("check", example)
    assert process.returncode == 0, process.stdout + process.stderr


def test_all_errors_of_a_file_in_one_run(tamplang: Tamplang, program: Program) -> None:
    process = tamplang("check", program(MISTAKES))
    assert process.returncode == 1
    for expected in ("E0103", "grippable", "program.tamp:6:11", "program.tamp:7:16", "ground"):
        assert expected in process.stdout


def test_concise_is_one_line_per_diagnostic(tamplang: Tamplang, program: Program) -> None:
    process = tamplang("check", "--format", "concise", program(MISTAKES))
    lines = process.stdout.splitlines()
    assert process.returncode == 1
    assert len(lines) >= 2
    assert all("program.tamp:" in line for line in lines)


def test_json_and_sarif(tamplang: Tamplang, program: Program) -> None:
    path = program(MISTAKES)
    process = tamplang("check", "--format", "json", path)
    assert process.returncode == 1
    diagnostics = json.loads(process.stdout)
    assert {"E0103"} <= {d["code"] for d in diagnostics}
    process = tamplang("check", "--format", "sarif", path)
    assert process.returncode == 1
    sarif = json.loads(process.stdout)
    assert sarif["version"] == "2.1.0"
    assert "E0103" in {result["ruleId"] for result in sarif["runs"][0]["results"]}


def test_several_files_are_all_checked(tamplang: Tamplang, program: Program) -> None:
    bad = program(MISTAKES, "bad.tamp")
    other = program(MISTAKES, "other.tamp")
    process = tamplang("check", "--format", "concise", bad, ROOT / "examples" / "climb.tamp", other)
    assert process.returncode == 1
    assert "bad.tamp:6" in process.stdout
    assert "other.tamp:6" in process.stdout


@pytest.mark.parametrize(
    "content",
    [None, b"", bytes(range(256)) * 40, b"# a long comment\n" * 700_000],
    ids=["missing", "empty", "binary", "large"],
)
@pytest.mark.parametrize("command", ["check", "solve", "fmt", "compile"])
def test_files_that_are_no_programs(tamplang: Tamplang, tmp_path: Path, command: str, content: bytes | None) -> None:
    path = tmp_path / "bad.tamp"
    if content is not None:
        path.write_bytes(content)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = tamplang(command, path, *(["--emit", "ir"] if command == "compile" else []))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert after.ru_utime - before.ru_utime < 2.0
    assert process.returncode == 1
    assert "E001" in process.stdout + process.stderr
    assert "bad.tamp" in process.stdout + process.stderr
    if content is not None:
        assert path.read_bytes() == content


def test_a_folder_is_no_program(tamplang: Tamplang, tmp_path: Path) -> None:
    process = tamplang("check", tmp_path)
    assert process.returncode == 1
    assert "E0012" in process.stdout


def test_fmt_rewrites_and_then_leaves_alone(tamplang: Tamplang, program: Program) -> None:
    path = program("type   plate<object\n")
    assert tamplang("fmt", "--check", path).returncode == 1
    assert path.read_text() == "type   plate<object\n"
    assert tamplang("fmt", path).returncode == 0
    assert path.read_text() == "type plate < object\n"
    assert tamplang("fmt", "--check", path).returncode == 0


def test_fmt_leaves_a_file_with_errors_alone(tamplang: Tamplang, program: Program) -> None:
    path = program("type plate <\n")
    assert tamplang("fmt", path).returncode == 1
    assert path.read_text() == "type plate <\n"


def test_explain(tamplang: Tamplang) -> None:
    process = tamplang("explain", "e0103")
    assert process.returncode == 0
    assert "unknown predicate" in process.stdout


def test_new_writes_a_clean_program_and_never_overwrites(tamplang: Tamplang, tmp_path: Path) -> None:
    assert tamplang("new", "walk").returncode == 0
    text = (tmp_path / "walk.tamp").read_text()
    assert "task walk(" in text
    assert tamplang("check", "walk.tamp").returncode == 0
    assert tamplang("fmt", "--check", "walk.tamp").returncode == 0
    process = tamplang("new", "walk")
    assert process.returncode == 2
    assert "exists already" in process.stderr
    assert (tmp_path / "walk.tamp").read_text() == text


def test_errors_of_solve_as_json(tamplang: Tamplang, program: Program) -> None:
    process = tamplang("solve", program(MISTAKES), "--json")
    assert process.returncode == 1
    answer = json.loads(process.stdout)
    assert answer["status"] == "error"
    assert "E0103" in {d["code"] for d in answer["diagnostics"]}
