"""Every program of tests/programs: bad ones give exactly the expected text, good ones nothing at all.

`TAMPLANG_UPDATE=1 pytest tests/compiler` writes the expected texts anew; read the difference.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tamplang.compiler import pipeline
from tamplang.compiler.imports import on_disk
from tamplang.langs.codes import CODES
from tamplang.langs.diagnostics import Diagnostic
from tamplang.langs.reader import read_source
from tamplang.langs.render import render
from tamplang.langs.source import Source

PROGRAMS = Path(__file__).parents[1] / "programs"
BAD = sorted((PROGRAMS / "bad").glob("*.tamp"))
GOOD = sorted((PROGRAMS / "good").glob("*.tamp"))
ONLY_WARNINGS = ("warnings", "negative_cycle", "moves_into", "out_of_reach")
EXAMPLES = sorted((PROGRAMS.parents[1] / "examples").glob("*.tamp"))


def rendered(diagnostics: tuple[Diagnostic, ...]) -> str:
    """Both forms, one after the other."""
    spans = [s for d in diagnostics for s in (d.span, *(label.span for label in d.labels)) if s is not None]
    sources = {s.file: Source(s.file, read_source(on_disk(s.file)).text) for s in spans}
    return render(diagnostics, sources, "concise") + "\n\n" + render(diagnostics, sources, "full") + "\n"


def checked(path: str) -> str:
    """What `check` says about a program; the path is relative to the current directory."""
    return rendered(pipeline.check(path))


@pytest.mark.parametrize("path", BAD, ids=lambda p: p.stem)
def test_bad_program(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(PROGRAMS)
    text = checked(f"bad/{path.name}")
    expected = path.with_suffix(".expected")
    if os.environ.get("TAMPLANG_UPDATE"):
        expected.write_text(text)
    assert text == expected.read_text()


@pytest.mark.parametrize("path", [*GOOD, *EXAMPLES], ids=lambda p: p.stem)
def test_good_program(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(PROGRAMS)
    assert [d.message for d in pipeline.check(os.path.relpath(path))] == []


@pytest.mark.parametrize("path", [p for p in BAD if p.stem not in ONLY_WARNINGS], ids=lambda p: p.stem)
def test_bad_program_has_an_error_with_place_and_known_code(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(PROGRAMS)
    found = pipeline.check(f"bad/{path.name}")
    assert any(d.is_error for d in found)
    for diagnostic in found:
        assert diagnostic.code in CODES
        assert diagnostic.span is not None
