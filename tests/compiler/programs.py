"""The programs under tests/programs, and the text of their diagnostics."""

from __future__ import annotations

from pathlib import Path

from tamplang.compiler import pipeline
from tamplang.compiler.imports import on_disk
from tamplang.langs.diagnostics import Diagnostic
from tamplang.langs.reader import read_source
from tamplang.langs.render import render
from tamplang.langs.source import Source

PROGRAMS = Path(__file__).parents[1] / "programs"


def rendered(diagnostics: tuple[Diagnostic, ...]) -> str:
    """Both forms, one after the other."""
    spans = [s for d in diagnostics for s in (d.span, *(label.span for label in d.labels)) if s is not None]
    sources = {s.file: Source(s.file, read_source(on_disk(s.file)).text) for s in spans}
    return render(diagnostics, sources, "concise") + "\n\n" + render(diagnostics, sources, "full") + "\n"


def checked(path: str) -> str:
    """What `check` says about a program; the path is relative to the current directory."""
    return rendered(pipeline.check(path))
