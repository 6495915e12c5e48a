"""A tenth of the hard inputs of the trust benchmark: commands end under a budget with a status and a code."""

from __future__ import annotations

import pytest

from benchmarks.trust.budgets import measure
from benchmarks.trust.hard import HARD


def test_there_are_more_than_forty_inputs() -> None:
    assert len(HARD) > 60


@pytest.mark.parametrize(
    "name", ["pddl wide bodies", "solve wide loop", "search bfs", "run", "check mesh stl", "solve silent cluster"]
)
def test_commands_end_with_a_code(name: str) -> None:
    record = measure(name, 0.6)
    assert record["sound"] and record["coded"] and record["status"] == 4
