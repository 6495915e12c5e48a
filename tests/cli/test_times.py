"""Budgets on the command line: seconds, or with a unit of time."""

from __future__ import annotations

import click
import pytest

from tamplang.cli.parameters import Seconds


@pytest.mark.parametrize(
    ("text", "seconds"), [("60", 60.0), ("1.5 s", 1.5), ("10s", 10.0), ("2min", 120.0), ("0.5 min", 30.0)]
)
def test_times_have_units(text: str, seconds: float) -> None:
    assert Seconds().convert(text, None, None) == seconds


@pytest.mark.parametrize("text", ["2h", "0 s", "-3s", "nan s", "infs", "1_0 s", "٣s", "s"])
def test_what_is_no_time_is_refused(text: str) -> None:
    with pytest.raises(click.BadParameter):
        Seconds().convert(text, None, None)
