"""The colours of editors without a server, of Pygments, and of the server's semantic tokens are the same."""

from __future__ import annotations

import importlib.util
import json
import re
import sys
import tomllib
from pathlib import Path

import pytest

from tamplang.compiler.library import BUILT_IN_TYPES, VALUE_TYPE_NAMES
from tamplang.highlight import coloured
from tamplang.langs.reader import read_source
from tamplang.langs.source import Source
from tamplang.langs.words import TYPES
from tamplang.lsp.tokens import classified
from tamplang.pygments_lexer import TamplangLexer

from .conftest import ROOT

REAL = sorted([*(ROOT / "stdlib").glob("*.tamp"), *(ROOT / "examples").glob("*.tamp")])
KEYWORDS = {"declaration", "keyword", "modifier", "control"}
SAME = {**dict.fromkeys(KEYWORDS, "keyword"), "doc": "comment", "comment": "comment", "string": "string",
        "number": "number"}  # fmt: skip


def kinds(found: list[tuple[int, int, str]], text: str) -> dict[int, tuple[str, str]]:
    """What stands where, with keyword, comment, string, number or name."""
    return {s: (text[s:e].strip(), SAME.get(k, k if k in SAME.values() else "name")) for s, e, k in found}


@pytest.mark.parametrize("path", REAL, ids=lambda p: p.stem)
def test_the_patterns_colour_real_programs_as_the_server_does(path: Path) -> None:
    text = read_source(path).text
    plain = kinds([(s, e, k) for s, e, k in coloured(text) if k != "operator"], text)
    known = kinds([(s, e, k) for s, e, k, _ in classified(Source(str(path), text))], text)
    assert {s: k for s, k in known.items() if plain.get(s) != k} == {}


@pytest.mark.parametrize("path", REAL, ids=lambda p: p.stem)
def test_literals_and_attributes_are_told_apart(path: Path) -> None:
    """Predicates in parentheses, motion literals in brackets: by the patterns alone as by the server."""
    text = read_source(path).text
    plain = {s: k for s, _, k in coloured(text)}
    meant = {"function": {"predicate", "function", "name"}, "macro": {"motion"}, "property": {"property", "name"}}
    wrong = [
        (text[s:e], k, plain.get(s))
        for s, e, k, _ in classified(Source(str(path), text))
        if k in meant and plain.get(s) not in meant[k]
    ]
    assert wrong == []


def test_the_types_are_those_of_the_compiler() -> None:
    assert set(TYPES) == {*VALUE_TYPE_NAMES, *BUILT_IN_TYPES}


def generated() -> dict[Path, str]:
    spec = importlib.util.spec_from_file_location("generate", ROOT / "editors" / "generate.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["generate"] = module
    spec.loader.exec_module(module)
    found: dict[Path, str] = module.files()
    return found


def test_the_files_of_editors_are_what_the_generator_writes() -> None:
    """`python editors/generate.py` writes them anew."""
    for path, text in generated().items():
        assert path.read_text(encoding="utf-8") == text, path


def test_the_extensions_grammar_is_the_list_of_patterns() -> None:
    grammar = json.loads((ROOT / "editors/vscode/syntaxes/tamplang.tmLanguage.json").read_text(encoding="utf-8"))
    for pattern in grammar["patterns"]:
        assert re.compile(pattern["match"]).groups == len(pattern["captures"])


def test_pygments_gives_back_the_text_and_its_colours() -> None:
    text = read_source(ROOT / "stdlib" / "rules.tamp").text
    found = list(TamplangLexer().get_tokens(text))
    assert "".join(value for _, value in found) == text
    assert "Token.Keyword.Declaration" in {str(kind) for kind, value in found if value == "rule"}


def test_the_lexer_is_an_entry_point() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"]["pygments.lexers"] == {"tamplang": "tamplang.pygments_lexer:TamplangLexer"}
