"""Missing system libraries, told with the way to install them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import click


@contextmanager
def needing_libraries() -> Iterator[None]:
    """Around code that loads compiled libraries: turns `MissingLibrary` into a sentence and the install hint."""
    from ..runtime.native import MissingLibrary

    try:
        yield
    except MissingLibrary as error:
        raise click.ClickException(f"{error}\n  help: {error.hint}") from error


def load_libraries() -> None:
    """Load what the verifier will need, so that a missing library is told before the planner works. Raises
    MissingLibrary."""
    from ..runtime.native import load_coal, load_pinocchio

    load_pinocchio()
    load_coal()
