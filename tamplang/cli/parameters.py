"""The option `-p NAME=VALUE`, and budgets of time."""

from __future__ import annotations

import math
from typing import Any

import click


def _parse(context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    return dict(_assignment(text) for text in texts)


def _assignment(text: str) -> tuple[str, str]:
    name, _, value = (part.strip() for part in text.partition("="))
    if not name or not value:
        raise click.BadParameter(f"{text!r} is not of the form NAME=VALUE, such as n=8")
    return name, value


class Seconds(click.FloatRange):
    """A budget above 0; `inf` is none."""

    def __init__(self) -> None:
        super().__init__(min=0, min_open=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        seconds = float(super().convert(value, param, ctx))
        if math.isnan(seconds):
            self.fail(f"{value!r} is no number of seconds", param, ctx)
        return seconds


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
