"""The last resort: an error that nobody foresaw becomes one sentence and a crash file."""

from __future__ import annotations

import os
import sys
from types import TracebackType

from .status import ExitStatus


def report_crash(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Write the traceback to a crash file, name it on standard error and end with status 70 (a `sys.excepthook`).
    A late Ctrl-C is no crash."""
    if issubclass(kind, KeyboardInterrupt):
        print("interrupted", file=sys.stderr)
        raise SystemExit(int(ExitStatus.INTERRUPTED))
    import platform
    import traceback

    from .. import __version__

    about = f"tamplang {__version__}, Python {platform.python_version()}, {platform.platform()}\n"
    print(f"internal error: {kind.__name__}: {error}", file=sys.stderr)
    try:
        path = _kept(f"{about}command: {sys.argv}\n\n" + "".join(traceback.format_exception(kind, error, trace)))
    except OSError as reason:
        print(f"This is a bug in tamplang. No crash file could be written: {reason.strerror}", file=sys.stderr)
    else:
        print(f"This is a bug in tamplang. Please report it with the file {path}", file=sys.stderr)
    raise SystemExit(int(ExitStatus.INTERNAL_ERROR))


def _kept(text: str) -> str:
    """The path of a new file with the text. Raises OSError, and leaves no file then."""
    import tempfile

    descriptor, path = tempfile.mkstemp(prefix="tamplang-crash-", suffix=".txt")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", errors="backslashreplace") as stream:
            stream.write(text)
    except OSError:
        os.unlink(path)
        raise
    return path
