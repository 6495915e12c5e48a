"""Syntax trees of sound texts, kept on the disk: to read one takes a tenth of parsing it, and needs no parser at all.

A tree is found by what it was made from: the text and its path, the code of this package, the versions of Python and
Lark. So whatever changes, nothing stale is read.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from . import syntax
from .disk_cache import UNREADABLE, cache_folder, keep_sealed, recalled_sealed
from .source import Source

MOST_KEPT = 128
"""Trees on the disk, of some 10 to 30 KB each; the oldest make room."""
MOST_OF_ONE = 24
"""Trees that one process keeps: who reads more texts is an editor, or runs many variants of one."""


class Kept:
    """How many trees this process has kept."""

    count = 0


@cache
def _making() -> bytes:
    """What trees depend on besides their text."""
    folder = Path(__file__).parent
    lark = find_spec("lark")
    told = [Path(lark.origin)] if lark is not None and lark.origin is not None else []  # where its version stands
    digest = hashlib.sha256(sys.version.encode())
    for file in (*sorted(folder.glob("*.py")), *sorted(folder.glob("grammar/*.lark")), *told):
        digest.update(file.read_bytes())
    return digest.digest()


def _file(source: Source) -> Path:
    digest = hashlib.sha256(_making())
    for part in (source.path, source.text):
        digest.update(hashlib.sha256(part.encode("utf-8", "surrogatepass")).digest())
    return cache_folder() / f"tree-{digest.hexdigest()[:32]}.bin"


def recalled_tree(source: Source) -> syntax.File | None:
    """The tree of `source`, where it was kept."""
    try:
        content = recalled_sealed(_file(source))
        tree = None if content is None else pickle.loads(content)
    except (*UNREADABLE, RecursionError):
        return None
    return tree if isinstance(tree, syntax.File) and tree.path == source.path else None


def keep_tree(source: Source, tree: syntax.File) -> None:
    """Keep the tree of a text without mistakes, where that is possible."""
    if Kept.count >= MOST_OF_ONE:
        return
    Kept.count += 1
    with suppress(OSError, RecursionError):
        file = _file(source)
        keep_sealed(file, pickle.dumps(tree, protocol=5))
        _make_room(file.parent)


def _make_room(folder: Path) -> None:
    kept = list(folder.glob("tree-*.bin"))
    if len(kept) > MOST_KEPT:
        for file in sorted(kept, key=lambda f: f.stat().st_mtime)[: len(kept) - MOST_KEPT]:
            file.unlink(missing_ok=True)
