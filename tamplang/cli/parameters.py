"""The option `-p NAME=VALUE`."""

from __future__ import annotations

import click


def _parse(context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    return dict(_assignment(text) for text in texts)


def _assignment(text: str) -> tuple[str, str]:
    name, _, value = (part.strip() for part in text.partition("="))
    if not name or not value:
        raise click.BadParameter(f"{text!r} is not of the form NAME=VALUE, such as n=8")
    return name, value


parameters_option = click.option(
    "-p",
    "--parameter",
    "parameters",
    multiple=True,
    metavar="NAME=VALUE",
    callback=_parse,
    help="Set a parameter of the task, such as n=8 or rise=20cm; may be repeated.",
)
"""Gives the command an argument `parameters`: the values as text, by name."""
