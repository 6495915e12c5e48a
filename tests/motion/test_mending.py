"""Switches mended around phases without a path (`runtime.motion.mending`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.motion.keyframes.local_repair import Mend, mended, spans
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.phases import solve_sequence_path
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import Breach, Violation

from .fixtures import pick_and_place


def test_stretches_that_overlap_are_one() -> None:
    assert spans([4, 7, 8, 20], 1, 21) == [(3, 5), (6, 9), (19, 20)]
    assert spans([4, 7], 2, 21) == [(2, 9)]


def test_a_mend_leaves_all_other_switches_and_paths() -> None:
    skeleton, settings, budget = pick_and_place(3), MotionSettings(), Budget(60.0)
    sequence = solve_sequence(skeleton, settings, Seed(0), budget)
    paths = solve_sequence_path(skeleton, sequence.configurations, settings, Seed(0), budget)
    assert sequence.feasible and paths.feasible
    refused = replace(paths, feasible=False, violations=[Violation(2, Breach.COLLISION, ("a", "b"), 0.1, "m")])
    again = mended(skeleton, sequence, refused, Mend(1, 1), settings, Seed(0), budget)
    assert again.feasible
    same = [
        all(np.array_equal(slot, after.modules[name]) for name, slot in before.modules.items())
        for before, after in zip(sequence.configurations, again.configurations, strict=True)
    ]
    assert same == [True, True, False, False, True, True, True]
    for before, after in zip(sequence.configurations[4:], again.configurations[4:], strict=True):
        assert all(np.array_equal(pose, after.bodies[name]) for name, pose in before.bodies.items())
    found = solve_sequence_path(skeleton, again.configurations, settings, Seed(0), budget, known=refused)
    assert found.feasible
    kept = [np.array_equal(found.paths[k].modules["c"][:, 7:], paths.paths[k].modules["c"][:, 7:]) for k in range(6)]
    assert kept == [True, False, False, False, True, True]
