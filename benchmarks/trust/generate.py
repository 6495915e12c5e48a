"""Programs to try the toolchain with: texts changed by chance, and sentences of the grammar."""

from __future__ import annotations

import math
import re
from pathlib import Path
from random import Random
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
TOKEN = re.compile(r"\w+(?:\.\d+)?|\"[^\"\n]*\"|[^\s\w]")
FOREIGN = [
    "0", "-1", "2.5", "3 m", "90 deg", "1e308", "1e-320", "999999999999", "ANY", "X", "c[1]", "c.A", "(", ")", "{", "}",
    "[", "]", "[on X A]", "prune", "base", "(0, 0)", "length(c)", "if", "..", "module", '"x"', "pose(X, Y)", "1 .. 2",
    "distance(X, X)", "#", "##", "é", "٣", "\t", "\r", "\u2028", "\x00", "🤖", ",", ":", "=", "not",
    "for k in 1 .. 3 {", "chain of module by connected", "/ 0", "previous is", "symmetric", "functional in A",
    "import std.rules",
]  # fmt: skip
NAMES = [
    "a",
    "A",
    "B",
    "X",
    "Y",
    "c",
    "x",
    "n",
    "i",
    "p",
    "q",
    "foot",
    "grip",
    "stair",
    "plate",
    "climb",
    "crawler",
] * 4
NAMES += ["on", "base", "object", "module", "effector", "step", "box"]
NUMBERS = ["0", "1", "2", "3", "0.5", "3 m", "5 cm", "90 deg", "2 s", "1 m/s", "1e3", "1 rad/s^2", "1000000"]
TEXTS = ['"a.tamp"', '"arm.urdf"', '"rock.stl"', '""']


def corpus() -> dict[str, str]:
    """The programs of the library, the examples and the tests, by path."""
    folders = ["stdlib", "examples", "tests/programs/good", "tests/programs/bad"]
    files = [f for folder in folders for f in sorted((ROOT / folder).glob("*.tamp"))]
    return {str(f.relative_to(ROOT)): f.read_text(encoding="utf-8", errors="replace") for f in files}


def mutated(text: str, chance: Random) -> str:
    """One to three changes of tokens, characters or lines."""
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        text = chance.choice([_token, _token, _character, _line])(text, chance)
    return text


def _token(text: str, chance: Random) -> str:
    found = [m.span() for m in TOKEN.finditer(text)]
    if not found:
        return chance.choice(FOREIGN)
    start, end = chance.choice(found)
    other = text[slice(*chance.choice(found))]
    middle = chance.choice(["", f"{text[start:end]} {text[start:end]}", other, chance.choice(FOREIGN)])
    return text[:start] + middle + text[end:]


def _character(text: str, chance: Random) -> str:
    at = chance.randrange(len(text) + 1)
    kind = chance.randrange(3)
    if kind == 0:
        return text[:at] + text[at + 1 :]
    return text[:at] + chance.choice(FOREIGN)[0] + text[at + kind - 1 :]


def _line(text: str, chance: Random) -> str:
    lines = text.split("\n")
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    match chance.randrange(4):
        case 0:
            del lines[one]
        case 1:
            lines.insert(other, lines[one])
        case 2:
            lines[one], lines[other] = lines[other], lines[one]
        case _:
            lines = lines[:one]
    return "\n".join(lines)


class Grammar:
    """Sentences of the grammar of the language, of bounded depth."""

    def __init__(self) -> None:
        from tamplang.langs.grammar_loader import build, grammar_text

        parser = build(grammar_text())
        self.rules: dict[str, list[list[Any]]] = {}
        for rule in parser.rules:
            self.rules.setdefault(str(rule.origin.name), []).append(list(rule.expansion))
        self.words = {t.name: self._word(t) for t in parser.terminals}
        self.depth = {name: math.inf for name in self.rules}
        changed = True
        while changed:
            changed = False
            for name, expansions in self.rules.items():
                least = 1 + min(self._deep(e) for e in expansions)
                if least < self.depth[name]:
                    self.depth[name], changed = least, True

    @staticmethod
    def _word(terminal: Any) -> list[str]:
        value = terminal.pattern.value
        known = {"NAME": NAMES, "NUMBER": NUMBERS, "STRING": TEXTS}
        if terminal.name in known:
            return known[terminal.name]
        plain = value.replace("(?!\\w)", "").removeprefix("(?:").removesuffix(")")
        words = [w.replace("\\", "") for w in plain.removeprefix("(").split("|")]
        return words if type(terminal.pattern).__name__ == "PatternRE" else [value]

    def _deep(self, expansion: list[Any]) -> float:
        return max((self.depth[str(s.name)] for s in expansion if not s.is_term), default=0)

    def sentence(self, chance: Random, most: int = 14) -> str:
        """A program of up to eight declarations."""
        heads = ["import std.logic\nimport std.motion", "import std.rules", ""]
        parts = [chance.choice(heads)]
        parts += [" ".join(self._derive("declaration", chance, most)) for _ in range(chance.randrange(1, 9))]
        return "\n".join(parts) + "\n"

    def _derive(self, name: str, chance: Random, left: int) -> list[str]:
        expansions = self.rules[name]
        short = [e for e in expansions if self._deep(e) < left]
        chosen = chance.choice(short or [min(expansions, key=self._deep)])
        found: list[str] = []
        for symbol in chosen:
            if symbol.is_term:
                found.append(chance.choice(self.words[str(symbol.name)]))
            else:
                found += self._derive(str(symbol.name), chance, left - 1)
        return found
