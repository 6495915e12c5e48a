"""The option `--horizon`: how many actions get their motion at a time."""

from __future__ import annotations

import click

from .parameters import WholeNumber

AUTO = "auto"


def checked_horizon(context: click.Context, option: click.Parameter, text: str | None) -> int | str | None:
    """A whole number from 1, or `auto`. Raises click.BadParameter."""
    if text is None or text == AUTO:
        return text
    try:
        return WholeNumber(1).convert(text, option, context)
    except click.BadParameter:
        what = f"give the number of actions of a window, from 1, or {AUTO}"
        raise click.BadParameter(f"{text!r} is no horizon: {what}") from None
