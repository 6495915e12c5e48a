"""`--time` and `--memory` of every command: what is told, with which status, and what is kept."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.trust.families import FAMILIES, MAIN
from tamplang.runtime.budget import is_out_of_memory

from .conftest import Tamplang

LONG = ("wide bodies", 4000)
"""A program that takes seconds to check and more to compile."""
SHORT = "0.6"
"""Seconds in which a command starts, and no more."""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    name, size = LONG
    (tmp_path / MAIN).write_text(FAMILIES[name].make(size)[MAIN], encoding="utf-8")
    return tmp_path / MAIN


@pytest.mark.parametrize(
    "arguments",
    [
        ("check",),
        ("compile", "--emit", "ir"),
        ("compile", "--emit", "pddl"),
        ("solve",),
        ("run",),
    ],
)
@pytest.mark.parametrize(("limit", "code"), [(("--time", SHORT), "S0003"), (("--memory", "30MB"), "S0010")])
def test_what_is_spent_while_compiling_is_told(
    tamplang: Tamplang, program: Path, arguments: tuple[str, ...], limit: tuple[str, str], code: str
) -> None:
    command, *options = arguments
    process = tamplang(command, program, *options, *limit)
    assert process.returncode == 4, process.stderr
    assert f"outcome[{code}]" in process.stderr
    assert [file.name for file in program.parent.iterdir()] == [MAIN]


def test_check_prints_what_it_found_before(tamplang: Tamplang, program: Path) -> None:
    wrong = program.parent / "wrong.tamp"
    wrong.write_text("type base < nothing\n", encoding="utf-8")
    process = tamplang("check", wrong, *[program] * 100, "--time", "6")
    assert process.returncode == 4
    assert "E0102" in process.stdout and "S0003" in process.stderr and MAIN in process.stderr


def test_json_tells_that_time_is_spent(tamplang: Tamplang, program: Path) -> None:
    process = tamplang("solve", program, "--time", SHORT, "--json")
    answer = json.loads(process.stdout)
    assert (process.returncode, answer["status"]) == (4, "budget")
    assert [d["code"] for d in answer["diagnostics"]] == ["S0003"]


ENDLESS = """
type base
type thing
type foot < effector
predicate (open X: thing)
rule opens(X: thing) { pre not (open X) post (open X) }
rule closes(X: thing) { pre (open X) post not (open X) }
task t(n: int = 1) {
    base ground: box(1 m, 1 m, 5 cm) at (0, 0, 0)
    for i in 1 .. n { thing o[i]: box(1 cm, 1 cm, 1 cm) at (2 cm * i, 3 m, 0) }
    goal forall X: thing { (open X) }
}
"""
"""With n things there are 2^n states."""


def test_an_instance_of_a_sweep_has_its_own_time(tamplang: Tamplang, tmp_path: Path) -> None:
    (tmp_path / MAIN).write_text(ENDLESS, encoding="utf-8")
    options = ("--time", "6", "--bound", "seq", "--search", "bfs", "--out", "out.jsonl")
    process = tamplang("sweep", MAIN, "-p", "n=40,1", *options)
    assert process.returncode == 4, process.stderr
    records = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text(encoding="utf-8").splitlines()]
    found = {r["parameters"]["n"]: r["status"] for r in records if "parameters" in r}
    assert found == {40: "budget", 1: "solved"}


@pytest.mark.parametrize("limit", [("--memory", "180MB"), ("--memory", "360MB", "--jobs", "2")])
def test_a_search_that_grows_without_end_tells_that_the_memory_is_spent(
    tamplang: Tamplang, tmp_path: Path, limit: tuple[str, ...]
) -> None:
    (tmp_path / MAIN).write_text(ENDLESS, encoding="utf-8")
    process = tamplang("solve", MAIN, "-p", "n=40", "--bound", "seq", "--search", "bfs", "--json", *limit)
    answer = json.loads(process.stdout)
    assert (process.returncode, answer["status"]) == (4, "memory")
    assert answer["tree_nodes"] > 10_000 and answer["explanation"][0]["code"] == "S0010"


@pytest.mark.parametrize("text", ["", "2", "0GB", "-1GB", "2 apples", "1e3MB"])
def test_amounts_of_memory(tamplang: Tamplang, program: Path, text: str) -> None:
    process = tamplang("check", program, "--memory", text, "--time", SHORT)
    assert process.returncode == (4 if text == "2" else 2), process.stderr


@pytest.mark.parametrize("memory", ["13MB", "100MB"])
def test_less_memory_than_the_libraries_need_is_told(tamplang: Tamplang, memory: str) -> None:
    example = Path(__file__).parents[2] / "examples" / "real_climb.tamp"
    process = tamplang("solve", example, "--memory", memory, "--time", "20")
    assert process.returncode == 4 and "outcome[S0010]" in process.stderr, process.stderr


@pytest.mark.parametrize("message", ["error return without exception set", "NULL without setting an exception"])
def test_an_error_that_python_could_not_even_make_is_one_of_memory(message: str) -> None:
    assert is_out_of_memory(SystemError(message)) and not is_out_of_memory(SystemError("bad argument"))
