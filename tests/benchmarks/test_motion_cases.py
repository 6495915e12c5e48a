"""The judge of the common motion benchmark sees what is right and what is not."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.peer import cases, judge, ours


@pytest.fixture(scope="module")
def solved() -> tuple[cases.Case, np.ndarray, np.ndarray]:
    case = cases.climb(2, 0)
    prepared = ours.climb(case)
    answer = ours.solve(prepared, "path", 0)
    return case, *ours.motion(prepared, answer["paths"])


def test_a_path_is_right(solved: tuple[cases.Case, np.ndarray, np.ndarray]) -> None:
    accepted, worst = judge.judge(*solved, cases.SLICES, False)
    assert accepted
    assert worst["switch_m"] < 1e-5
    assert judge.cost(solved[1], 2, cases.SLICES) > 0.0


@pytest.mark.parametrize(
    ("row", "column", "by", "kind"),
    [(40, 2, 0.01, "switch_m"), (10, 0, 0.01, "slip_m"), (10, 8, 3.0, "limit_rad")],
)
def test_a_spoilt_path_is_not(
    solved: tuple[cases.Case, np.ndarray, np.ndarray], row: int, column: int, by: float, kind: str
) -> None:
    case, crawler, items = solved
    crawler = crawler.copy()
    crawler[row, column] += by
    accepted, worst = judge.judge(case, crawler, items, cases.SLICES, False)
    assert not accepted
    assert worst[kind] > judge.ALLOWED[kind]


def test_what_is_out_of_reach_is_missed() -> None:
    assert judge.nearest_miss(cases.too_far(1, 0)) > 0.1
    assert judge.nearest_miss(cases.climb(1, 0)) < 1e-6
