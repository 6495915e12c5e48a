"""Names of others as names of this language: letters, digits and underscores, no word of the language, each once."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

from ...langs.words import JOINTS, RESERVED, SHAPES, TYPES, WORDS
from ..builtins import FUNCTIONS
from ..standard import declared

TAKEN = frozenset({*RESERVED, *WORDS, *TYPES, *SHAPES, *JOINTS, *FUNCTIONS})
NO_PREDICATES = frozenset({*RESERVED, "min", "max", "sum", "previous"})
"""Behind an opening bracket all other words of the language are names."""
STANDARD = declared("docking", "logic", "motion", "rules")
"""What the texts declare that importers name: a module or body has another name."""


def plain_name(text: str, words: Collection[str] = TAKEN) -> str:
    """`text` as a name that is none of `words`, not yet unlike all others."""
    name = re.sub(r"[^A-Za-z0-9_]", "_", text).strip("_") or "n"
    if not name[0].isalpha():
        name = f"n_{name}"
    return f"{name}_" if name in words else name


class GivenNames:
    """Names of one kind by what others call them: the same question gets the same answer."""

    def __init__(self, taken: Iterable[str] = (), words: Collection[str] = TAKEN) -> None:
        self._given: dict[str, str] = {}
        self._words = words
        self._taken = set(taken)

    def __getitem__(self, text: str) -> str:
        if text not in self._given:
            self._given[text] = self.fresh(text)
        return self._given[text]

    def fresh(self, text: str) -> str:
        """A name like `text` that is not taken yet, and now is."""
        name = base = plain_name(text, self._words)
        number = 2
        while name in self._taken:
            name, number = f"{base.rstrip('_')}_{number}", number + 1
        self._taken.add(name)
        return name

    def take(self, name: str) -> None:
        """Keep `name` from being given."""
        self._taken.add(name)

    def release(self, name: str) -> None:
        """Let `name` be given again."""
        self._taken.discard(name)
