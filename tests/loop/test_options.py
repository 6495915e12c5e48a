"""What `Task.solve` says about options that do not exist, or do not take their value."""

from __future__ import annotations

from typing import Any

import pytest

from tamplang.api import Task
from tamplang.compiler.pipeline import compile_text
from tamplang.langs.diagnostics import UsageError

TEXT = """
predicate (lies X: object, Y: object)
rule push(X: object, Y: object) { post (lies X Y) }
task one {
    object floor: box(1 m, 1 m, 10 cm) at (0, 0, -10 cm)
    object ball: sphere(4 cm) at (0, 0, 1 m)
    fact (lies ball floor)
    goal (lies ball floor)
}
"""


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"serch": "bfs"}, "there is no option `serch`; did you mean `search`?"),
        ({"job": 2}, "there is no option `job`; did you mean `jobs`?"),
        ({"margin": 0.1}, "there is no option `margin`"),
        ({"bound": "pth"}, "option `bound` is one of seq, seq-path, path, not 'pth'; did you mean `path`?"),
        ({"nodes": 0}, "option `nodes` is a whole number from 1, not 0"),
        ({"solutions": 1001}, "option `solutions` is a whole number from 1 to 1000, not 1001"),
        ({"time": float("nan")}, "option `time` is a number of seconds above 0, not nan"),
        ({"time": -1.0}, "option `time` is a number of seconds above 0, not -1.0"),
    ],
)
def test_an_unfit_option_is_named(given: dict[str, Any], told: str) -> None:
    with pytest.raises(UsageError) as caught:
        Task(*compile_text(TEXT)).solve(**given)
    assert str(caught.value) == told


def test_what_is_not_given_is_no_fault() -> None:
    result = Task(*compile_text(TEXT)).solve(bound=None, solver=None, slices=None, nodes=5)
    assert result.actions == ()
