"""The command group. A command is loaded when it is asked for: all of them take as long as the command line itself."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from importlib import import_module

import click

from .. import __version__


class _Commands(MutableMapping[str, click.Command]):
    """Commands by their names, from where they are defined: the module, and there the name where it differs."""

    def __init__(self, places: dict[str, tuple[str, str]]) -> None:
        self._places: dict[str, tuple[str, str] | click.Command] = dict(places)

    def __getitem__(self, name: str) -> click.Command:
        found = self._places[name]
        if not isinstance(found, click.Command):
            module, attribute = found
            found = self._places[name] = getattr(import_module(f".{module}", __package__), attribute)
        return found

    def __setitem__(self, name: str, command: click.Command) -> None:
        self._places[name] = command

    def __delitem__(self, name: str) -> None:
        del self._places[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


_COMMANDS = _Commands({
    "new": ("new", "new"),
    "check": ("check", "check"),
    "solve": ("solve", "solve"),
    "run": ("execute", "run"),
    "sweep": ("sweep", "sweep"),
    "verify": ("plans", "verify"),
    "simulate": ("simulate", "simulate"),
    "report": ("plans", "report"),
    "import": ("imports", "import_command"),
    "export": ("export", "export"),
    "compile": ("compile", "compile_command"),
    "explain": ("develop", "explain"),
    "fmt": ("check", "fmt"),
    "lsp": ("develop", "lsp"),
    "bench": ("develop", "bench"),
    "help": ("develop", "help_command"),
})  # fmt: skip


@click.group(commands=_COMMANDS, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, message="tamplang %(version)s")
def application() -> None:
    """A language and toolchain for task and motion planning of modular, self-reconfiguring robots."""
