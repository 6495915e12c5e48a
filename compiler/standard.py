"""The standard library as a folder of texts: where it lies, and which of its files declares a name."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

STANDARD = "std"
STANDARD_FOLDER = Path(__file__).parent.parent / "stdlib"
EXTENSION = ".tamp"

_DECLARATIONS = {
    "E0102": r"type\s+",
    "E0103": r"(?:predicate|derived)\s*\(\s*",
    "E0104": r"motion\s*\[\s*",
    "E0105": r"rule\s+",
    "E0106": r"heuristic\s+",
    "E0107": r"scene\s+",
    "E0108": r"module\s+",
}
"""How the declarations begin that would help against an unknown name, by the code of its diagnostic."""


def import_hint(code: str, name: str) -> str | None:
    """The hint which import would declare a name that is unknown by `code`; None where none would."""
    start = _DECLARATIONS.get(code)
    if start is None:
        return None
    pattern = re.compile(rf"^{start}{re.escape(name)}\b", re.MULTILINE)
    found = [stem for stem, text in _texts().items() if pattern.search(text)]
    if not found:
        return None
    return "the standard library declares it: " + " or ".join(f"`import {STANDARD}.{stem}`" for stem in found)


def declared(*stems: str) -> frozenset[str]:
    """The names of all that some files declare."""
    pattern = re.compile(rf"^(?:{'|'.join(_DECLARATIONS.values())})(\w+)", re.MULTILINE)
    return frozenset(name for stem in stems for name in pattern.findall(_texts()[stem]))


@cache
def _texts() -> dict[str, str]:
    """The files of the standard library by name."""
    files = sorted(STANDARD_FOLDER.glob(f"*{EXTENSION}"))
    return {path.stem: path.read_text(encoding="utf-8") for path in files}


def installed_text(name: str) -> str | None:
    """The text of `std.NAME` as it is installed; None where there is none."""
    from ..langs.diagnostics import SourceError
    from ..langs.reader import read_source

    try:
        return read_source(STANDARD_FOLDER / f"{name}{EXTENSION}").text
    except SourceError:
        return None
