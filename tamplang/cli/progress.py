"""How far a run is, on standard error: a bar with the time left on a terminal, plain lines elsewhere."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from ..langs.counting import counted

if TYPE_CHECKING:
    from ..runtime.planner.lgp import Progress

SECONDS_BETWEEN_LINES = 1.0


def volume_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """`--quiet` and `--verbose`, which the command gets as `volume`: -1, 0 or 1."""

    @functools.wraps(command)
    def with_volume(*args: Any, quiet: bool, verbose: bool, **kwargs: Any) -> Any:
        if quiet and verbose:
            raise click.UsageError("--quiet and --verbose do not go together")
        return command(*args, volume=verbose - quiet, **kwargs)

    loud = click.option("--verbose", is_flag=True, help="Tell every step of the planner, one a line.")
    silent = click.option("-q", "--quiet", is_flag=True, help="Tell nothing on the way: results and errors only.")
    return silent(loud(with_volume))


@contextmanager
def shown_progress(check: Callable[[], None], volume: int) -> Iterator[Callable[[Progress], None]]:
    """Give the callback for `runtime.lgp.solve`, which runs `check` first; the bar vanishes when the run ends. With
    `volume` -1 nothing is shown, with 1 every step, one a line."""
    if volume < 0:
        yield lambda progress: check()
        return
    if volume > 0 or not sys.stderr.isatty():
        yield _plain_lines(check, 0.0 if volume > 0 else SECONDS_BETWEEN_LINES)
        return
    from .bar import bar

    with bar() as shown:
        task = shown.add_task("starting", total=None, detail="")

        def show(progress: Progress) -> None:
            check()
            shown.update(
                task,
                description=progress.stage,
                total=progress.limit,
                completed=progress.elapsed,
                detail=describe(progress),
            )

        yield show


def describe(progress: Progress) -> str:
    """What is done, and how many nodes, candidates and solutions there are."""
    parts = [progress.message] if progress.message else []
    parts.append(counted(progress.tree_nodes, "node"))
    if progress.candidates:
        parts.append(counted(progress.candidates, "candidate"))
    if progress.solutions:
        parts.append(counted(progress.solutions, "solution"))
    return ", ".join(parts)


def _plain_lines(check: Callable[[], None], between: float) -> Callable[[Progress], None]:
    last = float("-inf")

    def show(progress: Progress) -> None:
        nonlocal last
        check()
        if progress.elapsed - last < between:
            return
        last = progress.elapsed
        left = "" if progress.limit is None else f", {max(0.0, progress.limit - progress.elapsed):.0f} s left"
        line = f"{progress.elapsed:6.1f} s  {progress.stage}: {describe(progress)}{left}"
        print(line, file=sys.stderr, flush=True)

    return show
