"""The PDDL export is well-formed and declares what it uses."""

from __future__ import annotations

import re

import pytest

from tamplang.compiler.ir import Problem
from tamplang.compiler.symbolic.pddl import to_pddl

from . import variants
from .problems import climb, pick_and_place

PROBLEMS = {"climb": lambda: climb(3, 2), "items": lambda: pick_and_place(3), **variants.PROBLEMS}


@pytest.mark.parametrize("name", PROBLEMS)
def test_is_balanced_and_declares_its_predicates(name: str) -> None:
    problem: Problem = PROBLEMS[name]()
    domain, task = to_pddl(problem)
    for text in (domain, task):
        assert text.count("(") == text.count(")")
    declared = set(re.findall(r"\((\w+) \?", domain.partition("(:predicates")[2].partition("(:action")[0]))
    words = {"and", "or", "not", "exists", "forall", "when", "define", "domain", "problem"}
    used = set(re.findall(r"\((\w+)", domain.partition("(:action")[2] + task)) - words
    assert used <= declared
    variables = re.findall(r"\(:action.*?\n    :parameters \((.*?)\)\n(.*?)(?=\n  \(:action|\Z)", domain, re.DOTALL)
    for parameters, body in variables:
        free = set(re.findall(r"\?(\w+)", body)) - set(re.findall(r"\(\??(\w+) - object_\)", body))
        bound = set(re.findall(r"\((?:exists|forall) \(([^)]*) - object_\)", body))
        assert free <= set(re.findall(r"\?(\w+)", parameters)) | {n.strip("?") for b in bound for n in b.split()}
