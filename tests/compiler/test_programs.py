"""Every program of tests/programs: bad ones give exactly the expected text, good ones nothing at all.

`TAMPLANG_UPDATE=1 pytest tests/compiler/test_programs.py` writes the expected texts anew; read the difference.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tamplang.compiler import pipeline

from .programs import PROGRAMS, checked

BAD = sorted((PROGRAMS / "bad").glob("*.tamp"))
GOOD = sorted((PROGRAMS / "good").glob("*.tamp"))
EXAMPLES = sorted((PROGRAMS.parents[1] / "examples").glob("*.tamp"))


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


@pytest.mark.parametrize("path", [p for p in BAD if p.stem != "warnings"], ids=lambda p: p.stem)
def test_bad_program_has_an_error_with_place_and_known_code(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from tamplang.langs.codes import CODES

    monkeypatch.chdir(PROGRAMS)
    found = pipeline.check(f"bad/{path.name}")
    assert any(d.is_error for d in found)
    for diagnostic in found:
        assert diagnostic.code in CODES
        assert diagnostic.span is not None
