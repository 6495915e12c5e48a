"""What can be said of a library of which some text could not be read: findings that do not follow from the gaps."""

from __future__ import annotations

import re

from ...langs import syntax
from ...langs.source import Span
from ..library import Library
from .findings import Findings

DECLARED = re.compile(
    r"^(?:(?:type|function|module|rule|heuristic|scene|task)\s+(\w+)"
    r"|(?:predicate|derived)\s*\(\s*(\w+)|motion\s*\[\s*(\w+))",
    re.MULTILINE,
)
IMPORTS = re.compile(r"^import\b", re.MULTILINE)
UNKNOWN_NAMES = ("E0101", "E0102", "E0103", "E0104", "E0105", "E0106", "E0107", "E0108", "E0117")
WHOLE_FILE = ("E0506", "E0101", "E0209")


def keep_certain(library: Library, found: Findings, certain: Findings) -> None:
    """Move findings from `found` to `certain`, without those that a lost declaration or import may cause."""
    lost = lost_names(library)
    imports = lost_imports(library, certain)
    broken = {
        (d.span.file, line) for d in certain if d.span is not None for line in range(d.span.line, d.span.end_line + 1)
    }
    texts = {s.path: s.text.split("\n") for s in library.sources}
    words = {file: set(re.findall(r"\w+", " ".join(texts[file][line - 1] for f, line in broken if f == file and
                                                    line <= len(texts[file])))) for file, _ in broken if file in texts}
    rules = [d.span for f in library.files for d in f.declarations if isinstance(d, syntax.RuleDecl)]
    faulty = [r for r in rules if any((r.file, line) in broken for line in range(r.line, r.end_line + 1))]
    for diagnostic in found:
        if diagnostic.code == "E0302" and any(_within(diagnostic.span, rule) for rule in faulty):
            continue  # what is wrong with its parts may have made effects of its conditions
        at_gap = diagnostic.span is not None and (diagnostic.span.file, diagnostic.span.line) in broken
        misspelt = diagnostic.code in (*UNKNOWN_NAMES, "E0301") and diagnostic.help is not None
        if at_gap and not misspelt:
            continue
        told = "" if diagnostic.span is None else diagnostic.span.file
        name = re.search(r"`(\w+)", diagnostic.message)
        if diagnostic.code in ("E0101", "E0301") and name is not None and name[1] in words.get(told, ()):
            continue
        if diagnostic.code == "E0506" and "goal" in words.get(told, ()):
            continue
        follows = diagnostic.code in UNKNOWN_NAMES and (imports or any(f"`{n}`" in diagnostic.message for n in lost))
        incomplete = diagnostic.code in WHOLE_FILE and (lost or imports)
        if diagnostic.is_error and not follows and not incomplete:
            certain.add(diagnostic)


def _within(span: Span | None, outer: Span) -> bool:
    return span is not None and span.file == outer.file and outer.start <= span.start <= outer.end


def lost_names(library: Library) -> set[str]:
    """Names that the texts declare, at the start of a line, and the trees lack."""
    written = {n for s in library.sources for m in DECLARED.finditer(s.text) for n in m.groups() if n}
    known = set(library.types).union(*library.tables)
    return written - known


def lost_imports(library: Library, certain: Findings) -> bool:
    """Whether an import failed, or could not even be read."""
    if any(d.code in ("E0111", "E0112") or d.code.startswith("E001") for d in certain):
        return True
    written = sum(len(IMPORTS.findall(s.text)) for s in library.sources)
    read = sum(isinstance(d, syntax.Import) for f in library.files for d in f.declarations)
    return written > read
