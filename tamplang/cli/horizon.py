"""The option `--horizon`: how many actions get their motion at a time."""

from __future__ import annotations

import click

AUTO = "auto"


def checked_horizon(context: click.Context, option: click.Parameter, text: str | None) -> int | str | None:
    """A whole number from 1, or `auto`. Raises click.BadParameter."""
    if text is None or text == AUTO:
        return text
    try:
        horizon = int(text)
    except ValueError:
        raise click.BadParameter(f"{text!r} is no horizon: give a whole number from 1, or {AUTO}") from None
    if horizon < 1:
        raise click.BadParameter(f"{horizon} is no horizon: a window has at least 1 action; or give {AUTO}")
    return horizon
