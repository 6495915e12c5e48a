"""The record behind one code of `codes.py`."""

from __future__ import annotations

from .frozen import dataclass


@dataclass(frozen=True, slots=True)
class CodeInfo:
    """`category` is one of file, syntax, name, type, logic, motion, scene, warning, outcome. `wrong` and `right` are
    short program texts, empty where an example would say nothing."""

    title: str
    category: str
    explanation: str
    wrong: str = ""
    right: str = ""

    def text(self, code: str) -> str:
        """The explanation as the user reads it on a terminal."""
        parts = [f"{code}: {self.title} ({self.category})", self.explanation]
        for heading, example in (("Wrong", self.wrong), ("Right", self.right)):
            if example:
                parts.append(f"{heading}:\n" + "\n".join("    " + line for line in example.split("\n")))
        return "\n\n".join(parts)
