"""The table of codes is whole, in order, and what the program raises; the programs that explain a code give it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tamplang.compiler.pipeline import check
from tamplang.langs.codes import CODES, explain
from tamplang.langs.explanation import MAIN, Example, examples

from .programs import ROOT

CATEGORIES = {"file", "syntax", "name", "type", "logic", "motion", "scene", "warning", "outcome"}


def test_codes_are_in_order_and_complete() -> None:
    assert list(CODES) == sorted(CODES)
    for code, info in CODES.items():
        assert re.fullmatch(r"(E0[0-5]|W0|S0)\d\d" if code[0] == "E" else r"[WS]\d{4}", code)
        assert info.title and info.explanation.endswith(".")
        assert info.category in CATEGORIES


def test_the_declared_codes_are_those_that_the_program_uses() -> None:
    files = [f for room in ("langs", "compiler", "runtime", "tamplang") for f in (ROOT / room).rglob("*.py")]
    table = ROOT / "langs" / "codes.py"
    used = {
        c
        for f in files
        if f.resolve() != table
        for c in re.findall(r"[\"`]([EWS]0\d{3})[\"`:]", f.read_text(encoding="utf-8"))
    }
    assert used == CODES.keys()


def test_explain_shows_both_programs() -> None:
    text = explain("e0103")
    assert text.startswith("E0103: unknown predicate (name)")
    wrong, right = text.split("Right:\n")
    assert "Wrong:\n    import std.rules\n" in wrong and "pre   (suport A)" in wrong
    assert "pre   (support A)" in right


def test_explain_unknown_code() -> None:
    with pytest.raises(KeyError, match="E0103"):
        explain("E01O3")


def found(example: Example) -> set[str]:
    """The codes that an example gives, in a folder of its own."""
    return _found(tuple(example.files.items()), example.commands)


@cache
def _found(files: tuple[tuple[str, str], ...], commands: str) -> set[str]:
    with TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in files:
            (folder / file).write_text(text, encoding="utf-8")
        if not commands:
            return {d.code for d in check(folder / MAIN)}
        return set(re.findall(r"\b[EWS]\d{4}\b", _carried_out(folder, commands)))


def _carried_out(folder: Path, commands: str) -> str:
    """What the commands print in a shell that knows `tamplang`."""
    paths = [str(Path(sys.executable).parent), os.environ["PATH"]]
    known = {"PATH": ":".join(paths), "PYTHONPATH": f"{folder}:{ROOT}"}
    process = subprocess.run(
        ["sh", "-c", f'tamplang() {{ python -m tamplang "$@"; }}\n{commands}'], cwd=folder, env={**os.environ, **known},
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert "Traceback" not in process.stdout
    return process.stdout



@pytest.mark.parametrize("code", CODES)
def test_the_wrong_program_of_a_code_gives_it_and_the_right_one_nothing(code: str) -> None:
    wrong, right = (found(example) for example in examples(code))
    kinds = "S" if code[0] == "S" else "EWS"  # an outcome may come with warnings
    assert {c for c in wrong if c[0] in kinds} == {code}
    assert {c for c in right if c[0] in kinds} == set()
