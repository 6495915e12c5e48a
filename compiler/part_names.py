"""How the parts of modules are called in messages."""

from __future__ import annotations

import itertools
from collections.abc import Sequence


def part_names(thing: str, objects: Sequence[str]) -> list[str]:
    """How the parts of a thing are called that belong to `objects`: effectors, or the thing itself, whose links are
    numbered from 1."""
    links = itertools.count(1)
    alone = len(objects) == 1
    return [f"{thing} link {next(links)}" if name == thing and not alone else name for name in objects]
