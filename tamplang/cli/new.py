"""The command `new`: a commented starter task."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

import click

from .develop import ROOT


def complete_examples(context: click.Context, parameter: click.Parameter, beginning: str) -> list[str]:
    """The examples that begin so."""
    return [name for name in (*examples(), "list") if name.startswith(beginning)]


@click.command()
@click.argument("name", required=False)
@click.option(
    "--from", "example", metavar="EXAMPLE", shell_complete=complete_examples,
    help="Copy an example instead; `--from list` lists them.",
)  # fmt: skip
def new(name: str | None, example: str | None) -> None:
    """Write NAME.tamp, a small commented task that solves in seconds."""
    if example == "list":
        click.echo("\n".join(f"{known:20}  {title(text)}" for known, text in examples().items()))
        return
    if name is None:
        raise click.UsageError("give the new program a name, such as `tamplang new climb`")
    target = Path(name if name.endswith(".tamp") else f"{name}.tamp")
    task = target.name.removesuffix(".tamp")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", task):
        raise click.UsageError(f"{task!r} is not a name: use letters, digits and underscores, a letter first")
    from ..langs.writer import write_new

    text = _text(task, example)
    try:
        write_new(target, text.encode())
    except FileExistsError:
        raise click.UsageError(f"{target} exists already; it was not changed") from None
    except OSError as error:
        raise click.UsageError(f"cannot write {target}: {error.strerror}") from error
    click.echo(f"wrote {target}; next: tamplang solve {target} --report {task}.html")


def _text(task: str, example: str | None) -> str:
    """The program to write: the starter, or an example whose task gets the new name."""
    if example is None:
        return files(__package__).joinpath("starter.tamp").read_text(encoding="utf-8").replace("starter", task)
    from ..langs.diagnostics import did_you_mean

    known = examples()
    if example not in known:
        near = did_you_mean(example, known) or f"there are {', '.join(known)}"
        raise click.UsageError(f"there is no example {example!r}; {near}")
    text = known[example].replace(f"examples/{example}.tamp", f"{task}.tamp").replace(f"{example}.html", f"{task}.html")
    text = text.replace(f"{task}.tamp {example}", f"{task}.tamp {task}")
    return re.sub(rf"^task {example}\b", f"task {task}", text, flags=re.MULTILINE)


def examples() -> dict[str, str]:
    """The texts of the examples that come with the package, by name."""
    folder = files(__package__.rpartition(".")[0]).joinpath("examples")
    if not folder.is_dir():  # in the source tree they lie at the top, where readers look for them
        folder = ROOT / "examples"
    found = {f.name.removesuffix(".tamp"): f for f in folder.iterdir() if f.name.endswith(".tamp")}
    return {name: found[name].read_text(encoding="utf-8") for name in sorted(found)}


def title(text: str) -> str:
    """The first line of a program's comment."""
    return text.partition("\n")[0].lstrip("# ").strip()
