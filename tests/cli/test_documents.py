"""docs/cli.md and the README against the command itself."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from tamplang.cli.app import application
from tamplang.cli.status import ExitStatus
from tamplang.compiler.options import OPTIONS, Option, given_at

from .conftest import ROOT

CLI = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
LANGUAGE = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")


def section(command: str) -> str:
    """The text below the heading of a command."""
    found = re.search(rf"^### `tamplang {command}\b.*?(?=^##)", CLI, re.MULTILINE | re.DOTALL)
    assert found is not None, command
    return found.group()


def test_every_command_and_option_is_documented() -> None:
    for name, command in application.commands.items():
        text = section(name)
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                assert all(option in text for option in parameter.opts), (name, parameter.opts)


def test_no_option_is_documented_that_does_not_exist() -> None:
    for name, command in application.commands.items():
        known = {option for parameter in command.params for option in parameter.opts}
        mentioned = set(re.findall(r"(?<![\w-])--[a-z]+(?:-[a-z]+)*", section(name)))
        assert mentioned <= known, name


def test_every_choice_is_documented() -> None:
    for name, command in application.commands.items():
        for parameter in command.params:
            if isinstance(parameter.type, click.Choice):
                assert all(choice in section(name) for choice in parameter.type.choices), (
                    name,
                    parameter.name,
                )


def row(option: str) -> list[str]:
    """The cells of the row of an option of `solve`."""
    found = re.search(rf"^\| `--{option}\b.*\|$", section("solve"), re.MULTILINE)
    assert found is not None, option
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", found.group())[1:-1]]


@pytest.mark.parametrize("option", given_at("solve").values(), ids=lambda o: o.name)
def test_choices_and_default_of_an_option_are_those_of_the_table(option: Option) -> None:
    name, _, default = row(option.name)
    if option.choices:
        assert name == f"`--{option.name} " + "\\|".join(option.choices) + "`"
    number = isinstance(option.default, int | float)
    none = "a few candidates, while they are better" if option.name == "gap" else "no limit"
    written = none if option.default is None else f"{option.default:g}" if number else option.default
    assert default.strip("`") == written


@pytest.mark.parametrize("option", given_at("task").values(), ids=lambda o: o.name)
def test_the_page_of_the_language_lists_the_options_of_a_task(option: Option) -> None:
    rows = re.findall(rf"^\| .*`{option.name}`.*\|$", LANGUAGE, re.MULTILINE)
    assert any(all(f"`{choice.replace('-', '_')}`" in found for choice in option.choices) for found in rows)


@pytest.mark.parametrize("command", ["solve", "sweep"])
def test_a_command_takes_what_the_table_says(command: str) -> None:
    parameters = {option for p in application.commands[command].params for option in p.opts}
    assert {f"--{name}" for name in OPTIONS if f"--{name}" in parameters} == {f"--{n}" for n in given_at(command)}


def test_every_exit_status_is_documented() -> None:
    assert set(re.findall(r"^\| (\d+) \|", CLI, re.MULTILINE)) == {str(int(status)) for status in ExitStatus}


def test_the_readme_has_one_command_to_run_and_one_to_test() -> None:
    for heading in ("Run it", "Test it"):
        text = re.search(rf"^## {heading}\n(.*?)(?=^## )", README, re.MULTILINE | re.DOTALL)
        assert text is not None
        (block,) = re.findall(r"^```sh\n(.*?)^```", text.group(1), re.MULTILINE | re.DOTALL)
        assert len(block.splitlines()) == 1


PAGES = [*sorted((ROOT / "docs").glob("*.md")), *sorted(ROOT.glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_every_path_and_link_of_a_page_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    rooms = "langs|compiler|runtime|stdlib|tamplang|examples|tests|benchmarks|docs"
    paths = re.findall(rf"`((?:{rooms})/[\w./]+?)`", text)
    links = [link for link in re.findall(r"\]\(([^)#\s]+)", text) if "://" not in link]
    lost = [p for p in paths if not (ROOT / p).exists()] + [k for k in links if not (page.parent / k).exists()]
    assert lost == []
