"""The plan's source texts as numbered lines, and links from places into them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import field
from pathlib import PurePosixPath

from ...langs.frozen import dataclass
from ..plan import PlaceRecord, SourceRecord

TOKEN = re.compile(r"(?P<comment>#.*)|(?P<keyword>\b[a-z]+\b)|(?P<open>\{)|(?P<close>\})")
WORDS = """import type predicate derived placement motion rule heuristic scene task module joint link effector
pre post where cost during keep at switch goal guide options fact for in if else not and or exists forall
start static symmetric functional chain of by from"""
KEYWORDS = frozenset(WORDS.split())


@dataclass(frozen=True, slots=True)
class SourcePiece:
    """A stretch of a line; `kind` is "comment", "keyword" or empty."""

    text: str
    kind: str = ""


@dataclass(slots=True)
class SourceLine:
    number: int
    pieces: list[SourcePiece]
    anchor: str
    used: bool = False


@dataclass(slots=True)
class SourceView:
    index: int
    path: str
    sha256: str
    lines: list[SourceLine]
    blocks: list[tuple[int, int]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class SourceLink:
    """A place as the page shows it; `anchor` is empty when its source is not in the plan."""

    text: str
    anchor: str
    title: str


def split_line(text: str) -> list[SourcePiece]:
    """The pieces of one line: comments and words of the language set apart."""
    pieces: list[SourcePiece] = []
    done = 0
    for match in TOKEN.finditer(text):
        if match.lastgroup == "keyword" and match.group() not in KEYWORDS:
            continue
        if match.lastgroup in ("open", "close"):
            continue
        pieces += [SourcePiece(text[done : match.start()]), SourcePiece(match.group(), match.lastgroup or "")]
        done = match.end()
    pieces.append(SourcePiece(text[done:]))
    return [p for p in pieces if p.text]


def find_blocks(lines: list[str]) -> list[tuple[int, int]]:
    """First and last line of every top-level block in braces, with the `##` lines just above it."""
    blocks: list[tuple[int, int]] = []
    depth, start = 0, 0
    for number, text in enumerate(lines, 1):
        for match in TOKEN.finditer(text):
            if match.lastgroup == "open":
                start = number if depth == 0 else start
                depth += 1
            elif match.lastgroup == "close" and depth > 0:
                depth -= 1
                if depth == 0:
                    blocks.append((with_doc(lines, start), number))
    return blocks


def with_doc(lines: list[str], start: int) -> int:
    """The first of the `##` lines that directly precede line `start`, or `start` itself."""
    while start > 1 and lines[start - 2].startswith("##"):
        start -= 1
    return start


class Sources:
    """All sources of a plan; remembers which lines are linked to, so that the listing can mark them."""

    def __init__(self, records: Iterable[SourceRecord]) -> None:
        self.views: list[SourceView] = []
        for index, record in enumerate(records):
            texts = record.text.split("\n")
            lines = [SourceLine(n, split_line(t), f"s{index}-{n}") for n, t in enumerate(texts, 1)]
            self.views.append(SourceView(index, record.path, record.sha256, lines, find_blocks(texts)))

    def find(self, file: str) -> SourceView | None:
        """The source with that path; failing that the only one with that file name."""
        exact = [v for v in self.views if v.path == file]
        if exact:
            return exact[0]
        near = [v for v in self.views if PurePosixPath(v.path).name == PurePosixPath(file).name]
        return near[0] if len(near) == 1 else None

    def link(self, place: PlaceRecord | None) -> SourceLink | None:
        """What the page shows for `place`, or None where there is no place."""
        if place is None:
            return None
        text = f"{PurePosixPath(place.file).name}:{place.line}"
        title = f"{place.file}:{place.line}:{place.column}"
        view = self.find(place.file)
        if view is None or not 1 <= place.line <= len(view.lines):
            return SourceLink(text, "", title)
        line = view.lines[place.line - 1]
        line.used = True
        return SourceLink(text, line.anchor, title)

    def excerpt(self, place: PlaceRecord | None) -> list[SourceLine]:
        """The lines of the top-level block around `place`, or its line alone; empty without a source."""
        view = self.find(place.file) if place else None
        if place is None or view is None or not 1 <= place.line <= len(view.lines):
            return []
        block = next((b for b in view.blocks if b[0] <= place.line <= b[1]), (place.line, place.line))
        return view.lines[block[0] - 1 : block[1]]
