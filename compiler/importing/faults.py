"""What is to be said of foreign files, whatever reads them: faults, and what has no counterpart."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.source import Span
from ..ir import Pose
from ..named_meshes import UnreadMesh
from .mesh_forms import MeshReader
from .models import Form

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

    def note(self, span: Span, message: str, code: str = "W0019") -> None:
        """Tell what has no counterpart, or what stands for a mesh (W0006), once."""
        told = Diagnostic(code, message, span)
        if told not in self.told:
            self.told.append(told)

    def mesh(
        self, span: Span, reader: MeshReader, name: str, scale: Sequence[float], place: Pose, path: str | None = None
    ) -> list[Form]:
        """The forms of a mesh, with what is to be told of them; nothing, and a fault or a note, where there are
        none."""
        try:
            forms, told = reader.forms(name, scale, place, path)
        except UnreadMesh as reason:
            if reason.left_out:
                self.note(span, str(reason))
            else:
                self.add("E0515", span, str(reason))
            return []
        self.note(span, told, "W0006")
        return forms

    def end(self) -> None:
        """Raises SourceError where there was a fault."""
        if self.found:
            raise SourceError(sorted(self.found, key=_place))


def _place(fault: Diagnostic) -> tuple[str, int]:
    return ("", 0) if fault.span is None else (fault.span.file, fault.span.start)
