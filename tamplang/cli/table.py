"""The table at the end of a sweep."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

WIDTH_ELSEWHERE = 160
"""Columns of what is no terminal."""


def print_groups(groups: Sequence[Mapping[str, Any]]) -> None:
    """Print one row per combination of parameters on standard output."""
    table = Table(box=box.SIMPLE_HEAD)
    names = list(groups[0]["parameters"])
    for name in (*names, "solved", "success", "median time", "median length", "unsolved"):
        table.add_column(name, justify="right")
    for group in groups:
        table.add_row(*group["parameters"].values(), *_cells(group))
    Console(width=None if sys.stdout.isatty() else WIDTH_ELSEWHERE, markup=False).print(table)


def _cells(group: Mapping[str, Any]) -> list[str]:
    left = group["instances"] - group["finished"]
    return [
        f"{group['solved']}/{group['finished']}" + (f" ({left} left)" if left else ""),
        "–" if group["success"] is None else f"{100 * group['success']:.0f} %",
        "–" if group["median_seconds"] is None else f"{group['median_seconds']:.2f} s",
        "–" if group["median_length"] is None else f"{group['median_length']:g}",
        ", ".join(f"{code} × {count}" if count > 1 else code for code, count in group["codes"].items()),
    ]
