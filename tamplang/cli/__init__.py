"""The command `tamplang`. Every command loads what it needs when it runs, so that the quick ones feel instant."""

from __future__ import annotations

import errno
import gc
import signal
import sys
from collections.abc import Sequence
from io import TextIOWrapper

import click

from ..runtime.native import use_one_thread
from .crash import report_crash
from .status import ExitStatus

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What a disk says that takes no more; for standard output nothing can find it out beforehand."""


COLLECTED = (20_000, 20, 20)
"""How much is made before Python looks for cycles of garbage: a solve makes many objects and few cycles."""


def main() -> None:
    """Entry point of the console script: runs the command line and ends the process with its exit status."""
    # A reader that closes the pipe, such as `head`, ends the process without a word, as it does other Unix commands.
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    sys.excepthook = report_crash
    use_one_thread()
    gc.set_threshold(*COLLECTED)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # for terminals that cannot show every character
    status = run(sys.argv[1:])
    if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # while Python ends, Ctrl-C would show a traceback
    sys.exit(status)


def run(arguments: Sequence[str]) -> int:
    """Run one command line and give its exit status (`ExitStatus`). What goes wrong is told on standard error."""
    try:
        from .app import application

        status = application.main(args=list(arguments), prog_name="tamplang", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return ExitStatus.INTERRUPTED
    except OSError as error:
        if error.errno not in FULL:
            raise
        click.echo(f"Error: cannot write: {error.strerror}", err=True)
        return ExitStatus.USAGE
    return status if isinstance(status, int) else ExitStatus.DONE
