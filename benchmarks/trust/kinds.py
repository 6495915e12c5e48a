"""The kinds of change of the tampered plans, by name. Each lives in a module beside this one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .draft import Draft


class Unfit(Exception):
    """A kind of change that a plan has no place for."""


Change = Callable[[Draft], str | None]


@dataclass(frozen=True, slots=True)
class Kind:
    """`change` spoils a draft, or gives the text of the file itself. `false` says that no plan so changed is true; else
    the second checker judges."""

    name: str
    change: Change
    false: bool


KINDS: dict[str, Kind] = {}


def kind(false: bool = False) -> Callable[[Change], Change]:
    """Registers a change under its own name."""

    def register(change: Change) -> Change:
        name = change.__name__
        KINDS[name] = Kind(name, change, false)
        return change

    return register


def need(condition: object) -> None:
    """Raises Unfit."""
    if not condition:
        raise Unfit
