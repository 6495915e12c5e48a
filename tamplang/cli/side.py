"""What commands that work in several processes have in common: their options and their errors."""

from __future__ import annotations

import re
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import click

from .parameters import WholeNumber
from .sources import SourceFailure

Command = TypeVar("Command", bound=Callable[..., Any])

_ADDRESS = re.compile(r"tcp://([\w.-]+|\[[0-9A-Fa-f:.]+\]):\d{1,5}", re.ASCII)


def _address(context: click.Context, option: click.Parameter, text: str | None) -> str | None:
    if text is not None and not _ADDRESS.fullmatch(text):
        raise click.BadParameter(f"{text!r} is not of the form tcp://HOST:PORT")
    return text


def side_options(command: Command) -> Command:
    """The options `--jobs` and `--cluster`, of which only one can be given."""
    cluster = click.option("--cluster", metavar="ADDRESS", callback=_address, help="Work on a cluster, tcp://HOST:PORT.")
    jobs = click.option("--jobs", type=WholeNumber(1, 1024), help="Processes side by side.  [default: 1]")
    return jobs(cluster(command))


def checked_side(jobs: int | None, cluster: str | None) -> None:
    """Raises click.UsageError when both are given."""
    if cluster is not None and jobs is not None:
        raise click.UsageError("--jobs and --cluster exclude each other")


@contextmanager
def needing_cluster(as_json: bool) -> Iterator[None]:
    """Turns ClusterUnavailable into its diagnostic."""
    from ..langs.diagnostics import Diagnostic
    from ..runtime.parallel import ClusterUnavailable

    try:
        yield
    except ClusterUnavailable as error:
        raise SourceFailure([Diagnostic("S0006", error.message, help=error.hint)], as_json) from error


@contextmanager
def without_broken_pipes() -> Iterator[None]:
    """A worker that is gone must not end this process."""
    before = signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGPIPE, before)
