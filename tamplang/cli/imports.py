"""The command `import`: what others' tools write, as a program."""

from __future__ import annotations

from pathlib import Path

import click

from .limits import limit_options, limited
from .outputs import checked_output
from .sources import reading_sources, show_diagnostics


@click.command("import")
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", "-o", type=click.Path(path_type=Path), help="The program to write.  [default: named like FILE]")
@limit_options
def import_command(files: tuple[Path, ...], out: Path | None, seconds: float, memory: int | None) -> None:
    """Make a program of each kind of FILE that others' tools write: a PDDL domain and problem, or a model."""
    target = Path(f"{files[-1].name.partition('.')[0] or 'imported'}.tamp") if out is None else out
    with limited(seconds, memory, f"importing {files[-1]}"), reading_sources():
        checked_output(target, files)
        from ..compiler.importing.reading import import_files
        from ..langs.writer import write_atomically

        found = import_files([str(file) for file in files], target.name.partition(".")[0] or "imported")
        for name in found.beside:
            checked_output(target.with_name(name), files)
        for name, text in found.beside.items():
            write_atomically(target.with_name(name), text.encode())
        write_atomically(target, found.text.encode())
        if found.told:
            show_diagnostics(found.told)
    more = "".join(f", {name}" for name in found.beside)
    click.echo(f"wrote {target}{more}; next: tamplang check {target}", err=True)
