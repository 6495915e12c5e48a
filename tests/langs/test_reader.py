"""Files that are no readable text are refused with a code."""

import os
import time
from pathlib import Path

import pytest

from tamplang.langs.codes import CODES
from tamplang.langs.diagnostics import SourceError
from tamplang.langs.reader import read_source


def code_of(path: Path | str) -> str:
    with pytest.raises(SourceError) as refused:
        read_source(path)
    (diagnostic,) = refused.value.diagnostics
    assert diagnostic.code in CODES and diagnostic.is_error
    return diagnostic.code


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "E0013"),
        (b" \n\t\n", "E0013"),
        (b"type a\0 < object", "E0014"),
        (b"\x89PNG\r\n\x1a\n", "E0014"),
        ("tüpe".encode("latin-1"), "E0014"),
        ("type a < object".encode("utf-16"), "E0014"),
        (b"# " + b"x" * 1_000_000, "E0015"),
    ],
)
def test_contents(tmp_path: Path, content: bytes, code: str) -> None:
    file = tmp_path / "a.tamp"
    file.write_bytes(content)
    assert code_of(file) == code


def test_missing_file_and_folder(tmp_path: Path) -> None:
    assert code_of(tmp_path / "none.tamp") == "E0010"
    assert code_of(tmp_path / "none" / "none.tamp") == "E0010"
    assert code_of("bad\0name") == "E0010"
    assert code_of("") == "E0010"
    assert code_of(tmp_path) == "E0012"
    assert code_of("/dev/null") == "E0012"


def test_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert code_of(tmp_path / "pipe") == "E0012"


def test_file_that_the_system_refuses(tmp_path: Path) -> None:
    ring = tmp_path / "ring.tamp"
    ring.symlink_to(ring)
    assert code_of(ring) == "E0011"


def test_large_file_is_refused_without_reading_it(tmp_path: Path) -> None:
    file = tmp_path / "a.tamp"
    with file.open("wb") as stream:
        stream.truncate(10_000_000_000)
    start = time.perf_counter()
    assert code_of(file) == "E0015"
    assert time.perf_counter() - start < 1


def test_line_ends_and_byte_order_mark(tmp_path: Path) -> None:
    file = tmp_path / "a.tamp"
    file.write_bytes(b"\xef\xbb\xbftype a\r\ntype b\r")
    source = read_source(file)
    assert (source.path, source.text) == (str(file), "type a\ntype b\n")
