"""Boxes around groups leave out no pair that is near."""

from __future__ import annotations

import numpy as np
import pytest

from tamplang.runtime.planner.motion.phases.pair_groups import PairGroups


@pytest.mark.parametrize("things", [2, 9, 40])
def test_no_near_pair_is_left_out(things: int) -> None:
    random = np.random.default_rng(things)
    group = random.integers(0, 5, things)
    every = np.array([(i, k) for i in range(things) for k in range(i)])
    pairs = every[random.random(len(every)) < 0.7] if len(every) > 1 else every
    middles = random.normal(0.0, 3.0, (5, 3))
    centres = middles[group][:, :, None, None] + random.normal(0.0, 0.5, (things, 3, 2, 3))
    radii = random.uniform(0.0, 0.3, (things, 2, 3))
    first, second = pairs.T
    apart = np.linalg.norm(centres[first] - centres[second], axis=1)
    near = np.argwhere(apart < radii[first] + radii[second]).tolist()
    found = np.column_stack(PairGroups(pairs, group).meeting(centres, radii)).tolist()
    assert found == sorted(found)
    assert [entry for entry in found if entry in near] == near
    assert len(found) < len(pairs) * 6 or things == 2


def test_there_may_be_no_pairs() -> None:
    groups = PairGroups(np.zeros((0, 2), np.intp), np.zeros(3, np.intp))
    found = groups.meeting(np.zeros((3, 3, 1, 1)), np.ones((3, 1, 1)))
    assert [len(part) for part in found] == [0, 0, 0]
