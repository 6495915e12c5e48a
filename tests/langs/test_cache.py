"""Grammar and trees on disk: written once, safe when damaged, done without where the folder cannot be written."""

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tamplang.langs import grammar_loader, tree_cache
from tamplang.langs.parser import parse
from tamplang.langs.reader import read_source
from tamplang.langs.source import Source

from .programs import ROOT

PARSE = (
    "from tamplang.langs.parser import parse\nfrom tamplang.langs.reader import read_source\n"
    f"tree, found = parse(read_source({str(ROOT / 'stdlib' / 'rules.tamp')!r}))\n"
    "assert not found\nimport sys\nprint(len(tree.declarations), 'lark' in sys.modules)"
)


def parse_alone(cache: Path, parser: bool = True) -> None:
    """Parse a library file in a process of its own, which loads the parser or not."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", PARSE], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, f"8 {parser}", "")


def test_written_once_and_read_again(tmp_path: Path) -> None:
    parse_alone(tmp_path)
    files = sorted((tmp_path / "tamplang").iterdir())
    assert [file.name.partition("-")[0] for file in files] == ["grammar", "tree"]
    written = [file.stat().st_mtime_ns for file in files]
    parse_alone(tmp_path, parser=False)
    assert [file.stat().st_mtime_ns for file in files] == written
    assert files[0].parent.stat().st_mode & 0o077 == 0
    files[1].write_bytes(files[1].read_bytes()[:-1] + b"?")
    parse_alone(tmp_path)
    parse_alone(tmp_path, parser=False)


def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    parse_alone(tmp_path / "file")


def flipped(sound: bytes) -> Iterator[bytes]:
    """The file with one byte that is another, here and there."""
    for k in range(1, 8):
        at = k * len(sound) // 8
        yield sound[:at] + bytes([sound[at] ^ 1]) + sound[at + 1 :]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_pipe_in_the_place_of_the_file_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "grammar.bin")
    assert grammar_loader.load_cached(tmp_path / "grammar.bin") is None


def test_written_by_two_processes_at_once(tmp_path: Path) -> None:
    with ThreadPoolExecutor() as pool:
        list(pool.map(parse_alone, [tmp_path, tmp_path]))
    grammar, _ = sorted((tmp_path / "tamplang").iterdir())
    assert grammar_loader.load_cached(grammar) is not None


def test_damaged_file_is_not_used(tmp_path: Path) -> None:
    file = tmp_path / "grammar.bin"
    grammar_loader.store(grammar_loader.parser(), file)
    assert grammar_loader.load_cached(file) is not None
    sound = file.read_bytes()
    for damage in (b"", b"nonsense", b"\x80\x04N.", sound[: len(sound) // 2], b"\0" + sound, *flipped(sound)):
        file.write_bytes(damage)
        assert grammar_loader.load_cached(file) is None


@pytest.mark.parametrize("name", ["missing.bin", "."])
def test_missing_file_is_not_used(tmp_path: Path, name: str) -> None:
    assert grammar_loader.load_cached(tmp_path / name) is None


def test_trees_are_those_of_their_texts_and_few(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(tree_cache.Kept, "count", 0)
    folder = tmp_path / "tamplang"
    folder.mkdir()
    for k in range(tree_cache.MOST_KEPT + 9):
        (folder / f"tree-{k}.bin").touch()
    source = read_source(ROOT / "stdlib" / "motion.tamp")
    parse.cache_clear()
    made, _ = parse(source)
    assert len(list(folder.glob("tree-*.bin"))) == tree_cache.MOST_KEPT
    assert repr(tree_cache.recalled_tree(source)) == repr(made)  # spans too, which take no part in comparison
    for other in (Source("elsewhere", source.text), Source(source.path, source.text + "\n")):
        assert tree_cache.recalled_tree(other) is None
    faulty = Source("faulty", "rule")
    parse(faulty)
    assert tree_cache.recalled_tree(faulty) is None
