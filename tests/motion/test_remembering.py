"""Answers remembered by the record itself."""

from __future__ import annotations

from dataclasses import dataclass

from tamplang.compiler.remembering import remembered


@dataclass(frozen=True)
class Record:
    name: str


def test_an_equal_record_is_asked_about_anew_and_the_same_one_is_not() -> None:
    asked: list[tuple[str, int]] = []

    @remembered(2)
    def twice(record: Record, number: int) -> str:
        asked.append((record.name, number))
        return record.name * number

    one, other = Record("a"), Record("a")
    assert [twice(one, 2), twice(one, 2), twice(other, 2), twice(one, 3)] == ["aa", "aa", "aa", "aaa"]
    assert asked == [("a", 2), ("a", 2), ("a", 3)]


def test_only_the_last_answers_are_kept() -> None:
    asked: list[str] = []

    @remembered(2)
    def name(record: Record) -> str:
        asked.append(record.name)
        return record.name

    a, b, c = Record("a"), Record("b"), Record("c")
    for record in (a, b, c, b, c, a):
        name(record)
    assert asked == ["a", "b", "c", "a"]
