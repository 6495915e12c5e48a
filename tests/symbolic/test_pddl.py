"""The PDDL export is positive STRIPS, declares what it uses, and means the same as the rules."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from tamplang.compiler.ir import Problem
from tamplang.compiler.scenes.parameters import UsageError
from tamplang.compiler.symbolic.pddl import to_pddl
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.search.best_first import SkeletonSearch

from . import variants
from .problems import climb, pick_and_place

PROBLEMS = {"climb": lambda: climb(3, 2), "items": lambda: pick_and_place(3)}
ATOM = re.compile(r"\(([^()]+)\)")
State = frozenset[tuple[str, ...]]


@pytest.mark.parametrize("name", PROBLEMS)
def test_is_balanced_and_declares_its_predicates(name: str) -> None:
    problem: Problem = PROBLEMS[name]()
    domain, task = to_pddl(problem)
    for text in (domain, task):
        assert text.count("(") == text.count(")")
    declared = set(re.findall(r"\((\w+)(?: \?|\))", domain.partition("(:predicates")[2].partition("(:action")[0]))
    words = {"and", "not", "define", "domain", "problem"}
    used = set(re.findall(r"\((\w+)", domain.partition("(:action")[2] + task)) - words
    assert used <= declared
    for parameters, condition, effect in actions(domain):
        assert not re.search(r"\((not|or|exists|forall|when) ", condition)
        assert set(re.findall(r"\?\w+", condition + effect)) <= set(parameters.split())


def actions(domain: str) -> list[tuple[str, str, str]]:
    pattern = r":parameters \((.*?)\)\n    :precondition (.*?)\n    :effect (.*?)(?=\n  \(:action|\n\)\n)"
    return re.findall(pattern, domain, re.DOTALL)


def shortest(domain: str, task: str, most: int) -> int | None:
    """Breadth-first search on the text itself."""
    init = frozenset(tuple(a.split()) for a in ATOM.findall(task.partition("(:init")[2].partition("(:goal")[0]))
    goal = {tuple(a.split()) for a in ATOM.findall(task.partition("(:goal")[2])}
    schemas = []
    for _, condition, effect in actions(domain):
        gone = [tuple(a.split()) for a in re.findall(r"\(not \(([^()]+)\)\)", effect)]
        come = [tuple(a.split()) for a in ATOM.findall(re.sub(r"\(not \([^()]+\)\)", "", effect))]
        schemas.append(([tuple(a.split()) for a in ATOM.findall(condition)], gone, come))
    layer, seen, depth = {init}, {init}, 0
    while layer and depth <= most:
        if any(goal <= state for state in layer):
            return depth
        layer = {t for s in layer for schema in schemas for t in following(s, *schema)} - seen
        seen |= layer
        depth += 1
    return None


def following(state: State, condition: list, gone: list, come: list) -> set[State]:
    """All states after one action."""
    bindings: list[dict[str, str]] = [{}]
    by_name: dict[str, list[tuple[str, ...]]] = {}
    for fact in state:
        by_name.setdefault(fact[0], []).append(fact)
    for atom in sorted(condition, key=lambda a: any(x.startswith("?") for x in a)):
        bindings = [b for old in bindings for fact in by_name.get(atom[0], ()) if (b := unified(atom, fact, old))]
    found = set()
    for b in bindings:
        named = [{tuple(b.get(x, x) for x in atom) for atom in atoms} for atoms in (gone, come)]
        found.add(frozenset((state - named[0]) | named[1]))
    return found


def unified(atom: tuple[str, ...], fact: tuple[str, ...], old: dict[str, str]) -> dict[str, str] | None:
    b = {**old, "": ""}
    for pattern, value in zip(atom, fact, strict=True):
        if (b.setdefault(pattern, value) if pattern.startswith("?") else pattern) != value:
            return None
    return b


LENGTHS = [(lambda: climb(3, 2), 1), (lambda: climb(2, 1), 1), (lambda: pick_and_place(1), 0)]


@pytest.mark.parametrize("make, extra", LENGTHS)
def test_plans_are_as_long_as_ours(make: Callable[[], Problem], extra: int) -> None:
    """A goal with alternatives takes one action more."""
    problem = make()
    candidate = SkeletonSearch(problem, Successors(problem), "astar", Budget(20)).next()
    assert candidate is not None
    assert shortest(*to_pddl(problem), 8) == len(candidate.actions) + extra


@pytest.mark.parametrize("name", variants.PROBLEMS)
def test_what_pddl_cannot_say_is_told_to_the_user(name: str) -> None:
    try:
        domain, _ = to_pddl(variants.PROBLEMS[name]())
    except UsageError as error:
        assert "PDDL" in str(error)
    else:
        assert domain.startswith("(define")
