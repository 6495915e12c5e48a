"""Writes docs/stdlib.md from the texts of the standard library and their doc comments: python docs/write_stdlib.py"""

from __future__ import annotations

import re
from pathlib import Path

from tamplang.compiler.standard import EXTENSION, STANDARD, STANDARD_FOLDER
from tamplang.langs import syntax
from tamplang.langs.parser import parse
from tamplang.langs.reader import read_source
from tamplang.langs.source import Source

INTRODUCTION = """# The standard library

What each file of `std` declares, from its own text and doc comments: `python docs/write_stdlib.py` writes this page.
What is imported brings along what it imports itself."""
KINDS = (
    ("Types", syntax.TypeDecl), ("Predicates", syntax.PredicateDecl), ("Derived predicates", syntax.DerivedDecl),
    ("Functions", syntax.FunctionDecl), ("Motion predicates", syntax.MotionDecl), ("Rules", syntax.RuleDecl),
    ("Placements", syntax.PlacementDecl), ("Heuristics", syntax.HeuristicDecl), ("Modules", syntax.ModuleDecl),
    ("Scenes", syntax.SceneDecl), ("Tasks", syntax.TaskDecl),
)  # fmt: skip
WHOLE = (syntax.MotionDecl, syntax.RuleDecl, syntax.DerivedDecl)
"""Declarations whose text says it best: rows, conditions and effects."""


def text() -> str:
    """The page. A test refuses one that is not what this gives."""
    files = sorted(STANDARD_FOLDER.glob(f"*{EXTENSION}"))
    return "\n\n".join([INTRODUCTION, *(part for file in files for part in _file(file))]) + "\n"


def _file(path: Path) -> list[str]:
    source = Source(path.name, read_source(path).text)
    tree, _ = parse(source)
    imports = [f"`{d.target}`" for d in tree.declarations if isinstance(d, syntax.Import)]
    parts = [f"## {STANDARD}.{path.stem}", *_head(source.text)]
    parts += [f"Imports {', '.join(imports)}."] if imports else []
    for title, kind in KINDS:
        own = [d for d in tree.declarations if isinstance(d, kind)]
        parts += [f"### {title} of {STANDARD}.{path.stem}"] if own else []
        parts += [part for d in own for part in _declaration(source, d)]
    return parts


def _head(text: str) -> list[str]:
    """The comment at the top of a file."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("# "):
            break
        lines.append(line[2:])
    return ["\n".join(lines)] if lines else []


def _declaration(source: Source, declaration: syntax.Node) -> list[str]:
    written = source.text[declaration.span.start : declaration.span.end]
    if not isinstance(declaration, WHOLE):
        written = re.sub(r"\s*(?:\{.*|=\s*$)", "", written, flags=re.DOTALL)
    block = f"```text\n{written.rstrip()}\n```"
    doc = getattr(declaration, "doc", "")
    return [" ".join(doc.split()), block] if doc else [block]


if __name__ == "__main__":
    (Path(__file__).parent / "stdlib.md").write_text(text(), encoding="utf-8")
