"""How far a run is, on standard error: a bar with the time left on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..runtime.planner.lgp import Progress

SECONDS_BETWEEN_LINES = 1.0


@contextmanager
def shown_progress(check: Callable[[], None]) -> Iterator[Callable[[Progress], None]]:
    """Give the callback for `runtime.lgp.solve`, which runs `check` first; the bar vanishes when the run ends."""
    if not sys.stderr.isatty():
        yield _plain_lines(check)
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


def counted(number: int, noun: str) -> str:
    """`1 node`, `2 nodes`."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _plain_lines(check: Callable[[], None]) -> Callable[[Progress], None]:
    last = float("-inf")

    def show(progress: Progress) -> None:
        nonlocal last
        check()
        if progress.elapsed - last < SECONDS_BETWEEN_LINES:
            return
        last = progress.elapsed
        left = "" if progress.limit is None else f", {max(0.0, progress.limit - progress.elapsed):.0f} s left"
        line = f"{progress.elapsed:6.1f} s  {progress.stage}: {describe(progress)}{left}"
        print(line, file=sys.stderr, flush=True)

    return show
