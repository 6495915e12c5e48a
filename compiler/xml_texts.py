"""XML as the readers of robot models take it: forgiving in what is written, strict in what it may do.

TinyXML, through which Pinocchio and RViz read, knows no namespaces and no declared encodings, and lets comments hold
`--`. Expat underneath does; what would stop it is taken away before. Document types are refused: nothing that one could
declare, such as an entity that stands for others, belongs into a model.
"""

from __future__ import annotations

import re
from functools import partial
from xml.etree import ElementTree
from xml.parsers import expat

from ..langs.source import Source, Span
from .xml_marks import COMMENT, DATA, replaced

DEEPEST = 100
"""Elements inside each other. A link needs 5; what is far deeper was made to harm who walks down."""
BLOCK = 1_000_000
"""Bytes that are read between two looks at the time."""
_WIDE = (
    (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"<\0", "utf-16-le"), (b"\0<", "utf-16-be"),
)  # fmt: skip
"""How texts of two bytes for a character begin, with a mark of their order or without."""
_AMPERSAND = re.compile(r"&(?!#?\w+;)")
_STANDING_FOR_IT = "\ue000"
"""A character that no file has, in place of a `&` that begins no entity, which other readers take as it is."""
_DOCUMENT_TYPE = re.compile(rb"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)
_DECLARATION = re.compile(r"\A\s*<\?xml[^>]*\?>")


class XmlError(Exception):
    """The text cannot be read; the message says why, `line` and `column` say where."""

    def __init__(self, message: str, line: int, column: int) -> None:
        super().__init__(message)
        self.line, self.column = line, column

    def span(self, source: Source) -> Span:
        """Where, in the text that was read: one character."""
        starts = [0, *(m.end() for m in re.finditer("\n", source.text))]
        start = min(starts[min(self.line, len(starts)) - 1] + self.column - 1, len(source.text))
        return Span(source.path, start, start + 1, self.line, self.column, self.line, self.column + 1)


class PlacedElement(ElementTree.Element):
    """An element that knows where it begins in its text, in characters from 0."""

    start = 0


def span_of(source: Source, element: ElementTree.Element) -> Span:
    """The opening tag of an element that `read_xml` gave for the text of `source`."""
    start = element.start if isinstance(element, PlacedElement) else 0
    end = source.text.find(">", start) + 1 or len(source.text)
    line, end_line = (source.text.count("\n", 0, place) + 1 for place in (start, end))
    column, end_column = (place - source.text.rfind("\n", 0, place) for place in (start, end))
    return Span(source.path, start, end, line, column, end_line, end_column)


def decoded(content: bytes) -> bytes:
    """The same text in UTF-8. What begins as UTF-16 does is that; what is not UTF-8 is taken as Latin-1, in which every
    byte is a character."""
    for start, encoding in _WIDE:
        if content.startswith(start):
            return content.decode(encoding, "replace").encode()
    try:
        content.decode()
    except UnicodeDecodeError:
        return content.decode("latin-1").encode()
    return content


def read_xml(text: str) -> ElementTree.Element:
    """The root element; each tells its place (`span_of`). Names keep their prefixes, whether they are declared or not.
    Raises XmlError."""
    builder, depth = ElementTree.TreeBuilder(element_factory=PlacedElement), 0
    parser = expat.ParserCreate("utf-8")
    parser.ordered_attributes = False
    try:
        plain = replaced(_DECLARATION.sub(lambda m: _blanks(m[0]), text, count=1), (COMMENT, DATA), _blanks)
        content = _AMPERSAND.sub(_STANDING_FOR_IT, plain).encode()
    except UnicodeEncodeError:
        raise XmlError("this is not XML", 1, 1) from None
    last = (0, 0)

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth, last
        depth += 1
        if depth > DEEPEST:
            raise _error(parser, "elements are nested too deeply from here on")
        for name, value in attributes.items():
            attributes[name] = value.replace(_STANDING_FOR_IT, "&")
        element = builder.start(tag, attributes)
        now = parser.CurrentByteIndex
        last = now, last[1] + len(content[last[0] : now].decode(errors="ignore"))
        if isinstance(element, PlacedElement):
            element.start = last[1]

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.CharacterDataHandler = lambda words: builder.data(words.replace(_STANDING_FOR_IT, "&"))
    parser.StartDoctypeDeclHandler = partial(_refuse, parser)
    try:
        parser.Parse(content, True)
    except expat.ExpatError:
        raise _error(parser, "this is not XML from here on") from None
    root: ElementTree.Element = builder.close()
    return root


def refuse_document_types(content: bytes) -> None:
    """Raises XmlError where an XML file, in whatever encoding, declares a document type. Whether it is XML is not
    asked."""
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = partial(_refuse, parser)
    try:
        for start in range(0, len(content), BLOCK):
            parser.Parse(content[start : start + BLOCK], False)
    except (expat.ExpatError, ValueError):
        # Other readers may go on where this one gives up.
        if _DOCUMENT_TYPE.search(content.replace(b"\0", b"")):
            raise _error(parser, "a document type, and entities with it, are not allowed") from None


def _refuse(parser: expat.XMLParserType, *_: object) -> None:
    raise _error(parser, "a document type, and entities with it, are not allowed")


def _error(parser: expat.XMLParserType, message: str) -> XmlError:
    return XmlError(message, parser.ErrorLineNumber, parser.ErrorColumnNumber + 1)


def _blanks(hidden: str) -> str:
    """Blanks in place of a comment, so that all else keeps its line and column."""
    return hidden if hidden.startswith(DATA[0]) else re.sub(r"[^\n]", " ", hidden)
