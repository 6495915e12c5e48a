"""Sound programs parse and keep their meaning when they are laid out; faulty ones give exactly the expected text.

`TAMPLANG_UPDATE_EXPECTED=1 pytest tests/langs` writes the expected texts anew: read the difference before you keep it.
"""

import os
from pathlib import Path

import pytest

from tamplang.langs.codes import CODES
from tamplang.langs.formatter import format_source
from tamplang.langs.parser import parse
from tamplang.langs.render import render
from tamplang.langs.source import Source

from .programs import BAD, GOOD, REAL, source_of


@pytest.mark.parametrize("path", [*GOOD, *REAL], ids=lambda p: p.stem)
def test_sound_program(path: Path) -> None:
    source = source_of(path)
    tree, found = parse(source)
    assert render(found, {source.path: source}) == ""
    assert tree.declarations

    laid_out = Source(source.path, format_source(source))
    assert parse(laid_out) == (tree, ())
    assert format_source(laid_out) == laid_out.text


@pytest.mark.parametrize("path", REAL, ids=lambda p: p.stem)
def test_library_and_examples_have_the_standard_layout(path: Path) -> None:
    source = source_of(path)
    assert format_source(source) == source.text


@pytest.mark.parametrize("path", BAD, ids=lambda p: p.stem)
def test_faulty_program(path: Path) -> None:
    source = source_of(path)
    _, found = parse(source)
    assert found and {d.code for d in found} <= CODES.keys()
    sources = {source.path: source}
    text = f"{render(found, sources, 'concise')}\n\n{render(found, sources, 'full')}\n"
    expected = path.with_suffix(".expected")
    if os.environ.get("TAMPLANG_UPDATE_EXPECTED"):
        expected.write_text(text, encoding="utf-8")
    assert text == expected.read_text(encoding="utf-8")
