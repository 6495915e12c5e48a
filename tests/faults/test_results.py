"""Results files of a sweep with any damage: nothing in them is lost, and the sweep goes on."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from .conftest import here

SEEDS = ("--seeds", "0..1")


@pytest.fixture
def swept(light: Path, tmp_path: Path) -> list[str]:
    """The lines of a finished sweep, in the file t.sweep.jsonl."""
    assert here(tmp_path, "sweep", light, *SEEDS).returncode == 0
    return (tmp_path / "t.sweep.jsonl").read_text().splitlines(keepends=True)


DAMAGES = {
    "half a line": lambda first, second: (first + second[:-30], 1, ""),
    "no last newline": lambda first, second: (first + second[:-1], 2, ""),
    "blank lines": lambda first, second: (f"\n{first}\n\n{second}", 2, "3 lines"),
    "text between": lambda first, second: (f"{first}hello\n{second}", 2, "1 line"),
    "text at the end": lambda first, second: (f"{first}{second}hello", 2, "1 line"),
    "bytes": lambda first, second: (f"{first}\0\x01\udcff\udcfe\n{second}", 2, "1 line"),
    "other JSON": lambda first, second: (f"[1, 2]\n3\nnull\n{first}{second}", 2, "3 lines"),
    "nested": lambda first, second: (first + "[" * 100_000 + "\n" + second, 2, "1 line"),
    "duplicates": lambda first, second: (first * 3 + second * 2, 2, ""),
    "another task": lambda first, second: (first.replace('"key": "', '"key": "0') + first + second, 2, ""),
    "numbers as text": lambda first, second: (first.replace('"length": 1', '"length": "1"') + second, 1, "1 line"),
    "endless": lambda first, second: (first.replace('"total": ', '"total": 1e999, "x": ') + second, 1, "1 line"),
    "no status": lambda first, second: (first.replace('"status"', '"state"') + second, 1, "1 line"),
    "verified as text": lambda first, second: (first.replace(': true', ': "no"') + second, 1, "1 line"),
    "status as a list": lambda first, second: (first.replace('"solved"', "[]") + second, 1, "1 line"),
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_resumed(light: Path, tmp_path: Path, swept: list[str], damage: str) -> None:
    text, sound, warned = DAMAGES[damage](*swept)
    path = tmp_path / "t.sweep.jsonl"
    before = text.encode(errors="surrogateescape")
    path.write_bytes(before)
    process = here(tmp_path, "sweep", light, *SEEDS, "--json")
    assert process.returncode == 0, process.stderr
    assert json.loads(process.stdout)["solved"] == 2
    assert (f"{sound} instance" in process.stderr) == (sound > 0)
    assert ("warning[W0011]" in process.stderr) == bool(warned) and warned in process.stderr
    kept = before[: before.rindex(b"\n") + 1] if damage == "half a line" else before
    assert path.read_bytes().startswith(kept)
    again = here(tmp_path, "sweep", light, *SEEDS)
    assert again.returncode == 0 and "2 instances of 2 stand" in again.stderr


@pytest.mark.parametrize("content", [b"hello\n", b"\0" * 1000, b"{}\n", b"\xff" * 50, b"[" * 100_000, b"{'key': 1}"])
def test_a_file_of_something_else_is_left_alone(light: Path, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "t.sweep.jsonl"
    path.write_bytes(content)
    process = here(tmp_path, "sweep", light)
    assert process.returncode == 2 and "it holds no result of a sweep" in process.stderr
    assert path.read_bytes() == content


def test_a_large_hole_is_no_result(light: Path, tmp_path: Path) -> None:
    path = tmp_path / "t.sweep.jsonl"
    path.touch()
    os.truncate(path, 200_000_000)
    process = here(tmp_path, "sweep", light)
    assert process.returncode == 2 and path.stat().st_size == 200_000_000
