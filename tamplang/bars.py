"""Progress of a run for bars as tqdm's."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .runtime.planner.lgp import Progress
    from .runtime.simulation.results import RunProgress


def callback(progress: Any) -> Callable[[Progress], None] | None:
    """`progress` itself where it is called, else a function that moves it on by seconds of the budget."""

    def show(now: Progress) -> None:
        _move(progress, now.elapsed, now.limit, f"{now.stage} {now.message}".strip())

    return show if hasattr(progress, "update") else checked(progress)


def run_callback(progress: Any) -> Callable[[RunProgress], None] | None:
    """The same of a run in the simulated world, by actions."""

    def show(now: RunProgress) -> None:
        _move(progress, now.done, now.done + now.left, now.message)

    return show if hasattr(progress, "update") else checked(progress)


def checked(given: Any, what: str = "progress is called, or is a bar that has `update`") -> Any:
    """What is called, or None. Raises UsageError, saying `what` it should be."""
    if given is not None and not callable(given):
        from .langs.diagnostics import UsageError

        raise UsageError(f"{what}, not {given!r}")
    return given


def _move(bar: Any, done: float, total: float | None, told: str) -> None:
    """Set the total, tell what is done, and move the bar to where the run stands."""
    bar.total = total
    if hasattr(bar, "set_description_str"):
        bar.set_description_str(told, refresh=False)
    bar.update(done - bar.n)
