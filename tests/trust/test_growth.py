"""Programs that double, nest or repeat end in linear time, or with a coded limit at a line (issue 11)."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.trust import growth
from benchmarks.trust.families import FAMILIES, MAIN
from tamplang.compiler.pipeline import check
from tamplang.langs.diagnostics import Diagnostic

DOUBLED = [name for name in FAMILIES if name.startswith("doubled")]


def diagnostics(folder: Path, name: str, size: int) -> tuple[Diagnostic, ...]:
    for file, text in FAMILIES[name].make(size).items():
        (folder / file).write_text(text, encoding="utf-8")
    return check(folder / MAIN)


def limits(found: tuple[Diagnostic, ...]) -> list[Diagnostic]:
    return [d for d in found if d.code in growth.LIMITS and d.span is not None]


@pytest.mark.parametrize("name", DOUBLED)
def test_doubling_is_refused_at_its_line_and_what_is_small_is_not(tmp_path: Path, name: str) -> None:
    assert not [d for d in diagnostics(tmp_path, name, 4) if d.is_error]
    (limit,) = limits(diagnostics(tmp_path, name, 40))
    assert limit.span is not None and limit.span.line > 1


@pytest.mark.parametrize(
    ("name", "size", "limited"),
    [
        ("chained functions", 1000, True),
        ("chained derived", 1000, True),
        ("chained derived backwards", 1000, True),
        ("chained scenes", 1000, True),
        ("chained imports", 1000, True),
        ("chained types", 2000, False),
        ("chained rules", 300, False),
        ("nested nots", 95, False),
        ("nested nots", 1000, True),
        ("nested quantifiers", 40, False),
        ("square bodies", 1000, True),
        ("square loop", 1000, True),
        ("empty loop", 1000, True),
        ("square goal", 1000, True),
        ("wide conjunction", 10_000, False),
        ("wide facts", 5000, False),
        ("long number", 900_000, False),
    ],
)
def test_chains_nests_and_loops_are_read_or_refused_once(tmp_path: Path, name: str, size: int, limited: bool) -> None:
    found = diagnostics(tmp_path, name, size)
    assert len(limits(found)) == limited
    assert any(d.is_error for d in found) == limited


def test_a_file_reached_through_two_links_counts_once(tmp_path: Path) -> None:
    (tmp_path / "words.tamp").write_text("type base < object\n", encoding="utf-8")
    (tmp_path / "one.tamp").symlink_to("words.tamp")
    (tmp_path / "two.tamp").symlink_to("words.tamp")
    text = 'import "one.tamp"\nimport "two.tamp"\npredicate (on X: base) static\n'
    (tmp_path / MAIN).write_text(text, encoding="utf-8")
    assert check(tmp_path / MAIN) == ()


def test_a_file_that_imports_itself_through_a_link_is_a_ring(tmp_path: Path) -> None:
    (tmp_path / "link.tamp").symlink_to(MAIN)
    (tmp_path / MAIN).write_text('import "link.tamp"\ntype base < object\n', encoding="utf-8")
    assert "E0112" in {d.code for d in check(tmp_path / MAIN)}


def test_the_measure_tells_a_quadratic_family_from_a_linear_one() -> None:
    assert growth.exponent([(1000, 1.0), (2000, 4.0)]) == pytest.approx(2.0)
    assert growth.exponent([(1000, 1.0), (2000, 2.1)]) < growth.EXPONENT
    record = growth.measure("doubled functions", 40, "ir")
    assert growth.limited(record) and not record["traceback"]
