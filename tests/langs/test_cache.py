"""The grammar on disk: written once, safe when damaged, done without where the folder cannot be written."""

import os
import subprocess
import sys
import time
from pathlib import Path

from .programs import ROOT

PARSE = (
    "from tamplang.langs.parser import parse\nfrom tamplang.langs.reader import read_source\n"
    f"tree, found = parse(read_source({str(ROOT / 'stdlib' / 'rules.tamp')!r}))\n"
    "assert not found\nprint(len(tree.declarations))"
)


def run(cache: Path) -> float:
    """Parse a library file in a process of its own; gives the seconds it took."""
    start = time.perf_counter()
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", PARSE], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.strip() == "8"
    return time.perf_counter() - start


def test_written_once_and_read_again(tmp_path: Path) -> None:
    run(tmp_path)
    (file,) = (tmp_path / "tamplang").iterdir()
    written = file.stat().st_mtime_ns
    run(tmp_path)
    assert file.stat().st_mtime_ns == written
    assert file.parent.stat().st_mode & 0o077 == 0


def test_damaged_file_is_replaced(tmp_path: Path) -> None:
    run(tmp_path)
    (file,) = (tmp_path / "tamplang").iterdir()
    sound = file.read_bytes()
    for damage in (b"", b"nonsense", sound[: len(sound) // 2]):
        file.write_bytes(damage)
        run(tmp_path)
        assert file.stat().st_size > 0.9 * len(sound)


def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    run(tmp_path / "file")
    run(Path("/proc/nowhere"))
