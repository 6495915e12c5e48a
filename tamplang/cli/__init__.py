"""The command `tamplang`. Every command loads what it needs when it runs, so that the quick ones feel instant."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click

from .crash import report_crash
from .status import ExitStatus


def main() -> None:
    """Entry point of the console script: runs the command line and ends the process with its exit status."""
    sys.excepthook = report_crash
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Run one command line and give its exit status (`ExitStatus`). What goes wrong is told on standard error."""
    from .app import application

    try:
        status = application.main(args=list(arguments), prog_name="tamplang", standalone_mode=False)
        sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return ExitStatus.INTERRUPTED
    except BrokenPipeError:
        # The reader of a pipe is gone: keep the interpreter from failing once more when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return ExitStatus.BROKEN_PIPE
    return status if isinstance(status, int) else ExitStatus.DONE
