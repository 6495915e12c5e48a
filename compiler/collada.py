"""What a COLLADA file says of its own unit and axes, which readers of meshes pass over."""

from __future__ import annotations

import math
from contextlib import suppress
from xml.parsers import expat


class _Found(Exception):
    """All that is looked for was met."""


def asset(content: bytes) -> tuple[float, str]:
    """The unit, in metres, and the upward axis ("X_UP", "Y_UP", "Z_UP") that the file names; 1 and "" where it names
    none. What is not XML says nothing."""
    parser = expat.ParserCreate()
    path: list[str] = []
    unit, up = 1.0, ""

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal unit
        path.append(tag.rpartition(":")[2])
        if path == ["COLLADA", "asset", "unit"]:
            try:
                value = float(attributes.get("meter", "1"))
            except ValueError:
                value = math.nan
            unit = value if 0 < value < math.inf else 1.0

    def text(words: str) -> None:
        nonlocal up
        if path == ["COLLADA", "asset", "up_axis"]:
            up += words

    def end(_: str) -> None:
        if path == ["COLLADA", "asset"]:
            raise _Found
        path.pop()

    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = begin, end, text
    with suppress(_Found, expat.ExpatError):
        parser.Parse(content, True)
    axis = up.strip()
    return unit, axis if axis in ("X_UP", "Y_UP", "Z_UP") else ""
