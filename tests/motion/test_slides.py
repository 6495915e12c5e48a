"""What slides right through something at rest between two switches (`runtime.motion.slides`)."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.ir import Action
from tamplang.compiler.pipeline import compile_problem
from tamplang.runtime.planner.motion.keyframes.prismatic_sweeps import all_pierced, held_back
from tamplang.runtime.skeleton import Configuration, Phase, Skeleton, start_configuration

SCENE = """
import std.rules
import std.mobile

task park() {
    object floor: box(8 m, 8 m, 0.1 m) at (0, 0, -0.05 m)
    object tray: box(0.4 m, 1.6 m, 0.2 m) at (1 m, 0, 0.1 m)
    place bay: box(0.2 m, 0.2 m, 0.01 m) at (1.5 m, 0.4 m, 0.005 m)
    mobileBase plate: W on floor at (0, 0)
    goal (parked plate.M bay)
}
"""


def _scene(folder: Path, phases: int) -> tuple[Skeleton, Configuration]:
    path = folder / "task.tamp"
    path.write_text(SCENE)
    problem, _ = compile_problem(path, None, {}, 0)
    phase = Phase(Action("drive", ()), problem.init_motion, frozenset())
    return Skeleton(problem, (phase,) * phases, problem.init_motion), start_configuration(problem)


def _driven(configuration: Configuration, x: float, y: float) -> Configuration:
    """The plate is driven by so much."""
    result = configuration.copy()
    result.modules["plate"][7:9] += (x, y)
    return result


@pytest.mark.parametrize(
    ("x", "y", "through"), [(2.0, 0.0, True), (0.6, 0.0, False), (0.0, 2.0, False), (2.0, 3.0, False)]
)
def test_ways_right_through_a_tray_are_told_from_those_beside_it(
    x: float, y: float, through: bool, tmp_path: Path
) -> None:
    skeleton, start = _scene(tmp_path, 1)
    assert all_pierced(skeleton, 0, [start, _driven(start, x, y)]) == ([0] if through else [])


def test_the_first_of_two_such_phases_is_held_back_before_what_it_would_go_through(tmp_path: Path) -> None:
    skeleton, start = _scene(tmp_path, 3)
    across = _driven(start, 2.0, 0.0)
    slices = [start, across, start, _driven(start, 0.2, 0.0)]
    assert all_pierced(skeleton, 0, slices) == [0, 1]
    held = held_back(skeleton, 0, slices, [0, 1])
    assert all_pierced(skeleton, 0, held) == []
    assert 0.5 < held[1].modules["plate"][7] < 0.8
    assert all((a.modules["plate"] == b.modules["plate"]).all() for a, b in zip(held[2:], slices[2:], strict=True))
