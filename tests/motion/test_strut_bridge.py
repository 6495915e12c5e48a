"""A module without joints that docks, is carried and carries on: the strut of `examples/strut_bridge.tamp`."""

from __future__ import annotations

from pathlib import Path

import tamplang

BRIDGE = Path(__file__).resolve().parents[2] / "examples" / "strut_bridge.tamp"


def test_a_strut_makes_the_robot_long_enough() -> None:
    result = tamplang.load(BRIDGE).solve(time=60.0)
    assert result.status == "solved" and result.plan is not None and result.plan.verify().verified
    assert [action.split("(")[0] for action in result.actions] == ["pick", "connect", "stepTogether"]


def test_without_the_strut_there_is_no_way() -> None:
    result = tamplang.load(BRIDGE, struts=0).solve(time=60.0)
    assert result.status == "infeasible"


def test_a_wider_gap_has_no_bridge() -> None:
    result = tamplang.load(BRIDGE, gap="3.4 m").solve(time=60.0)
    assert result.status == "infeasible"
