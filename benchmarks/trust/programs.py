"""Mutated and generated programs through check, fmt, compile and the language server."""

from __future__ import annotations

import re
import signal
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from random import Random
from typing import Any, Protocol

from .generate import ROOT, Grammar, corpus, mutated
from .journal import Line, Record, Settings, cpu

MUTATED, GENERATED = 20_000, 10_000
SECONDS = 2.0
COMMENT = re.compile(r"\"[^\"\n]*\"|(#[^\n]*)")


class TooLong(BaseException):
    """The guard: no handler of the toolchain takes it for an error of its own."""


def run(settings: Settings) -> list[Line]:
    share = 1.0 if settings.count is None else settings.count / (MUTATED + GENERATED)
    journal = settings.journal("programs")
    texts, grammar, desk = corpus(), Grammar(), Desk()
    keys = [f"mutated {n}" for n in range(round(share * MUTATED))]
    keys += [f"generated {n}" for n in range(round(share * GENERATED))]

    def measure(key: str) -> Record:
        chance = Random(f"{settings.seed} {key}")
        name, text = "generated.tamp", ""
        if key.startswith("mutated"):
            name = chance.choice(sorted(texts))
            text = mutated(texts[name], chance)
        else:
            text = grammar.sentence(chance)
        found = tried(desk, name, texts.get(name, ""), text, chance)
        return found if not found["wrong"] else {**found, "name": name, "text": text}

    records = list(journal.fill(keys, measure))
    return [line for kind in ("mutated", "generated") for line in lines(kind, records)]


def lines(kind: str, records: list[Record]) -> Iterator[Line]:
    some = [r for r in records if r["key"].startswith(kind)]
    for record in (r for r in some if r["wrong"]):
        print(f"programs: {record['key']} ({record['name']}): {record['wrong']}", file=sys.stderr)
    wrong = [w for r in some for w in r["wrong"]]
    broken = [w for w in wrong if w.startswith("traceback")]
    slow = [w for w in wrong if w.startswith("slow")]
    rest = len(wrong) - len(broken) - len(slow)
    parsed, good = sum(r["parsed"] for r in some), sum(r["good"] for r in some)
    what = f"{len(some)} {kind} programs ({parsed} parse, {good} without errors): check, fmt, compile, language server"
    result = f"{len(broken)} tracebacks, {len(slow)} over {SECONDS:g} CPU seconds, {rest} wrong spans or layouts"
    yield Line("programs", what, f"{result}; slowest {max((r['cpu'] for r in some), default=0.0):.2f} s", not wrong)


class Editor(Protocol):
    """Who edits a file: yields what is wrong with the answers."""

    def edited(self, path: str, before: str, text: str, chance: Random) -> Iterable[str]: ...


def tried(desk: Editor, name: str, before: str, text: str, chance: Random) -> Record:
    """All stages on one program: what is wrong, if anything."""
    from tamplang.langs.source import Source

    path = str(ROOT / name)
    source = Source(path, text)
    found: Record = {"wrong": [], "parsed": False, "good": False, "cpu": 0.0}
    stages: dict[str, Callable[[], None]] = {
        "check": lambda: found["wrong"].extend(checked(source, found)),
        "fmt": lambda: found["wrong"].extend(laid_out(source, found)),
        "compile": lambda: compiles(source),
        "lsp": lambda: found["wrong"].extend(desk.edited(path, before, text, chance)),
    }
    for stage, work in stages.items():
        began = cpu()
        try:
            _guarded(work)
        except TooLong:
            found["wrong"].append(f"slow: {stage}")
        except Exception:
            last = traceback.format_exc().strip().splitlines()
            found["wrong"].append(f"traceback: {stage}: {' | '.join(line.strip() for line in last[-3:])}"[:400])
        spent = cpu() - began
        found["cpu"] = round(max(found["cpu"], spent), 3)
        if spent > SECONDS and f"slow: {stage}" not in found["wrong"]:
            found["wrong"].append(f"slow: {stage}")
    return found


def _guarded(work: Callable[[], None]) -> None:
    """Ends work after a little more than the CPU seconds that it may take."""

    def stop(number: int, frame: Any) -> None:
        raise TooLong

    old = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, 1.5 * SECONDS)
    try:
        work()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, old)


