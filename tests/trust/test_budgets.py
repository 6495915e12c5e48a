"""A tenth of the hard inputs of the trust benchmark: commands end under a budget with a status and a code."""

from __future__ import annotations

import math

import pytest

from benchmarks.trust.budgets import measure
from benchmarks.trust.hard import HARD
from tamplang.runtime.budget import Budget, OutOfTime


def test_there_are_more_than_forty_inputs() -> None:
    assert len(HARD) > 60


@pytest.mark.parametrize(
    "name", ["pddl wide bodies", "solve wide loop", "search bfs", "run", "check mesh stl", "solve silent cluster"]
)
def test_commands_end_with_a_code(name: str) -> None:
    record = measure(name, 0.6)
    assert record["sound"] and record["coded"] and record["status"] == 4


def test_what_is_left_of_a_budget_is_never_nothing() -> None:
    """Where reading took all of `--time`, an option of 0 s was asked for, and refused as an error of the program."""
    assert Budget(None).left() == math.inf
    with pytest.raises(OutOfTime):
        Budget(0.0).left()
