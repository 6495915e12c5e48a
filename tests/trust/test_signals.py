"""A share of `tamplang bench trust --part signals`: whenever a command is struck, nothing is half, left or alive."""

from __future__ import annotations

from pathlib import Path

from benchmarks.trust import signals
from benchmarks.trust.journal import Settings


def test_signals_and_kills(tmp_path: Path) -> None:
    (line,) = signals.run(Settings(tmp_path, seed=5, count=7))
    assert line.kept, (tmp_path / "signals.jsonl").read_text()
