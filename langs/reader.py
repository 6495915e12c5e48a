"""Files to sources, refused with a code where they are no readable text."""

from __future__ import annotations

import os
import re
import stat

from .diagnostics import Diagnostic, SourceError, did_you_mean
from .source import Source

MAX_BYTES = 1_000_000
_PLAN = re.compile(r"\s*\{\s*\"")
"""How JSON begins, and no program does."""


def read_source(path: str | os.PathLike[str]) -> Source:
    """The text of file `path`, with line ends as `\\n` and without a byte order mark.

    Raises SourceError (E0010 … E0015) when it is missing, unreadable, no regular file, empty, not UTF-8 text or
    larger than MAX_BYTES; of a larger file nothing is read.
    """
    shown = os.fspath(path)
    if not shown.isascii() and any("\ud800" <= c <= "\udfff" for c in shown):
        raise _refusal("E0011", f"cannot read {shown!r}: its name is not UTF-8 text", "rename it: plans carry names")
    return source_of(shown, read_bytes(shown))


def source_of(shown: str, content: bytes) -> Source:
    """The text that `content`, the bytes of the file shown as such, spells.

    Raises SourceError (E0013 … E0015) when it is empty, not UTF-8 text or larger than MAX_BYTES.
    """
    if len(content) > MAX_BYTES:
        raise _too_large(shown, len(content))
    if b"\0" in content:
        raise _refusal("E0014", f"`{shown}` is not a text file", "a source is text in UTF-8")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        line = content.count(b"\n", 0, e.start) + 1
        raise _refusal("E0014", f"`{shown}` is not UTF-8 text: wrong byte in line {line}", "save it as UTF-8") from None
    if _PLAN.match(text):
        help = f"`tamplang verify {shown}` checks it, `tamplang report {shown} -o page.html` draws it"
        raise _refusal("E0018", f"`{shown}` is a plan or other JSON, not a program", help)
    if not text.strip():
        raise _refusal("E0013", f"`{shown}` is empty", "`tamplang new NAME` writes a first task")
    return Source(shown, text.replace("\r\n", "\n").replace("\r", "\n"))


def read_bytes(path: str) -> bytes:
    """The bytes of a regular file, at most MAX_BYTES and one more.

    Raises SourceError (E0010 … E0012, E0015). It is opened without waiting: a pipe may have taken the file's place.
    """
    try:
        status = os.stat(path)
        if stat.S_ISDIR(status.st_mode):
            raise _refusal("E0012", f"`{path}` is a directory, not a file")
        if not stat.S_ISREG(status.st_mode):
            raise _refusal("E0012", f"`{path}` is not a regular file")
        if status.st_size > MAX_BYTES:
            raise _too_large(path, status.st_size)
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as stream:
            content = stream.read(MAX_BYTES + 1)
    except (FileNotFoundError, NotADirectoryError):
        raise _refusal("E0010", f"there is no file `{path}`", _near(path)) from None
    except ValueError:
        raise _refusal("E0010", f"{path!r} is not a file name") from None
    except OSError as e:
        raise _refusal("E0011", f"cannot read `{path}`: {e.strerror or e}") from None
    return content


def _near(path: str) -> str | None:
    """The hint to the program in the same folder that has nearly this name; or to what reads standard input."""
    if path == "-":
        return "`check` and `fmt` alone read standard input; save the program to a file"
    folder, name = os.path.split(path)
    try:
        programs = [n for n in os.listdir(folder or ".") if n.endswith(".tamp")]
    except OSError:
        return None
    exact = f"{name}.tamp"
    return f"did you mean `{exact}`?" if exact in programs else did_you_mean(name, programs)


def _too_large(path: str, size: int) -> SourceError:
    help = "use loops for large scenes" if path.endswith(".tamp") else "take it apart into smaller files"
    return _refusal("E0015", f"`{path}` is too large: {size / 1e6:.1f} MB, at most 1 MB", help)


def _refusal(code: str, message: str, help: str | None = None) -> SourceError:
    return SourceError([Diagnostic(code, message, help=help)])
