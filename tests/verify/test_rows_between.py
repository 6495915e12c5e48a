"""What literals ask all the time is checked between samples: feet of closed loops, and `during` rows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tamplang.runtime.plan import Plan
from tamplang.runtime.verify import verify

from .motions import Maker
from .stamping import HIDING, Stamps, even, stamped

TURN = np.eye(7)[0]

# --- closed loops --------------------------------------------------------------------------------------------------

LOOP = """
import std.crawler
import std.motion
predicate (planted B: effector)
rule plant(B: effector, Y: object) {
    pre   not (planted B)
    post  (planted B), [stable Y B]
}
rule sway(B: effector, Y: object) {
    pre   (planted B)
    post  (swayed B)
}
predicate (swayed B: effector)
task loop() {
    object left: box(0.2 m, 0.2 m, 0.05 m) at (0, 0, 0)
    object right: box(0.2 m, 0.2 m, 0.05 m) at (0.5 m, 0, 0)
    crawler c: A on left
    goal (swayed c.B)
}
"""
BEND = math.asin(0.25 / 0.35)
ARCH = np.array([0.0, BEND, 0.0, np.pi - 2 * BEND, 0.0, BEND, 0.0])


def loop(sway: float) -> Plan:
    """A robot that has planted its second foot sways by a joint of the first and back: the second foot goes with it."""
    maker = Maker(LOOP, "loop")
    maker.phase("plant", ("c.B", "right"), [ARCH])
    ways = 0.5 - 0.5 * np.cos(np.linspace(0.0, 2.0 * np.pi, 101)[1:])
    maker.phase("sway", ("c.B", "right"), [ARCH + way * sway * TURN for way in ways], seconds=8.0)
    return maker.plan()


@pytest.mark.parametrize("stamps", HIDING.values(), ids=list(HIDING))
def test_a_foot_that_leaves_its_place_between_samples_is_seen(stamps: Stamps) -> None:
    failures = verify(stamped(loop(1.0), [even(10), stamps])).failures
    assert {f.kind for f in failures} >= {"slip_m", "slip_rad"}
    assert max(f.amount for f in failures if f.kind == "slip_m") > 0.1


@pytest.mark.parametrize(("slip", "kept"), [(0.5e-3, True), (0.95e-3, True), (1.05e-3, False), (3e-3, False)])
def test_a_foot_may_slip_by_as_much_as_the_limit(slip: float, kept: bool) -> None:
    verdict = verify(stamped(loop(slip / 0.5), even(2)))
    assert verdict.verified == kept
    assert kept or "slip_m" in {f.kind for f in verdict.failures}
    assert verdict.worst["slip_m"] == pytest.approx(slip, rel=0.01)


# --- rows that hold all the time -----------------------------------------------------------------------------------

ROWS = """
import std.crawler
import std.motion
predicate (shown c: module)
motion [fine X: effector, Y: object] { during ROW }
rule show(c: module, X: effector, Y: object, k: 1 .. 2) {
    pre   k = 1 or (shown c)
    post  (shown c), if k = 1 { [fine X Y] }
}
task rows() {
    object slab: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    object bead: sphere(0.02 m) at (0.9 m, 0.3 m, 0.6 m)
    crawler c: A on slab
    goal (shown c)
}
"""
TERMS = {
    "position": "dot(position(X), (1, 0, 0)) <= AT",
    "norm": "norm(position(X) - position(Y)) >= AT m",
    "product": "dot(position(X), position(X)) * dot(axis(X, z), (0, 0, 1)) <= AT",
    "quotient": "dot(position(X), (1, 0, 0)) / (1 + dot(position(X), position(X))) <= AT",
    "root": "sqrt(dot(position(X), position(X))) >= AT",
    "least": "least(top(X) + 1 m, gap(X, Y)) >= AT m",
    "cross": "dot(cross(position(X), (0, 1, 0)), (0, 0, 1)) <= AT",
    "axis": "dot(axis(X, z), (0, 0, 1)) >= AT",
    "centre": "dot(centre(X), (1, 0, 0)) <= AT",
    "bottom": "bottom(X) >= AT m",
    "top": "top(X) >= AT m",
    "gap": "gap(X, Y) >= AT m",
    "inside": "inside(X, slab) >= AT m",
}


def nod(row: str) -> Plan:
    """An arm nods by 1 rad and comes back."""
    maker = Maker(ROWS.replace("ROW", row.replace("slab", "Y")), "rows")
    thing = "slab" if "slab" in row else "bead"
    maker.phase("show", ("c", "c.B", thing, "1"), [0.3 * np.eye(7)[1]])
    ways = 0.5 - 0.5 * np.cos(np.linspace(0.0, 2.0 * np.pi, 101)[1:])
    knots = [(0.3 + way) * np.eye(7)[1] + 0.5 * way * np.eye(7)[3] for way in ways]
    maker.phase("show", ("c", "c.B", thing, "2"), knots, seconds=8.0)
    return maker.plan()


@pytest.mark.parametrize("row", TERMS.values(), ids=list(TERMS))
def test_a_row_that_breaks_between_samples_is_seen(row: str) -> None:
    """By how much it is broken does not depend on the samples; a row that asks just that little less holds."""
    sign = 1.0 if ">=" in row else -1.0
    assert verify(stamped(nod(row.replace("AT", f"{-9.0 * sign!r}")), even(2))).verified
    (failure,) = verify(stamped(nod(row.replace("AT", f"{9.0 * sign!r}")), even(2))).failures
    limit = {"during_m": 2e-3, "during": 5e-3}[failure.kind]
    edge = sign * (9.0 - failure.amount)
    for off, kept in ((0.9 * limit, True), (1.1 * limit, False)):
        verdict = verify(stamped(nod(row.replace("AT", f"{edge + sign * off!r}")), even(2)))
        assert verdict.verified == kept, verdict.failures
        assert verdict.worst[failure.kind] == pytest.approx(off, abs=5e-5)
