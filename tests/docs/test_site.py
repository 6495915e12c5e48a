"""The pages of the site: their programs are sound, their commands and links exist, and nothing is lost from it."""

from __future__ import annotations

import importlib.util
import math
import re
import shlex
from pathlib import Path
from types import ModuleType

import click
import pytest

import tamplang
from tamplang.cli.app import application
from tamplang.compiler.pipeline import check, check_sources
from tamplang.langs.source import Source

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
TUTORIAL = (DOCS / "tutorial.md").read_text(encoding="utf-8")
PROGRAMS = re.findall(r"```tamp\n(.*?)```", TUTORIAL, re.DOTALL)


HOW_TO = [
    (page.stem, program)
    for page in sorted(DOCS.glob("how-to-*.md"))
    for program in re.findall(r"```tamp\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
]
ARM = """<robot name="arm">
  <link name="base_link"/>
  <link name="arm"/>
  <link name="tool0"/>
  <joint name="turn" type="revolute"><parent link="base_link"/><child link="arm"/><origin xyz="0 0 0.05"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="20" velocity="2"/></joint>
  <joint name="wrist" type="revolute"><parent link="arm"/><child link="tool0"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="20" velocity="2"/></joint>
</robot>
"""


@pytest.mark.parametrize(("page", "program"), HOW_TO, ids=lambda x: x[:12])
def test_programs_of_the_how_tos_are_sound(page: str, program: str, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(ARM)
    (tmp_path / f"{page}.tamp").write_text(program)
    found = check(tmp_path / f"{page}.tamp")
    assert [f"{d.code} {d.message}" for d in found if d.code not in ("W0001", "W0002")] == []


def test_every_page_is_part_of_the_site() -> None:
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("nav:")[1]
    assert sorted(p.name for p in PAGES if f": {p.name}\n" not in nav) == []


def test_the_page_of_the_standard_library_is_that_of_its_texts() -> None:
    written = (DOCS / "stdlib.md").read_text(encoding="utf-8")
    assert written == _script("write_stdlib").text(), "python docs/write_stdlib.py writes it anew"


@pytest.mark.parametrize("program", PROGRAMS, ids=[re.findall(r"^task (\w+)", p, re.MULTILINE)[0] for p in PROGRAMS])
def test_programs_of_the_tutorial_are_sound(program: str) -> None:
    found = check_sources([Source("tutorial.tamp", program)])
    assert [f"{d.code} {d.message}" for d in found if d.span is None or d.span.file == "tutorial.tamp"] == []


def test_the_two_robots_of_the_tutorial_dock_and_climb(tmp_path: Path) -> None:
    (program,) = (p for p in PROGRAMS if "task third" in p)
    (tmp_path / "third.tamp").write_text(program)
    result = tamplang.load(tmp_path / "third.tamp").solve(time=math.inf)
    assert [action.split("(")[0] for action in result.actions] == ["connect", "stepTogether", "grasp"]


@pytest.mark.parametrize("page", [*PAGES, ROOT / "README.md"], ids=lambda p: p.stem)
def test_commands_of_a_page_exist(page: Path) -> None:
    """Every `tamplang COMMAND --option` in a block of shell, or between backticks."""
    text = page.read_text(encoding="utf-8")
    blocks = "\n".join(re.findall(r"```sh\n(.*?)```", text, re.DOTALL))
    lines = re.findall(r"^(?:\.venv/bin/)?tamplang (.+)$", blocks, re.MULTILINE)
    for line in lines:
        words = shlex.split(line.split("#")[0].split("|")[0])
        if words[0].startswith("-"):
            continue
        assert words[0] in application.commands, line
        known = {o for p in application.commands[words[0]].params if isinstance(p, click.Option) for o in p.opts}
        given = {w.split("=")[0] for w in words[1:] if re.fullmatch(r"--?[a-z][a-z-]*(=.*)?", w)}
        assert words[0] == "bench" or given <= {*known, "--help", "-h"}, line
    named = {m for m in re.findall(r"`tamplang ([a-z]+)", text)}
    assert named <= {*application.commands, "lsp"}, page


def test_the_page_of_codes_is_that_of_the_table() -> None:
    written = (DOCS / "codes.md").read_text(encoding="utf-8")
    assert written == _script("write_codes").text(), "python docs/write_codes.py writes it anew"


def test_the_page_of_python_is_that_of_its_docstrings() -> None:
    written = (DOCS / "python.md").read_text(encoding="utf-8")
    assert written == _script("write_python").text(), "python docs/write_python.py writes it anew"


def _script(name: str) -> ModuleType:
    """A script of the folder of pages, which is no package."""
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_pages_of_the_site_exist() -> None:
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("nav:")[1]
    pages = re.findall(r": (\S+\.md)$", nav, re.MULTILINE)
    assert len(pages) > 10 and [p for p in pages if not (DOCS / p).is_file()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_links_to_a_heading_lead_there(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target, anchor in re.findall(r"\]\(([^)#\s]*)#([\w-]+)\)", text):
        if "://" not in target:
            other = page if not target else page.parent / target
            assert anchor in _anchors(other.read_text(encoding="utf-8")), (page.name, target, anchor)


def _anchors(text: str) -> set[str]:
    heads = re.findall(r"^#+ (.+)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in heads}


def test_the_glossary_is_sorted() -> None:
    words = re.findall(r"^\| (\w[\w ]*) \|", (DOCS / "glossary.md").read_text(encoding="utf-8"), re.MULTILINE)[1:]
    assert words == sorted(words, key=str.lower) and len(words) > 15


def test_what_stands_beside_the_thesis_exists() -> None:
    """Every file that the page names, and in it every name that is said to be there; and every rule of the appendix."""
    page = (DOCS / "thesis.md").read_text(encoding="utf-8")
    files = re.findall(r"`((?:\w+/)+\w+\.(?:py|tamp))`", page)
    assert len(files) > 50 and [f for f in files if not (ROOT / f).is_file()] == []
    named = re.findall(r"((?:(?:, | and )?`\w+`)+) in `([\w/]+\.(?:py|tamp))`", page)
    pairs = [(name, file) for names, file in named for name in re.findall(r"\w+", names.replace(" and ", " "))]
    assert len(pairs) > 50
    assert [p for p in pairs if not _declares((ROOT / p[1]).read_text(encoding="utf-8"), p[0])] == []
    rules = re.findall(r"^rule (\w+)", (ROOT / "stdlib" / "thesis.tamp").read_text(encoding="utf-8"), re.MULTILINE)
    assert len(rules) == 7 and [r for r in rules if f"\n| {r} " not in page] == []


def _declares(text: str, name: str) -> bool:
    words = r"class|def|rule|motion|predicate|derived|function|heuristic|module|task"
    return re.search(rf"^\s*(?:{words}) [(\[]?{name}\b", text, re.MULTILINE) is not None


def test_every_example_has_its_place_among_the_examples() -> None:
    page = (DOCS / "examples.md").read_text(encoding="utf-8")
    examples = sorted(p.relative_to(ROOT).as_posix() for p in (ROOT / "examples").rglob("*.tamp"))
    assert len(examples) > 20 and [e for e in examples if f" {e}" not in page] == []


def test_the_tasks_and_parameters_of_the_examples_page_are_there() -> None:
    """Each command compiles its task, with the parameters that it gives."""
    commands = re.findall(r"^tamplang (?:solve|run) (.+)$", (DOCS / "examples.md").read_text(encoding="utf-8"), re.M)
    assert len(commands) > 20
    for words in map(shlex.split, commands):
        given = [words[i + 1].partition("=") for i, word in enumerate(words) if word == "-p"]
        tasks = [word for word in words[1:2] if not word.startswith("-")]
        tamplang.load(ROOT / words[0], *tasks, **{name: value for name, _, value in given})


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_pictures_of_a_page_exist(page: Path) -> None:
    named = re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8"))
    assert [n for n in named if not (DOCS / n).is_file()] == []


def test_scripts_that_pages_name_exist() -> None:
    """By the end of their path, as pages tell the folder once."""
    rooms = ("langs", "compiler", "runtime", "tamplang", "benchmarks", "docs", "tests", "editors")
    known = {f"/{p.relative_to(ROOT).as_posix()}" for room in rooms for p in (ROOT / room).rglob("*.py")}
    ends = {path[i:] for path in known for i, c in enumerate(path) if c == "/"}
    named = [(p.name, n) for p in PAGES for n in re.findall(r"`((?:\w+/)*\w+\.py)`", p.read_text(encoding="utf-8"))]
    assert len(named) > 100 and [n for n in named if f"/{n[1]}" not in ends] == []
