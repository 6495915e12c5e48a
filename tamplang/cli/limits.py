"""The options `--time` and `--memory`, and what is told when one of them is spent."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from .parameters import Seconds
from .sources import as_objects, show_diagnostics
from .status import ExitStatus

if TYPE_CHECKING:
    from ..langs.diagnostics import Diagnostic
    from ..runtime.guard import Guard

Command = TypeVar("Command", bound=Callable[..., Any])
UNITS = {"": 1, "B": 1, "KB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12,
         "KIB": 2**10, "MIB": 2**20, "GIB": 2**30, "TIB": 2**40}  # fmt: skip
_SIZE = re.compile(r"\s*([0-9]+(?:\.[0-9]+)?)\s*([KMGT]?i?B|)\s*", re.IGNORECASE)


def _bytes(context: click.Context, option: click.Parameter, text: str | None) -> int | None:
    """An amount of memory such as 2GB or 512MiB."""
    if text is None:
        return None
    match = _SIZE.fullmatch(text)
    size = 0 if match is None else int(float(match[1]) * UNITS[match[2].upper()])
    if not 0 < size < 2**62:
        raise click.BadParameter(f"{text!r} is no amount of memory, such as 2GB or 500MB")
    return size


memory_option = click.option(
    "--memory", callback=_bytes, metavar="SIZE", help="Memory, such as 2GB.  [default: 80 % of what is free]"
)
time_option = click.option("--time", "seconds", type=Seconds(), default=math.inf, help="Seconds.  [default: no limit]")


def limit_options(command: Command) -> Command:
    """`--time`, without limit unless it is given, and `--memory`."""
    return time_option(memory_option(command))


class Spent(click.ClickException):
    """Time or memory is spent before there was anything to show."""

    exit_code = ExitStatus.NO_PLAN

    def __init__(self, diagnostic: Diagnostic, as_json: bool = False) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic
        self.as_json = as_json

    @property
    def status(self) -> str:
        """As of an outcome."""
        return "memory" if self.diagnostic.code == "S0010" else "budget"

    def show(self, file: Any = None) -> None:
        """Print the diagnostic on standard error, and with `as_json` one object on standard output too."""
        show_diagnostics([self.diagnostic])
        if self.as_json:
            click.echo(json.dumps({"status": self.status, "diagnostics": as_objects([self.diagnostic])}))


@contextmanager
def limited(
    seconds: float | None, memory: int | None, doing: str, as_json: bool = False, processes: int = 1,
    started: float | None = None,
) -> Iterator[Guard]:  # fmt: skip
    """Around all that a command does: raises Spent once its seconds, or its memory, are spent in spite of all.

    `doing` says what it is about, until `guard.doing` says otherwise. Seconds count from `started`, else from when the
    command line began to run; None and infinity are no limit.
    """
    from ..runtime.budget import OutOfTime, is_out_of_memory
    from ..runtime.guard import answered, guarded, memory_limit

    limit = None if seconds is None or math.isinf(seconds) else seconds
    try:
        with guarded(limit, memory_limit(memory, processes), started or _started()) as guard:
            guard.doing = doing
            yield guard
    except (OutOfTime, MemoryError, RuntimeError, SystemError) as error:
        answered()
        if is_out_of_memory(error):
            raise Spent(out_of_memory(f"while {guard.doing}"), as_json) from None
        if not isinstance(error, OutOfTime):
            raise
        raise Spent(out_of_time(guard.seconds, f"while {guard.doing}"), as_json) from None


def _started() -> float | None:
    """When the command line began to run, where that is known."""
    context = click.get_current_context(silent=True)
    return context.obj if context is not None and isinstance(context.obj, float) else None


def total(given: float | None, own: float | None, otherwise: float) -> float | None:
    """The seconds of a command: those given, else the task's own, else the default; None without limit."""
    seconds = next(s for s in (given, own, otherwise) if s is not None)
    return None if math.isinf(seconds) else seconds


def out_of_time(seconds: float | None, where: str) -> Diagnostic:
    from ..langs.diagnostics import Diagnostic

    return Diagnostic("S0003", f"{seconds or 0.0:g} s are spent {where}", help="give more with --time")


def unfinished_report(file: Path) -> Diagnostic:
    from ..langs.diagnostics import Diagnostic

    help = f"give more, or draw the plan by itself: tamplang report PLAN.json --out {file}"
    return Diagnostic("S0003", f"time or memory were spent before the report {file} was written", help=help)


def out_of_memory(where: str) -> Diagnostic:
    from ..langs.diagnostics import Diagnostic

    return Diagnostic("S0010", f"the memory is spent {where}", help="give more with --memory, or a smaller instance")
