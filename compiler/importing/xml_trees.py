"""XML files of others with the places of their elements: what is wrong, and what is left out."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.source import Source, Span
from ..xml_texts import XmlError, read_xml, span_of
from .faults import FaultList

Element = ElementTree.Element


class XmlFaults(FaultList):
    """All that is to be said of one file."""

    def __init__(self, source: Source) -> None:
        super().__init__()
        self.source = source

    def root(self) -> Element:
        """The outermost element. Raises SourceError (E0019)."""
        try:
            return read_xml(self.source.text)
        except XmlError as error:
            raise SourceError([Diagnostic("E0019", str(error), error.span(self.source))]) from None

    def span(self, element: Element) -> Span:
        return span_of(self.source, element)

    def fault(self, element: Element, message: str, help: str | None = None, code: str = "E0022") -> None:
        """What keeps the file from being read. Raises SourceError when there are too many."""
        self.add(code, self.span(element), message, help)

    def leave(self, element: Element, message: str) -> None:
        """What has no counterpart and is left out."""
        self.note(self.span(element), message)

    def numbers(self, element: Element, text: str | None, count: int, what: str) -> tuple[float, ...] | None:
        """`count` finite numbers; None, and a fault, where the text is something else."""
        try:
            values = tuple(float(word) for word in (text or "").split())
        except ValueError:
            values = ()
        if len(values) != count or not all(map(math.isfinite, values)):
            wanted = "a number" if count == 1 else f"{count} numbers"
            self.fault(element, f"{what} is not {wanted}: `{(text or '').strip()[:40]}`", code="E0019")
            return None
        return values
