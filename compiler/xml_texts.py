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

DEEPEST = 100
"""Elements inside each other. A link needs 5; what is far deeper was made to harm who walks down."""
BLOCK = 1_000_000
"""Bytes that are read between two looks at the time."""
_DOCUMENT_TYPE = re.compile(rb"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)
_DECLARATION = re.compile(r"\s*<\?xml[^>]*\?>")
_HIDDEN = re.compile(r"<!\[CDATA\[.*?\]\]>|<!--.*?-->", re.DOTALL)


class XmlError(Exception):
    """The text cannot be read; the message says why and where."""


def decoded(content: bytes) -> bytes:
    """The same text in UTF-8. What is not UTF-8 is taken as Latin-1, in which every byte is a character."""
    try:
        content.decode()
    except UnicodeDecodeError:
        return content.decode("latin-1").encode()
    return content


def read_xml(text: str) -> ElementTree.Element:
    """The root element. Names keep their prefixes, whether they are declared or not. Raises XmlError."""
    builder, depth = ElementTree.TreeBuilder(), 0
    parser = expat.ParserCreate("utf-8")
    parser.ordered_attributes = False

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > DEEPEST:
            raise XmlError(f"elements are nested too deeply{_from(parser)}")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    parser.StartElementHandler, parser.EndElementHandler = begin, end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = partial(_refuse, parser)
    try:
        parser.Parse(_HIDDEN.sub(_blanks, _DECLARATION.sub(_blanks, text, count=1)).encode(), True)
    except (expat.ExpatError, UnicodeEncodeError):
        raise XmlError(f"this is not XML{_from(parser)}") from None
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
            raise XmlError("a document type, and entities with it, are not allowed") from None


def _refuse(parser: expat.XMLParserType, *_: object) -> None:
    raise XmlError(f"a document type, and entities with it, are not allowed{_from(parser)}")


def _blanks(match: re.Match[str]) -> str:
    """Blanks in place of a comment, so that all else keeps its line and column."""
    return match[0] if match[0].startswith("<![") else re.sub(r"[^\n]", " ", match[0])


def _from(parser: expat.XMLParserType) -> str:
    return f" from line {parser.ErrorLineNumber}, column {parser.ErrorColumnNumber + 1} on"
