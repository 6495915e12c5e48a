"""How far a run is, on standard error: a bar with the time left on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

    from ..runtime.lgp import Progress

SECONDS_BETWEEN_LINES = 1.0


@contextmanager
def shown_progress() -> Iterator[Callable[[Progress], None]]:
    """Give the callback for `runtime.lgp.solve`, and clear the bar when the run ends."""
    if not sys.stderr.isatty():
        yield _plain_lines()
        return
    with _bar() as bar:
        task = bar.add_task("starting", total=None, detail="")

        def show(progress: Progress) -> None:
            bar.update(
                task,
                description=progress.stage,
                total=progress.limit,
                completed=progress.elapsed,
                detail=describe(progress),
            )

        yield show


def describe(progress: Progress) -> str:
    """One line: what is done, how many candidates and solutions there are, and how much time is left."""
    parts = [progress.message] if progress.message else []
    parts.append(counted(progress.tree_nodes, "node"))
    if progress.candidates:
        parts.append(counted(progress.candidates, "candidate"))
    if progress.solutions:
        parts.append(counted(progress.solutions, "solution"))
    if progress.limit is not None:
        parts.append(f"{max(0.0, progress.limit - progress.elapsed):.0f} s left")
    return ", ".join(parts)


def counted(number: int, noun: str) -> str:
    """`1 node`, `2 nodes`."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _plain_lines() -> Callable[[Progress], None]:
    last = float("-inf")

    def show(progress: Progress) -> None:
        nonlocal last
        if progress.elapsed - last >= SECONDS_BETWEEN_LINES:
            last = progress.elapsed
            print(
                f"{progress.elapsed:6.1f} s  {progress.stage}: {describe(progress)}",
                file=sys.stderr,
                flush=True,
            )

    return show


def _bar() -> Bar:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    # Without markup: the messages hold names such as `c[1]`.
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=20),
        TextColumn("{task.fields[detail]}", markup=False),
        console=Console(stderr=True),
        transient=True,
    )
