"""The one standard layout. Only blanks and line ends change, so comments and meaning stay.

Every statement starts a line, indented by its blocks; lines that the author broke inside a statement stay broken and
are indented anew. The words of a rule's parts, the values of a heuristic and the marks of neighbouring predicates are
aligned.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from lark import UnexpectedInput

from .diagnostics import SourceError
from .parser import no_garbage, parse
from .pieces import Piece, pieces_of
from .source import Source

INDENT = 4
_OPENING = {"LPAR", "LSQB", "LBRACE"}
_CLOSING = {"RPAR", "RSQB", "RBRACE"}
_PARTS = {"pre", "where", "post", "cost", "goal_item", "guide_use"}
_PART_WIDTH = 6
_TIGHT_BEFORE = {"RPAR", "RSQB", "COMMA", "COLON", "DOT"}
_TIGHT_AFTER = {"LPAR", "LSQB", "DOT"}
_OPERANDS = {"NAME", "NUMBER", "STRING", "RPAR", "RSQB", "_ANY"}


@dataclass(slots=True)
class Column:
    """Where an aligned second half of some lines starts, known once all of them are."""

    width: int = 0


@dataclass(slots=True)
class Line:
    """`text` is the first half; `rest` the half that is aligned at `column`, if any. The line is indented by `indent`
    blanks, counted from `hang` where it continues an aligned half."""

    indent: int
    text: str = ""
    rest: str = ""
    column: Column | None = None
    hang: Column | None = None
    comment: str = ""
    blank: bool = False
    pieces: list[Piece] = field(default_factory=list)


def format_source(source: Source) -> str:
    """The text of `source` in the standard layout. Raises SourceError when it has mistakes of syntax."""
    _, mistakes = parse(source)
    if any(d.is_error for d in mistakes):
        raise SourceError(mistakes)
    return _laid_out(source.text)


def format_made(text: str) -> str:
    """The standard layout of a text that was made here, which parses: read once, not twice. Raises what `format_source`
    does."""
    try:
        return _laid_out(text)
    except UnexpectedInput:
        return format_source(Source("", text))


def _laid_out(text: str) -> str:
    with no_garbage():
        pieces = pieces_of(text)
    lines = _Layout().lines(pieces)
    _align_predicates(lines)
    _align_comments(lines)
    return "".join(_shown(line) for line in lines)


class _Layout:
    """Groups pieces into lines and indents them."""

    def __init__(self) -> None:
        self._made: list[Line] = []
        self._depth = 0
        self._brackets = 0
        self._base = 0
        self._hang: Column | None = None
        self._values = Column()
        self._extra = 0

    def lines(self, pieces: list[Piece]) -> list[Line]:
        rows = _rows(pieces)
        for index, row in enumerate(rows):
            following = next((r[0] for r in rows[index:] if r[0].kind != "COMMENT"), None)
            self._line(row, following)
        return self._made

    def _line(self, row: list[Piece], following: Piece | None) -> None:
        first = row[0]
        statement_level = (
            following is None or bool(following.statement) or (following.block and following.kind == "RBRACE")
        )
        if first.kind == "COMMENT":
            indent, hang = (self._depth * INDENT, None) if statement_level else self._continued(None)
        elif statement_level:
            indent, hang = self._start(first)
        else:
            indent, hang = self._continued(first)
        line = Line(indent, hang=hang, pieces=row)
        previous = self._made[-1].pieces[-1] if self._made else None
        opens = previous is not None and previous.kind == "LBRACE" and previous.block
        closes = first.kind == "RBRACE" and first.block
        line.blank = first.newlines > 1 and previous is not None and not opens and not closes
        self._fill(line, first.statement)
        self._count(row)
        self._made.append(line)

    def _start(self, first: Piece) -> tuple[int, Column | None]:
        if first.kind == "RBRACE":
            return (self._depth - 1) * INDENT, None
        self._brackets, self._extra, self._hang = 0, 0, None
        self._base = self._depth * INDENT
        indent = self._base
        if first.statement in _PARTS:
            self._base += _PART_WIDTH
            self._extra = -INDENT
        elif first.statement == "heuristic_decl":
            self._values = Column()
        elif first.statement in ("start_value", "heuristic_case"):
            self._hang, self._base, self._extra = self._values, 0, -INDENT
        return indent, None

    def _continued(self, first: Piece | None) -> tuple[int, Column | None]:
        depth = self._brackets - (first is not None and first.kind in _CLOSING)
        if depth == 0 and self._extra == 0 and (first is None or first.kind not in _CLOSING):
            self._extra = INDENT
        return self._base + depth * INDENT + max(self._extra, 0), self._hang

    def _fill(self, line: Line, statement: str) -> None:
        row = [p for p in line.pieces if p.kind != "COMMENT"]
        line.comment = next((p.text for p in line.pieces if p.kind == "COMMENT"), "")
        split = _split(row, statement)
        line.text, line.rest = joined(row[:split]), joined(row[split:])
        if statement in _PARTS and line.rest:
            line.text, line.rest = line.text.ljust(_PART_WIDTH) + line.rest, ""
        elif statement in ("start_value", "heuristic_case"):
            line.column = self._values
            self._values.width = max(self._values.width, line.indent + len(line.text) + 2)

    def _count(self, row: list[Piece]) -> None:
        for piece in row:
            if piece.kind in _OPENING:
                self._depth, self._brackets = self._depth + piece.block, self._brackets + (not piece.block)
            elif piece.kind in _CLOSING:
                self._depth, self._brackets = self._depth - piece.block, self._brackets - (not piece.block)


def _rows(pieces: list[Piece]) -> list[list[Piece]]:
    """The pieces line by line: statements and the ends of blocks start one, and so does what the author broke."""
    rows: list[list[Piece]] = []
    for index, piece in enumerate(pieces):
        previous = pieces[index - 1] if index else None
        if previous is None or _breaks(previous, piece, rows[-1]):
            rows.append([])
        rows[-1].append(piece)
    return rows


def _breaks(previous: Piece, piece: Piece, row: list[Piece]) -> bool:
    if previous.kind == "COMMENT":
        return True
    if piece.kind == "COMMENT":
        return piece.newlines > 0
    empty = previous.kind == "LBRACE" and previous.block and piece.kind == "RBRACE"
    if empty or piece.kind == "LBRACE":
        return False
    if piece.statement or (piece.block and piece.kind == "RBRACE") or (previous.block and previous.kind == "LBRACE"):
        return True
    first = row[0].statement
    alone = first in _PARTS and len(row) == 1
    return piece.newlines > 0 and not alone and not (_is_head(row, first) and piece.kind not in _TIGHT_BEFORE)


def _is_head(row: list[Piece], statement: str) -> bool:
    """Whether the row is just the first half of a line of a heuristic."""
    return statement in ("start_value", "heuristic_case") and _split(row, statement) == len(row)


def _split(row: list[Piece], statement: str) -> int:
    """How many pieces the first half of the line has."""
    if statement in _PARTS or statement == "start_value":
        return 1
    if statement == "heuristic_case":
        return next((i + 1 for i, p in enumerate(row) if p.kind == "COLON"), len(row))
    if statement == "predicate_decl":
        return next((i + 1 for i, p in enumerate(row) if p.kind == "RPAR"), len(row))
    return len(row)


def joined(row: Iterable[Piece]) -> str:
    """The pieces on one line, with blanks between them where the layout wants them."""
    text = ""
    previous: Piece | None = None
    unary = False
    for piece in row:
        if previous is not None and _blank_between(previous, piece, unary):
            text += " "
        unary = piece.kind == "MINUS" and (previous is None or previous.kind not in _OPERANDS)
        text += piece.text
        previous = piece
    return text


def _blank_between(previous: Piece, piece: Piece, unary: bool) -> bool:
    if unary or piece.kind in _TIGHT_BEFORE or previous.kind in _TIGHT_AFTER or previous.text == "¬":
        return False
    if previous.kind == "LBRACE" and piece.kind == "RBRACE":
        return False
    if piece.kind == "LPAR":
        return previous.kind not in ("NAME", "AGGREGATE")
    if piece.kind == "LSQB":
        return previous.kind not in ("NAME", "RSQB")
    return True


def _align_predicates(lines: list[Line]) -> None:
    """Give neighbouring predicates one column for their marks; a blank line or another declaration ends the group."""
    column = Column()
    for line in lines:
        statement = line.pieces[0].statement
        if line.blank or statement not in ("", "predicate_decl"):
            column = Column()
        if statement == "predicate_decl" and line.rest:
            line.column = column
            column.width = max(column.width, len(line.text) + 2)


def _align_comments(lines: list[Line]) -> None:
    """Give the comments behind neighbouring lines one column."""
    group: list[Line] = []
    for line in [*lines, Line(0)]:
        if line.comment and (line.text or line.rest) and not (line.blank and group):
            group.append(line)
            continue
        width = max((len(_code(member)) for member in group), default=0)
        for member in group:
            member.comment = " " * (width - len(_code(member)) + 2) + member.comment
        group = [line] if line.comment and line.text else []


def _code(line: Line) -> str:
    start = " " * (line.indent + (line.hang.width if line.hang is not None else 0)) + line.text
    if line.column is not None and line.rest:
        start = start.ljust(line.column.width)
    elif line.rest:
        start += " "
    return (start + line.rest).rstrip()


def _shown(line: Line) -> str:
    return (
        ("\n" if line.blank else "")
        + (_code(line) + line.comment if line.text else _code(line) + " " * line.indent + line.comment).rstrip()
        + "\n"
    )
