"""Characters of every kind, wherever they can stand: coded errors or plain text, never an internal error."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tamplang.compiler.pipeline import check_sources
from tamplang.langs.diagnostics import SourceError
from tamplang.langs.formatter import format_source
from tamplang.langs.render import FORMATS, render
from tamplang.langs.source import Source

from .conftest import CLIMB, LIGHT, Faulty

ODD = (
    "٣３²Ⅷ½\u00a0\u2028\u2029\u3000\u202e\u200b\ufeff\u0301éא😀\0\v\f\x1b\x7f\x85\r"
    "“−×µ°ΩſıİK\u0378\ue000\U0010ffff\ud800\udfff"
)
"""Digits that are no ASCII digits, blanks and line ends that are none, marks of direction, lone surrogates, …"""
PLACES = {
    "number": "function f() = @",
    "digits": "function f() = 1@",
    "fraction": "function f() = 1.@",
    "exponent": "function f() = 1e@",
    "unit": "function f() = 1 m@",
    "rate": "function f() = 1 deg/s^@",
    "name": "type @",
    "in a name": "type a@b",
    "keyword": "ty@pe a",
    "import": "import std.@",
    "quoted import": 'import "@.tamp"',
    "text": 'task t() { object b: mesh("@") at (0, 0, 0) goal (b) }',
    "comment": "type a # @",
    "documentation": "## @\ntype a",
    "between": "type a @ type b",
    "start": "@type a",
    "end": "type a@",
    "bracket": "predicate @(p)",
    "sign": "function f() = 1 @ 2",
}


@pytest.mark.parametrize("place", PLACES)
def test_any_character_anywhere(place: str) -> None:
    for character in ODD:
        text = PLACES[place].replace("@", character)
        source = Source("odd.tamp", text)
        found = check_sources([source])
        for diagnostic in found:
            span = diagnostic.span
            assert span is None or 0 <= span.start <= span.end <= len(text), (character, diagnostic)
        for form in FORMATS:
            shown = render(found, {"odd.tamp": source}, form)
            unsafe = set(shown) & set("\0\x1b\u202e\x85\x7f\u200b")
            assert form in ("json", "sarif") or not unsafe, (character, form)
        try:
            laid_out = format_source(source)
        except SourceError:
            continue
        assert format_source(Source("odd.tamp", laid_out)) == laid_out


@pytest.mark.parametrize("digit", "٣３²Ⅷ")
def test_only_ascii_digits_are_numbers(faulty: Faulty, tmp_path: Path, digit: str) -> None:
    program = tmp_path / "digit.tamp"
    program.write_text(f"function f() = {digit}", encoding="utf-8")
    process = faulty("check", program, "--format", "json")
    assert process.returncode == 1
    assert [d["code"] for d in json.loads(process.stdout)] == ["E0002"]


@pytest.mark.parametrize(
    ("command", "option", "value"),
    [
        ("solve", "--seed", "٣"), ("solve", "--seed", "1_0"), ("solve", "--seed", "9" * 30), ("solve", "--time", "٣"),
        ("solve", "--time", "1_0"), ("solve", "--nodes", "３"), ("solve", "--jobs", "²"), ("solve", "--horizon", "٢"),
        ("solve", "--horizon", "9" * 5000), ("solve", "-p", "n=٣"), ("solve", "-p", "٣=3"),
        ("solve", "--solutions", "9" * 12), ("sweep", "--seeds", "٣"), ("sweep", "--seeds", "٠..٣"),
        ("sweep", "-p", "n=١..٣"), ("sweep", "--cluster", "tcp://127.0.0.1:١"), ("run", "--noise", "joint=٣"),
        ("run", "--latency", "٠"), ("compile", "--seed", "٣"),
    ],
)  # fmt: skip
def test_numbers_of_options_are_ascii(faulty: Faulty, command: str, option: str, value: str) -> None:
    emit = ("--emit", "ir") if command == "compile" else ()
    process = faulty(command, CLIMB, *emit, option, value)
    assert (process.returncode, process.stdout) == (2, "")
    assert "Error:" in process.stderr or "E0519" in process.stderr


@pytest.mark.parametrize("content", [b"\xef\xbb\xbf" + LIGHT.encode(), LIGHT.replace("\n", "\r\n").encode()])
def test_marks_of_order_and_line_ends_are_read(faulty: Faulty, tmp_path: Path, content: bytes) -> None:
    program = tmp_path / "program.tamp"
    program.write_bytes(content)
    assert faulty("check", program).returncode == 0


@pytest.mark.parametrize("content", [b"type a\0", b"\xff\xfet\0y\0", b"type \xed\xa0\x80", b"\xc0\x80", b"\x80" * 1000])
def test_what_is_no_text_is_told(faulty: Faulty, tmp_path: Path, content: bytes) -> None:
    program = tmp_path / "program.tamp"
    program.write_bytes(content)
    for command in (("check",), ("fmt",), ("compile", "--emit", "ast")):
        process = faulty(*command, program)
        assert process.returncode == 1 and "E0014" in process.stderr + process.stdout
    assert program.read_bytes() == content


@pytest.mark.parametrize("options", [(), ("--horizon", "2"), ("--bound", "path")])
@pytest.mark.parametrize("body", ["object b: box(1 m, 1 m, 1 m) at (0, 0, 0)", ""])
def test_a_task_without_modules_is_solved(faulty: Faulty, tmp_path: Path, body: str, options: tuple[str, ...]) -> None:
    program = tmp_path / "done.tamp"
    program.write_text(f"predicate (done)\nrule r() {{ post (done) }}\ntask t() {{ {body} goal (done) }}")
    process = faulty("solve", program, "--json", "--report", "t.html", *options)
    assert process.returncode == 0, process.stderr
    answer = json.loads(process.stdout)
    assert (answer["status"], answer["actions"], answer["verified"]) == ("solved", ["r()"], True)
    assert faulty("verify", "t.plan.json").returncode == 0
    assert faulty("run", "t.plan.json").returncode == 0
