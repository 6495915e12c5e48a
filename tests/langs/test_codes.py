"""The table of codes is whole, in order, and covers what the program raises."""

import re

import pytest

from tamplang.langs.codes import CODES, explain
from tamplang.langs.parser import parse
from tamplang.langs.source import Source

from .programs import ROOT

CATEGORIES = {"file", "syntax", "name", "type", "logic", "motion", "scene", "warning", "outcome"}


def test_codes_are_in_order_and_complete() -> None:
    assert list(CODES) == sorted(CODES)
    for code, info in CODES.items():
        assert re.fullmatch(r"(E0[0-5]|W0|S0)\d\d" if code[0] == "E" else r"[WS]\d{4}", code)
        assert info.title and info.explanation.endswith(".")
        assert info.category in CATEGORIES
        assert bool(info.wrong) == bool(info.right)


def test_every_code_in_the_program_is_declared() -> None:
    files = [f for room in ("langs", "compiler", "runtime", "tamplang") for f in (ROOT / room).rglob("*.py")]
    used = {c for f in files for c in re.findall(r'"([EWS]0\d{3})"', f.read_text(encoding="utf-8"))}
    assert used <= CODES.keys()


def test_explain() -> None:
    text = explain("e0103")
    assert text.startswith("E0103: unknown predicate (name)")
    assert "Wrong:\n    pre (suport A)" in text and "Right:\n    pre (support A)" in text


def test_explain_unknown_code() -> None:
    with pytest.raises(KeyError, match="E0103"):
        explain("E01O3")


@pytest.mark.parametrize("code", ["E0001", "E0003", "E0004", "E0005", "E0006"])
def test_examples_of_syntax_codes(code: str) -> None:
    info = CODES[code]
    wrapped = {"E0003": "module m {{ {} }}"}.get(code, "{}")
    if "…" not in info.wrong:
        assert code in {d.code for d in parse(Source("t", wrapped.format(info.wrong)))[1]}
        assert parse(Source("t", wrapped.format(info.right)))[1] == ()
