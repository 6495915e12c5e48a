"""The commands around writing programs: `explain`, `lsp` and `bench`."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import click

ROOT = Path(__file__).resolve().parents[2]


def complete_codes(context: click.Context, parameter: click.Parameter, beginning: str) -> list[str]:
    """The codes that begin so."""
    from ..langs.codes import CODES

    return [code for code in CODES if code.startswith(beginning.upper())]


def complete_commands(context: click.Context, parameter: click.Parameter, beginning: str) -> list[str]:
    """The commands that begin so."""
    group = context.parent.command if context.parent is not None else None
    return [name for name in group.commands if name.startswith(beginning)] if isinstance(group, click.Group) else []


@click.command()
@click.argument("code", required=False, shell_complete=complete_codes)
@click.option("--list", "listed", is_flag=True, help="List the codes that begin with CODE, or all, with titles.")
def explain(code: str | None, listed: bool) -> None:
    """Explain the diagnostic CODE, such as E0301."""
    from ..langs.codes import CODES
    from ..langs.diagnostics import did_you_mean

    if listed:
        wanted = (code or "").upper()
        click.echo("\n".join(f"{k}  {info.title}" for k, info in CODES.items() if k.startswith(wanted)))
        return
    if code is None:
        raise click.UsageError("name a code, or list them all with --list")
    code = code.upper()
    info = CODES.get(code)
    if info is None:
        beginning = [known for known in CODES if known.startswith(code)]
        near = f"there are {', '.join(beginning)}" if beginning else did_you_mean(code, CODES)
        raise click.UsageError(f"there is no code {code}; {near or 'codes look like E0103'}")
    click.echo(info.text(code))


@click.command("help")
@click.argument("command", required=False, shell_complete=complete_commands)
@click.pass_context
def help_command(context: click.Context, command: str | None) -> None:
    """Say what COMMAND does, as `tamplang COMMAND --help` does; without COMMAND, list the commands."""
    from ..langs.diagnostics import did_you_mean

    group = context.parent.command if context.parent is not None else None
    assert isinstance(group, click.Group) and context.parent is not None
    if command is None:
        click.echo(group.get_help(context.parent))
        return
    found = group.commands.get(command)
    if found is None:
        near = did_you_mean(command, group.commands) or f"there are {', '.join(group.commands)}"
        raise click.UsageError(f"there is no command {command!r}; {near}")
    click.echo(found.get_help(click.Context(found, info_name=command, parent=context.parent)))


@click.command()
def lsp() -> None:
    """Serve an editor over standard input and output (Language Server Protocol)."""
    try:
        from ..lsp import serve
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in ("pygls", "lsprotocol"):
            raise
        raise click.ClickException(
            "the language server needs the library pygls; install it with: pip install 'tamplang[lsp]'"
        ) from error
    serve()


@click.command(context_settings={"ignore_unknown_options": True})
@click.argument("name", required=False)
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def bench(name: str | None, arguments: tuple[str, ...]) -> int:
    """Run the benchmark NAME with its own ARGUMENTS; without NAME, list the benchmarks."""
    scripts = benchmarks()
    if name is None:
        for known, script in scripts.items():
            click.echo(f"{known:16}  {title(script)}")
        return 0
    if name not in scripts:
        raise click.UsageError(f"there is no benchmark {name!r}; there are {', '.join(scripts)}")
    return subprocess.run([sys.executable, str(scripts[name]), *arguments], check=False).returncode


def benchmarks() -> dict[str, Path]:
    """The benchmarks by name: every script in the folder `benchmarks` of the source tree, and every folder of it that
    is run as a whole.

    Raises click.UsageError where there is no source tree.
    """
    folder = ROOT / "benchmarks"
    if not (folder.is_dir() and (ROOT / "pyproject.toml").is_file()):
        raise click.UsageError(
            "the benchmarks are part of the source tree, not of the installed package; "
            "run this command in a clone that was installed with: pip install -e ."
        )
    found = {path.stem: path for path in folder.glob("*.py") if not path.stem.startswith("_")}
    found |= {path.parent.name: path for path in folder.glob("*/__main__.py")}
    return dict(sorted(found.items()))


def title(script: Path) -> str:
    """The first line of a script's docstring."""
    documentation = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or ""
    return documentation.partition("\n")[0]
