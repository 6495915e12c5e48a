"""What is to be said of foreign files, whatever reads them: faults, and what has no counterpart."""

from __future__ import annotations

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.source import Span

MOST_FAULTS = 50
"""How many faults of a file are told; the rest would only repeat them."""


class FaultList:
    """`found` keeps a file from being read; `told` is left out, or taken over as something else."""

    def __init__(self) -> None:
        self.found: list[Diagnostic] = []
        self.told: list[Diagnostic] = []

    def add(self, code: str, span: Span, message: str, help: str | None = None) -> None:
        """Note a fault, once. Raises SourceError when there are too many."""
        fault = Diagnostic(code, message, span, help=help)
        if fault not in self.found:
            self.found.append(fault)
        if len(self.found) >= MOST_FAULTS:
            self.end()

    def note(self, span: Span, message: str) -> None:
        """Tell what has no counterpart."""
        self.told.append(Diagnostic("W0019", message, span))

    def end(self) -> None:
        """Raises SourceError where there was a fault."""
        if self.found:
            raise SourceError(sorted(self.found, key=_place))


def _place(fault: Diagnostic) -> tuple[str, int]:
    return ("", 0) if fault.span is None else (fault.span.file, fault.span.start)
