"""How many actions get their motion in one window."""

from __future__ import annotations

from pathlib import Path

from tamplang.api import load
from tamplang.runtime.planner.receding.horizon_length import horizon_of
from tamplang.runtime.planner.receding.settings import RECEDING

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def test_a_horizon_grows_where_windows_are_hard_and_shrinks_where_they_are_easy() -> None:
    horizon = horizon_of(None)
    assert horizon.length == RECEDING.first_length
    lengths = []
    for hard in [True, False, True, True, *[False] * RECEDING.most_length]:
        horizon.adapt(hard)
        lengths.append(horizon.length)
    first, most = RECEDING.first_length, RECEDING.most_length
    assert lengths[:4] == [2 * first, 2 * first - 1, most - 2, most]
    assert lengths[-1] == RECEDING.least_length


def test_a_horizon_that_is_given_stays() -> None:
    horizon = horizon_of(3)
    horizon.adapt(True)
    assert horizon.length == 3


def test_a_run_adapts_and_sees_beyond_its_windows() -> None:
    """The last actions go from where few stances reach the target: a run that looks at a window alone ends before."""
    task = load(EXAMPLES / "climb.tamp", n=16, crawlers=1)
    fixed, adaptive = task.run(), task.run(horizon="auto")
    assert fixed.status == adaptive.status == "solved"
    motions = [window.motions for window in adaptive.record.windows]
    assert motions[0] == RECEDING.first_length > motions[-1] and sum(motions) == len(adaptive.record.phases)
    assert {window.motions for window in fixed.record.windows[:-1]} == {RECEDING.first_length}
