"""Files of others as programs: from paths to text."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.formatter import format_source
from ...langs.reader import read_bytes
from ...langs.source import Source
from .kinds import KINDS, FileKind, kind_of_text

IMPORTED = frozenset(("domain", "problem"))
"""Kinds that programs are made of."""


def import_files(paths: Sequence[str]) -> str:
    """The program of a PDDL domain and problem. Raises SourceError with all faults."""
    found = [_source(path) for path in paths]
    if {kind.key for _, kind in found} <= IMPORTED:
        from .pddl import import_pddl

        return format_source(Source("", import_pddl([source for source, _ in found]).text))
    if len(found) > 1:
        raise _refusal("E0021", "these are not one program: only a domain and a problem of PDDL go together",
                       "import each file by itself")  # fmt: skip
    kind = found[0][1]
    help = kind.help.replace("FILE", paths[0])
    raise _refusal("E0021", f"`{paths[0]}` is a {kind.name}, which is not imported", help)


def _source(path: str) -> tuple[Source, FileKind]:
    """The text and kind of a file. Bytes that are not UTF-8 are taken as Latin-1: they stand in comments."""
    content = read_bytes(path)
    if not content.strip():
        raise _refusal("E0013", f"`{path}` is empty")
    if b"\0" in content:
        raise _refusal("E0014", f"`{path}` is not a text file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    kind = kind_of_text(path, text)
    if kind is None:
        known = ", ".join(k.name for k in KINDS.values() if k.key in IMPORTED)
        raise _refusal("E0021", f"`{path}` is nothing that can be imported", f"what can: {known}")
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n")), kind


def _refusal(code: str, message: str, help: str | None = None) -> SourceError:
    return SourceError([Diagnostic(code, message, help=help)])
