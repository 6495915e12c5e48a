"""Motion found phase by phase (`runtime.planner.bounds.phase_by_phase`)."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.bounds import phase_by_phase
from tamplang.runtime.planner.bounds.phase_by_phase import PhasesRequest
from tamplang.runtime.planner.bounds.settings import BOUNDS
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import BoundResult, Skeleton

from .fixtures import pick_and_place


def _asked(monkeypatch: pytest.MonkeyPatch, refused: dict[int, int]) -> list[tuple[int, bool, float]]:
    """What is asked of P_seqPath: how many phases had a path, whether one more has, and up to how many joints it is
    looked for among samples. The next one after so many is refused as often as `refused` tells."""
    asked: list[tuple[int, bool, float]] = []
    plain = phase_by_phase.sequence_path

    def sequence_path(skeleton: Skeleton, *rest: object) -> BoundResult:
        found: BoundResult = plain(skeleton, *rest)  # type: ignore[arg-type]
        phase = len(skeleton) - 1
        if refused.get(phase, 0):
            refused[phase] -= 1
            found.feasible = False
        asked.append((phase, found.feasible, rest[-1]))  # type: ignore[arg-type]
        return found

    monkeypatch.setattr(phase_by_phase, "sequence_path", sequence_path)
    return asked


def test_phases_without_a_path_are_drawn_anew_and_those_before_them_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    skeleton, settings = pick_and_place(2), MotionSettings()
    asked = _asked(monkeypatch, {2: 2})
    known, path = PhasesRequest(settings, Seed(0), 3, 4).solved(skeleton, Budget(100.0))
    assert path is not None and path.feasible and len(path.paths) == 4 and not path.violations
    assert [phase for phase, *_ in asked] == [0, 1, 2, 2, 2, 3]
    assert [widest for *_, widest in asked] == [0.0, 0.0, 0.0, 0.0, BOUNDS.sampled_width, 0.0]
    assert len(known) == 5
    for (before, after), phase in zip(pairwise(known), path.paths, strict=True):
        np.testing.assert_allclose(phase.modules["c"][0, 7:], before.modules["c"][7:], atol=1e-9)
        np.testing.assert_allclose(phase.modules["c"][-1, 7:], after.modules["c"][7:], atol=1e-9)


def test_where_no_draw_helps_the_switch_before_is_drawn_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = _asked(monkeypatch, {2: BOUNDS.phase_draws})
    _, path = PhasesRequest(MotionSettings(), Seed(0), 3, 3).solved(pick_and_place(2), Budget(100.0))
    assert path is not None
    assert [phase for phase, *_ in asked] == [0, 1, *[2] * BOUNDS.phase_draws, 1, 2]


def test_what_has_no_path_from_anywhere_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = _asked(monkeypatch, {1: 10_000})
    _, path = PhasesRequest(MotionSettings(), Seed(0), 3, 2).solved(pick_and_place(1), Budget(200.0))
    assert path is None
    assert sum(phase == 1 for phase, *_ in asked) == BOUNDS.phase_draws * (BOUNDS.phase_setbacks + 1)


def test_the_answer_depends_on_the_question_alone_and_looks_ahead() -> None:
    skeleton, question = pick_and_place(2), PhasesRequest(MotionSettings(), Seed(3), 3, 2)
    (one, path), (other, again) = (question.solved(skeleton, Budget(100.0)) for _ in range(2))
    assert path is not None and again is not None and len(path.paths) == 2 and len(one) == 5
    assert all(np.array_equal(a.modules["c"], b.modules["c"]) for a, b in zip(one, other, strict=True))
    assert np.array_equal(path.paths[1].modules["c"], again.paths[1].modules["c"])


def test_where_there_is_less_room_than_wished_for_others_move_only_with_the_least(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wished: list[tuple[int, float, bool]] = []
    plain = phase_by_phase.solve_span

    def solve_span(
        skeleton: Skeleton, first: int, last: int, settings: MotionSettings, *rest: Any, **more: Any
    ) -> BoundResult:
        wished.append((first, settings.switch_margin, settings.still))
        found: BoundResult = plain(skeleton, first, last, settings, *rest, **more)
        found.feasible = found.feasible and not (first == 1 and settings.switch_margin > 0.04)
        return found

    monkeypatch.setattr(phase_by_phase, "solve_span", solve_span)
    asked = _asked(monkeypatch, {2: 1})
    _, path = PhasesRequest(MotionSettings(switch_margin=0.025), Seed(0), 3, 3).solved(pick_and_place(2), Budget(100.0))
    assert path is not None and [phase for phase, *_ in asked] == [0, 1, 2, 2]
    assert wished == [
        (0, 0.1, True),
        *((1, margin, still) for margin, still in ((0.1, True), (0.05, True), (0.025, False))),
        (2, 0.025, False),
        (2, 0.1, True),  # a switch without a way to it asks for all the room there may be
    ]
