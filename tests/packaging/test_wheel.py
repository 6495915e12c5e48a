"""What is in the wheel and in the archive of the sources; built offline by hatchling itself."""

from __future__ import annotations

import tarfile
import zipfile
from collections import Counter
from pathlib import Path

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("langs", "compiler", "runtime", "stdlib")
DATA = {".lark", ".tamp", ".j2", ".html", ".css", ".js", ".typed"}


def data_files(folder: Path) -> set[str]:
    """Files beside the Python modules that the package needs when it runs."""
    return {p.relative_to(ROOT).as_posix() for p in folder.rglob("*") if p.suffix in DATA and p.is_file()}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("wheel")
    path = next(WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"]))
    with zipfile.ZipFile(path) as archive:
        return archive.namelist()


def test_the_wheel_installs_one_package(wheel: list[str]) -> None:
    tops = {name.split("/")[0] for name in wheel}
    assert {t for t in tops if not t.endswith(".dist-info")} == {"tamplang"}


@pytest.mark.parametrize("room", ROOMS)
def test_every_module_of_a_room_is_there_once(wheel: list[str], room: str) -> None:
    expected = {f"tamplang/{p.relative_to(ROOT).as_posix()}" for p in (ROOT / room).rglob("*.py")}
    counts = Counter(wheel)
    assert {name: counts[name] for name in expected} == dict.fromkeys(expected, 1)


@pytest.mark.parametrize("room", ROOMS)
def test_the_texts_of_a_room_are_there_once(wheel: list[str], room: str) -> None:
    counts = Counter(wheel)
    expected = {f"tamplang/{name}" for name in data_files(ROOT / room)}
    assert {name: counts[name] for name in expected} == dict.fromkeys(expected, 1)
    if room in ("langs", "stdlib"):
        assert expected


def test_the_command_and_its_texts_are_there(wheel: list[str]) -> None:
    assert {
        "tamplang/__init__.py",
        "tamplang/cli/__init__.py",
        "tamplang/cli/starter.tamp",
        "tamplang/py.typed",
    } <= set(wheel)
    assert len(wheel) == len(set(wheel))
    assert not [name for name in wheel if "__pycache__" in name or name.endswith(".pyc")]


def test_the_archive_of_the_sources_holds_every_file_once(tmp_path: Path) -> None:
    path = next(SdistBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"]))
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"README.md", "LICENSE", "examples/climb.tamp", "compiler/ir.py", "langs/syntax.py"} <= names
    assert "tamplang/compiler/ir.py" not in names
