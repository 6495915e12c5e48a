"""No module imports a room by its bare name: that would load it a second time, beside `tamplang.<room>`."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = {"langs", "compiler", "runtime", "stdlib"}
FOLDERS = ("langs", "compiler", "runtime", "tamplang/cli", "tests", "benchmarks")
FILES = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")) + sorted(
    ROOT.glob("tamplang/*.py")
)


def bare_imports(text: str) -> set[str]:
    """The rooms that a module imports by their bare names."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            found.add(node.module.partition(".")[0])
    return found & ROOMS


def test_bare_imports_are_found() -> None:
    assert bare_imports("import compiler.ir\nfrom langs import syntax\nfrom ..runtime import plan") == {
        "compiler",
        "langs",
    }


@pytest.mark.parametrize("room", ["langs", "compiler", "runtime", "tamplang", "tests", "benchmarks"])
def test_no_bare_imports(room: str) -> None:
    bare = {path: bare_imports(path.read_text(encoding="utf-8")) for path in FILES if path.is_relative_to(ROOT / room)}
    assert not {path: names for path, names in bare.items() if names}
