"""The option `-p NAME=VALUE`, and numbers as options: plain ones, written with the digits 0 to 9."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, TypeVar

import click

from ..compiler.options import OPTIONS

Command = TypeVar("Command", bound=Callable[..., Any])

MOST = 10**18 - 1
"""The greatest whole number of an option: it fits wherever it is stored."""
_WHOLE = re.compile(r"\s*[+-]?[0-9]+\s*")
_TIME = re.compile(r"\s*([0-9.eE+-]+)\s*(s|min)\s*")


def _parse(context: click.Context, option: click.Parameter, texts: tuple[str, ...]) -> dict[str, str]:
    return dict(_assignment(text) for text in texts)


def _assignment(text: str) -> tuple[str, str]:
    name, _, value = (part.strip() for part in text.partition("="))
    if not name or not value:
        raise click.BadParameter(f"{text!r} is not of the form NAME=VALUE, such as n=8")
    return name, value


class WholeNumber(click.IntRange):
    """A whole number from `min` to `max`. Python's `int` reads `1_0` and the digits of every script, too."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        if isinstance(value, str) and not _WHOLE.fullmatch(value):
            self.fail(f"{value!r} is not a whole number", param, ctx)
        number = int(super().convert(value, param, ctx))
        if number > MOST:
            self.fail(f"{value!r} is too large", param, ctx)
        return number


class Real(click.FloatRange):
    """A number. Python's `float` reads `1_0` and the digits of every script, too."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, str) and not plain(value):
            self.fail(f"{value!r} is not a number", param, ctx)
        return float(super().convert(value, param, ctx))


class Seconds(Real):
    """A budget above 0, in seconds unless a unit of time says otherwise; `inf` is none."""

    def __init__(self) -> None:
        super().__init__(min=0, min_open=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        match = _TIME.fullmatch(str(value))
        if match is None:
            return super().convert(value, param, ctx)
        return super().convert(match[1], param, ctx) * (60.0 if match[2] == "min" else 1.0)


class ObjectiveText(click.ParamType[str]):
    """An objective, told with its code where it makes no sense."""

    name = "objective"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        from ..compiler.objective_terms import spelled
        from ..langs.diagnostics import UsageError

        try:
            spelled(str(value))
        except UsageError as error:
            code = "" if error.diagnostic is None else f"{error.diagnostic.code} "
            self.fail(f"{code}{error}", param, ctx)
        return str(value)


def plain(text: str) -> bool:
    """Whether a number is written in ASCII, and is one: not `nan`."""
    try:
        return text.isascii() and "_" not in text and not math.isnan(float(text))
    except ValueError:
        return False


def planner_option(name: str, *argument: str, **more: Any) -> Callable[[Command], Command]:
    """The option `--name` as the table of the planner's options has it; `more` is told to click as it is. The command
    gives None on where it is not set."""
    option = OPTIONS[name]
    kinds: dict[str, click.ParamType[Any]] = {
        "word": click.Choice(option.choices), "whole": WholeNumber(1, option.most), "time": Seconds(),
        "objective": ObjectiveText(), "amount": Real(min=0, max=math.inf, max_open=True),
    }  # fmt: skip
    return click.option(f"--{name}", *argument, **{"type": kinds[option.kind], "help": option.help, **more})


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
