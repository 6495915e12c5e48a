"""Any change to a good program gives diagnostics or a problem, never a traceback."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from tamplang.compiler.pipeline import check_sources
from tamplang.langs.codes import CODES
from tamplang.langs.source import Source

ROOT = Path(__file__).parents[2]
FILES = sorted([*(ROOT / "examples").glob("*.tamp"), *(ROOT / "tests/programs/good").glob("[lo]*.tamp")])
LIBRARY = [Source(f"std/{p.name}", p.read_text()) for p in sorted((ROOT / "stdlib").glob("*.tamp"))]
TOKEN = re.compile(r"\w+(?:\.\d+)?|[^\s\w]")
FOREIGN = [
    "0",
    "-1",
    "2.5",
    "3 m",
    "90 deg",
    "ANY",
    "c",
    "X",
    "c[1]",
    "c.A",
    "(",
    ")",
    "{",
    "}",
    "[on X A]",
    "prune",
    "base",
    "(0, 0)",
    "length(c)",
    "if",
    "..",
    "module",
    '"x"',
    "pose(X, Y)",
    "1 .. 2",
    "distance(X, X)",
]


def mutated(text: str, chance: random.Random) -> str:
    """One word or sign is dropped, doubled, exchanged for another of the text or for a foreign one."""
    tokens = [m.span() for m in TOKEN.finditer(re.sub(r"#[^\n]*", lambda m: " " * len(m[0]), text))]
    start, end = chance.choice(tokens)
    kind = chance.randrange(4)
    other = text[slice(*chance.choice(tokens))]
    middle = ["", text[start:end] + " " + text[start:end], other, chance.choice(FOREIGN)][kind]
    return text[:start] + middle + text[end:]


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_mutations_of_programs(path: Path) -> None:
    chance = random.Random(path.stem)
    text = path.read_text()
    for _ in range(12):
        changed = mutated(text, chance)
        for diagnostic in check_sources([Source(str(path), changed), *LIBRARY]):
            assert diagnostic.code in CODES
            assert diagnostic.message


@pytest.mark.parametrize("seed", range(4))
def test_mutations_of_the_library(seed: int) -> None:
    chance = random.Random(seed)
    main = Source("climb.tamp", (ROOT / "examples/climb.tamp").read_text())
    for _ in range(5):
        changed = chance.choice(LIBRARY)
        library = [Source(s.path, mutated(s.text, chance)) if s is changed else s for s in LIBRARY]
        for diagnostic in check_sources([main, *library]):
            assert diagnostic.code in CODES
