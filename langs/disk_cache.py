"""What can be made again, kept on the disk for the next process of this user."""

from __future__ import annotations

import hashlib
import os
import pickle
import stat
from contextlib import suppress
from pathlib import Path

from .writer import write_atomically

DIGEST = hashlib.sha256().digest_size
"""Bytes of the digest with which a sealed file begins."""
UNREADABLE = (
    OSError, pickle.UnpicklingError, EOFError, AttributeError, ImportError, IndexError, KeyError, TypeError, ValueError,
)  # fmt: skip
"""What unpickling may raise where another version has written."""


def cache_folder() -> Path:
    """Where what can be made again is kept."""
    root = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(root) / "tamplang"


def recalled(file: Path) -> bytes | None:
    """What a file of the cache holds; None where there is none, or it is no plain file that this user owns."""
    try:
        known = file.stat()
        if not stat.S_ISREG(known.st_mode) or (hasattr(os, "getuid") and known.st_uid != os.getuid()):
            return None
        return file.read_bytes()
    except OSError:
        return None


def keep(file: Path, content: bytes) -> None:
    """Write a file of the cache in one step, so that no other process ever reads half of it; give up silently."""
    with suppress(OSError):
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_atomically(file, content)


def keep_sealed(file: Path, content: bytes) -> None:
    """Keep what will be unpickled behind its digest."""
    keep(file, hashlib.sha256(content).digest() + content)


def recalled_sealed(file: Path) -> bytes | None:
    """What was kept so, where it is whole: damaged tables may load and say wrong things."""
    content = recalled(file)
    if content is None or hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
        return None
    return content[DIGEST:]