def checked(source: Any, found: Record) -> Iterator[str]:
    from tamplang.compiler.pipeline import check_sources
    from tamplang.langs.codes import CODES

    diagnostics = check_sources([source])
    found["good"] = not any(d.is_error for d in diagnostics)
    for diagnostic in diagnostics:
        if diagnostic.code not in CODES or not diagnostic.message:
            yield f"code: {diagnostic.code} {diagnostic.message}"
        for span in [diagnostic.span, *(label.span for label in diagnostic.labels)]:
            if span is not None and not inside(span, source):
                yield f"span: {diagnostic.code} at {span!r}"[:200]


def inside(span: Any, source: Any) -> bool:
    """Whether a span lies in its file, and its lines and columns are those of its offsets; the end of a
    line may be told as a place behind its last character."""
    if span.file == source.path:
        text = source.text
    else:
        file = ROOT / span.file.replace("std/", "stdlib/", 1)
        if not file.is_file() or file.suffix != ".tamp":
            return True
        text = file.read_text(encoding="utf-8", errors="replace")
    if not 0 <= span.start <= span.end <= len(text):
        return False
    if _place(text, span.start) != (span.line, span.column):
        return False
    line, column = _place(text, max(span.start, span.end - 1))
    behind = (line, column + 1) if span.end > span.start else (line, column)
    return (span.end_line, span.end_column) in (behind, _place(text, span.end))


def _place(text: str, offset: int) -> tuple[int, int]:
    return text.count("\n", 0, offset) + 1, offset - (text.rfind("\n", 0, offset) + 1) + 1


def laid_out(source: Any, found: Record) -> Iterator[str]:
    from tamplang.langs.diagnostics import SourceError
    from tamplang.langs.formatter import format_source
    from tamplang.langs.parser import parse
    from tamplang.langs.source import Source

    try:
        text = format_source(source)
    except SourceError:
        return
    found["parsed"] = True
    again = Source(source.path, text)
    if format_source(again) != text:
        yield "fmt: not idempotent"
    if parse(again)[0] != parse(source)[0]:
        yield "fmt: another tree"
    if comments(text) != comments(source.text):
        yield "fmt: other comments"


def comments(text: str) -> list[str]:
    return [m[1].rstrip() for m in COMMENT.finditer(text) if m[1]]


def compiles(source: Any) -> None:
    from tamplang.compiler.pipeline import UsageError, compile_sources
    from tamplang.langs.diagnostics import SourceError

    try:
        compile_sources([source], None, {}, 0)
    except (SourceError, UsageError):
        return


class Desk:
    """The answers of the language server, as an editor asks for them, in this process."""

    def __init__(self) -> None:
        from pygls.workspace import Workspace

        from tamplang.lsp.documents import Documents

        self.workspace = Workspace(None)
        self.documents = Documents(self.workspace)
        self.version = 0

    def edited(self, path: str, before: str, text: str, chance: Random) -> Iterator[str]:
        """Opens a file, changes it, and asks about all of it and about two places."""
        from lsprotocol import types

        from tamplang.lsp import layout, tokens
        from tamplang.lsp.diagnostics import by_address, found_in

        here, uri = self.documents, Path(path).as_uri()
        self.version += 2
        self.workspace.put_text_document(types.TextDocumentItem(uri, "tamplang", self.version, before))
        named = types.VersionedTextDocumentIdentifier(self.version + 1, uri)
        self.workspace.update_text_document(named, types.TextDocumentContentChangeWholeDocument(text))
        sources = here.buffers(uri)
        found, read = found_in(sources)
        for diagnostic in by_address(here, sources[0], read, found).get(uri, []):
            end = diagnostic.range.end
            if end.line > len(text.split("\n")) or diagnostic.range.start.line > end.line:
                yield f"lsp: {diagnostic.code} shown at {diagnostic.range}"
        yield from self._asked(uri, text.splitlines() or [""], chance)
        tokens.semantic_tokens(here, uri)
        layout.formatting(here, uri)
        self.workspace.remove_text_document(uri)

    def _asked(self, uri: str, rows: list[str], chance: Random) -> Iterator[str]:
        from lsprotocol import types

        from tamplang.lsp import completion, hover, navigation

        for _ in range(2):
            row = chance.randrange(len(rows))
            place = types.Position(row, chance.randrange(len(rows[row]) + 1))
            hover.hover(self.documents, uri, place)
            completion.completion(self.documents, uri, place)
            for location in navigation.definition(self.documents, uri, place):
                if not str(location.uri).startswith("file:"):
                    yield f"lsp: defined at {location.uri}"
