"""The command group."""

from __future__ import annotations

import click

from .. import __version__
from .check import check, fmt
from .compile import compile_command
from .develop import bench, explain, help_command, lsp
from .execute import run
from .export import export
from .imports import import_command
from .new import new
from .plans import report, verify
from .simulate import simulate
from .solve import solve
from .sweep import sweep


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="tamplang %(version)s")
def application() -> None:
    """A language and toolchain for task and motion planning of modular, self-reconfiguring robots."""


for _command in (
    new, check, solve, run, sweep, verify, simulate, report, import_command, export, compile_command, explain, fmt,
    lsp, bench, help_command,
):  # fmt: skip
    application.add_command(_command)
