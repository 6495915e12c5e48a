"""The record behind one code of `codes.py`, and the programs that show it, which lie in `explanations/CODE.md`."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from .frozen import dataclass

FOLDER = Path(__file__).parent / "explanations"
MAIN = "example.tamp"
_BLOCK = re.compile(r"^```(\w+) (wrong|right|both)( hidden)?(?: (\S+))?\n(.*?)\n?^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True, slots=True)
class Passage:
    """A file by the name `file`, or commands of a shell where it is empty. What is `hidden` only sets the stage."""

    file: str
    language: str
    text: str
    hidden: bool = False

    @property
    def heading(self) -> str:
        """What says which file this is, empty where there can be no doubt."""
        return "" if self.file in ("", MAIN) else self.file


@dataclass(frozen=True, slots=True)
class Example:
    """Files of a folder, and the commands that are tried there; without any it is `tamplang check example.tamp`."""

    blocks: tuple[Passage, ...]

    @property
    def files(self) -> dict[str, str]:
        return {block.file: f"{block.text}\n" for block in self.blocks if block.file}

    @property
    def commands(self) -> str:
        return "\n".join(block.text for block in self.blocks if not block.file)

    @property
    def shown(self) -> tuple[Passage, ...]:
        return tuple(block for block in self.blocks if not block.hidden)


@dataclass(frozen=True, slots=True)
class CodeInfo:
    """`category` is one of file, syntax, name, type, logic, motion, scene, warning, outcome."""

    title: str
    category: str
    explanation: str

    def text(self, code: str) -> str:
        """The explanation as the user reads it on a terminal."""
        parts = [f"{code}: {self.title} ({self.category})", self.explanation]
        for kind, example in zip(("Wrong", "Right"), examples(code), strict=True):
            for index, block in enumerate(example.shown):
                heading = f"{kind}:" if index == 0 else ""
                name = f"{block.heading}:" if block.heading else ""
                lines = "\n".join(f"    {line}".rstrip() for line in block.text.split("\n"))
                parts.append("\n".join(x for x in (heading, name, lines) if x))
        return "\n\n".join(parts)


@cache
def examples(code: str) -> tuple[Example, Example]:
    """What gives the code, and how it is right. Raises OSError where the file of the code is missing."""
    text = (FOLDER / f"{code}.md").read_text(encoding="utf-8")
    both: tuple[list[Passage], list[Passage]] = [], []
    for language, kind, hidden, name, content in _BLOCK.findall(text):
        file = name or (MAIN if language == "tamp" else "")
        for index, side in enumerate(("wrong", "right")):
            if kind in (side, "both"):
                both[index].append(Passage(file, language, content, bool(hidden) or (kind == "both" and index == 1)))
    return Example(tuple(both[0])), Example(tuple(both[1]))
