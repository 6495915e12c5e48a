"""The command `tamplang`. Every command loads what it needs when it runs, so that the quick ones feel instant."""

from __future__ import annotations

import errno
import gc
import os
import signal
import sys
import time
from collections.abc import Sequence
from io import BufferedWriter, RawIOBase, TextIOWrapper

import click

from ..runtime.guard import process_age
from ..runtime.native import use_one_thread
from .crash import report_crash
from .status import ExitStatus

SURROUNDINGS = (
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.EACCES, errno.EPERM, errno.ENOENT,
    errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP, errno.EMFILE, errno.ENFILE, errno.ESTALE,
)  # fmt: skip
"""What a disk says that is full, broken, gone or forbidden: no fault of the program, and not always to be found out
beforehand."""


COLLECTED = (20_000, 20, 20)
"""How much is made before Python looks for cycles of garbage: a solve makes many objects and few cycles."""


def main() -> int:
    """Run the command line of this process and give its exit status; nothing but the end of the process may follow."""
    # A reader that closes the pipe, such as `head`, ends the process without a word, as it does other Unix commands.
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    sys.excepthook = report_crash
    _open_closed_streams()
    _buffer_streams()
    use_one_thread()
    gc.set_threshold(*COLLECTED)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # for terminals that cannot show every character
    status = _written(run(sys.argv[1:], time.monotonic() - process_age()))
    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # while Python ends, Ctrl-C would show a traceback
    gc.freeze()  # nothing is looked through once more only to end
    return status


def _open_closed_streams() -> None:
    """A closed stream is one that takes everything. Else the next file to be opened got its number, and what libraries
    print would land in it."""
    for name, flags in (("stdin", os.O_RDONLY), ("stdout", os.O_WRONLY), ("stderr", os.O_WRONLY)):
        if getattr(sys, name) is None:
            mode = "r" if flags == os.O_RDONLY else "w"
            setattr(sys, name, os.fdopen(os.open(os.devnull, flags), mode, encoding="utf-8", errors="replace"))


def _buffer_streams() -> None:
    """Standard streams write all they are given. Without a buffer (`python -u`, PYTHONUNBUFFERED) what a write to a
    pipe leaves when a signal comes is lost without a word, and the guard has one come twenty times a second."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        raw = stream.buffer if isinstance(stream, TextIOWrapper) else None
        if isinstance(raw, RawIOBase):
            whole = TextIOWrapper(BufferedWriter(raw), stream.encoding, stream.errors, line_buffering=True)
            setattr(sys, name, whole)


def _written(status: int) -> int:
    """The status of a command once its streams have written what they hold; what they cannot write is given up, else
    Python would complain of it as it ends."""
    for stream in (sys.stdout, sys.stderr):
        if stream.closed:  # as a server's is whose client has gone
            continue
        try:
            stream.flush()
        except OSError as error:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
            if status == ExitStatus.DONE:
                click.echo(f"Error: cannot write: {error.strerror}", err=True)
                status = ExitStatus.USAGE
    return status


def run(arguments: Sequence[str], started: float | None = None) -> int:
    """Run one command line and give its exit status (`ExitStatus`). Its time counts from `started`, else from now. What
    goes wrong is told on standard error."""
    try:
        from .app import application

        since = time.monotonic() if started is None else started
        status = application.main(args=list(arguments), prog_name="tamplang", standalone_mode=False, obj=since)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return ExitStatus.INTERRUPTED
    except OSError as error:
        if error.errno not in SURROUNDINGS:
            raise
        where = f" {error.filename}" if error.filename is not None else ""
        if error.errno == errno.ENOENT and error.filename is None:
            where = " the current folder"  # all that is asked for without a name
        verb = "use" if error.errno in (errno.ENOENT, errno.ENOTDIR, errno.ELOOP) else "write"
        click.echo(f"Error: cannot {verb}{where}: {error.strerror}", err=True)
        return ExitStatus.USAGE
    return status if isinstance(status, int) else ExitStatus.DONE
