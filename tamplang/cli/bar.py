"""The progress bar of a terminal. Loaded only where there is one."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn
from rich.text import Text


class TimeLeft(ProgressColumn):
    """What is left of the budget; goes on counting between two messages."""

    def render(self, task: Task) -> Text:
        if task.total is None or task.elapsed is None:
            return Text("")
        return Text(f"{max(0.0, task.total - task.elapsed):.0f} s left")


def bar() -> Progress:
    """A bar on standard error that vanishes when the run ends; its tasks have a field `detail`."""
    # Without markup: the messages hold names such as `c[1]`.
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=20),
        TimeLeft(),
        TextColumn("{task.fields[detail]}", markup=False),
        console=Console(stderr=True),
        transient=True,
    )


def counting_bar() -> Progress:
    """A bar that counts what is done instead of the time; its tasks have a field `detail`."""
    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=20),
        MofNCompleteColumn(),
        TextColumn("{task.fields[detail]}", markup=False),
        console=Console(stderr=True),
        transient=True,
    )
