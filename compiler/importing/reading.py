"""Files of others as programs: from paths to text."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.formatter import format_source
from ...langs.frozen import dataclass
from ...langs.reader import read_bytes
from ...langs.source import Source
from .kinds import KINDS, FileKind, kind_of_text


@dataclass(frozen=True, slots=True)
class Imported:
    """A program and what was left out of it."""

    text: str
    warnings: tuple[Diagnostic, ...] = ()


def import_files(paths: Sequence[str]) -> Imported:
    """The program of one model, or of a PDDL domain and problem. Raises SourceError with all faults."""
    found = [_source(path) for path in paths]
    kinds = {kind.key for _, kind in found}
    sources = [source for source, _ in found]
    if kinds <= {"domain", "problem"}:
        made = _pddl(sources)
    elif len(sources) > 1:
        raise _refusal("E0021", "these are not one program: only a domain and a problem of PDDL go together",
                       "import each file by itself")  # fmt: skip
    elif (kind := found[0][1]).key not in READERS:
        raise _refusal("E0021", f"`{paths[0]}` is a {kind.name}, which is not imported",
                       kind.help.replace("FILE", paths[0]))  # fmt: skip
    else:
        made = READERS[kind.key](sources[0])
    return Imported(format_source(Source("", made.text)), made.warnings)


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
        known = ", ".join(k.name for k in KINDS.values() if k.key in (*READERS, "domain", "problem"))
        raise _refusal("E0021", f"`{path}` is nothing that can be imported", f"what can: {known}")
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n")), kind


def _pddl(sources: Sequence[Source]) -> Imported:
    from .pddl import import_pddl

    return Imported(import_pddl(sources).text)


READERS: dict[str, Callable[[Source], Imported]] = {}
"""Kinds of one file each."""


def _refusal(code: str, message: str, help: str | None = None) -> SourceError:
    return SourceError([Diagnostic(code, message, help=help)])
