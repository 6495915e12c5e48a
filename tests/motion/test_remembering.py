"""Answers remembered by the record itself, and what configurations of a scene share."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from tamplang.compiler.remembering import remembered
from tamplang.runtime.skeleton import may_differ, start_configuration

from .fixtures import pick_and_place


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


def test_configurations_share_what_never_moves_and_nothing_else() -> None:
    problem = pick_and_place(2).problem
    start = start_configuration(problem)
    copy = start.copy()
    fixed = next(b.name for b in problem.world.bodies.values() if not b.movable)
    free = next(b.name for b in problem.world.bodies.values() if b.movable)
    assert set(start.bodies) == set(problem.world.bodies) and len(start.bodies) == len(problem.world.bodies)
    assert copy.bodies[fixed] is start.bodies[fixed]
    with pytest.raises(ValueError):
        copy.bodies[fixed][0] = 1.0
    copy.bodies[free][0] += 1.0
    assert copy.bodies[free][0] == start.bodies[free][0] + 1.0
    assert list(may_differ(start, copy)) == [b.name for b in problem.world.bodies.values() if b.movable]
    moved = start.then(start.modules, {free: copy.bodies[free]})
    assert moved.bodies[free] is copy.bodies[free] and moved.bodies[fixed] is start.bodies[fixed]
