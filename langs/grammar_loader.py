"""The LALR parser of the language: the grammar files joined, and a cache of the built tables on disk."""

from __future__ import annotations

import hashlib
import io
import sys
from functools import cache
from pathlib import Path

import lark

from .disk_cache import UNREADABLE, cache_folder, keep_sealed, recalled_sealed

PARTS = ("tamplang", "terms", "logic", "modules", "physics", "motion", "rules", "heuristics", "scenes", "tasks")
_FOLDER = Path(__file__).parent / "grammar"


def grammar_text() -> str:
    """The whole grammar in Lark's notation."""
    return "\n".join((_FOLDER / f"{part}.lark").read_text(encoding="utf-8") for part in PARTS)


def build(text: str, strict: bool = False) -> lark.Lark:
    """The parser for grammar `text`; `strict` makes Lark refuse every ambiguity between terminals."""
    return lark.Lark(text, parser="lalr", lexer="contextual", propagate_positions=True, strict=strict)


@cache
def parser() -> lark.Lark:
    """The parser, from the cache where there is one; without a usable cache it is built, which takes 0.2 s more."""
    text = grammar_text()
    version = f"{lark.__version__} {sys.version}"
    key = hashlib.sha256(f"{version}\n{text}".encode()).hexdigest()[:24]
    file = cache_folder() / f"grammar-{key}.bin"
    loaded = load_cached(file)
    if loaded is not None:
        return loaded
    built = build(text)
    store(built, file)
    return built


def load_cached(file: Path) -> lark.Lark | None:
    """The cached parser, or None. The file is unpickled, so only a plain one that this user owns is opened, and only
    tables that are whole by their digest are used: damaged ones may load and read texts wrongly."""
    try:
        tables = recalled_sealed(file)
        return None if tables is None else lark.Lark.load(io.BytesIO(tables))
    except UNREADABLE:
        return None


def store(built: lark.Lark, file: Path) -> None:
    """Keep the tables behind their digest."""
    content = io.BytesIO()
    built.save(content)
    keep_sealed(file, content.getvalue())
