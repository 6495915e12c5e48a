"""The second checker measures what joints and feet bear at rest, and the masses that are stated."""

from __future__ import annotations

import msgspec
import pytest
from msgspec.structs import replace

from benchmarks.trust.checker import judge, read
from tamplang.runtime.plan import Plan

from ..verify.loaded import reaching, strength


def kinds(plan: Plan) -> set[str]:
    return {f.kind for f in judge(read(msgspec.json.encode(plan).decode()))}


@pytest.mark.parametrize(
    ("stated", "kind"),
    [
        ({"hoist": f"torque {strength(1.1)}"}, "torque_ratio"),
        ({"turn": f"bearing {strength(1.1)}"}, "bearing_ratio"),
        ({"holds": f"holds pad(force 1 kN, moment {strength(1.1)})"}, "foot_ratio"),
    ],
)
def test_loads_beyond_what_is_stated_are_seen(stated: dict[str, str], kind: str) -> None:
    assert kinds(reaching(**stated)) == {kind}


def test_loads_within_it_are_not_and_false_torques_are() -> None:
    plan = reaching(
        hoist=f"torque 1 N m brake {strength(0.9)}", turn=f"bearing {strength(0.9)}",
        holds=f"holds pad(force 1 kN, moment {strength(0.9)})",
    )  # fmt: skip
    assert kinds(plan) == set()
    more = [replace(t, values=[[v + 0.1 for v in row] for row in t.values]) for t in plan.statics.torques]
    assert kinds(replace(plan, statics=replace(plan.statics, torques=more))) == {"statics"}
