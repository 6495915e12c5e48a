"""The language reference is true to the grammar."""

import re

import pytest

from tamplang.compiler.builtins import FUNCTIONS
from tamplang.langs.grammar_loader import parser
from tamplang.langs.parser import parse
from tamplang.langs.source import Source

from .programs import ROOT

TEXT = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```tamp\n(.*?)```", TEXT, re.DOTALL)


@pytest.mark.parametrize("example", EXAMPLES, ids=range(len(EXAMPLES)))
def test_examples_parse(example: str) -> None:
    assert parse(Source("docs/language.md", example))[1] == ()


def test_every_keyword_is_described() -> None:
    patterns = (t.pattern.value.split("(?!")[0] for t in parser().terminals if t.priority)
    words = {w for p in patterns for w in re.findall(r"\w+", p)}
    assert len(words) > 50
    assert [w for w in sorted(words) if not re.search(rf"\b{w}\b", TEXT)] == []


def test_every_function_is_described() -> None:
    assert [f for f in FUNCTIONS if not re.search(rf"\b{f}\b", TEXT)] == []
