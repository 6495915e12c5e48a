"""A share of `tamplang bench trust --part programs`: no text makes the toolchain break off, wait, or point astray."""

from __future__ import annotations

from pathlib import Path

from benchmarks.trust import programs
from benchmarks.trust.generate import Grammar
from benchmarks.trust.journal import Settings


def test_mutated_and_generated_programs(tmp_path: Path) -> None:
    lines = programs.run(Settings(tmp_path, seed=2, count=200))
    assert [line.kept for line in lines] == [True, True], lines
    assert [line.what.split()[0] for line in lines] == ["133", "67"]


def test_grammar_gives_programs_that_parse() -> None:
    from random import Random

    from tamplang.langs.parser import parse
    from tamplang.langs.source import Source

    grammar = Grammar()
    texts = [grammar.sentence(Random(seed)) for seed in range(100)]
    assert sum(not parse(Source("g.tamp", text))[1] for text in texts) > 3


def test_what_breaks_off_and_what_takes_long_is_seen() -> None:
    import random

    class Broken:
        def edited(self, *_: object) -> list[str]:
            raise KeyError("broken")

    found = programs.tried(Broken(), "a.tamp", "", "task t() {}", random.Random(0))
    assert any(w.startswith("traceback: lsp") for w in found["wrong"])
