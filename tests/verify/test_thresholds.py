"""Every limit of the verifier's table: a figure at it passes, one just above it is a failure; the worst is kept."""

from __future__ import annotations

import math

import pytest

from tamplang.runtime.verify.findings import Findings
from tamplang.runtime.verify.limits import LIMITS, RATE_SLACK, RATES


@pytest.mark.parametrize("kind", LIMITS)
def test_a_figure_at_its_limit_passes_and_one_above_fails(kind: str) -> None:
    limit = LIMITS[kind]
    below = Findings()
    assert below.measure(kind, limit, "text") and below.verdict().verified
    above = Findings()
    assert not above.measure(kind, limit * (1.0 + 1e-9), "text", time=1.5, between=("a", "b"))
    verdict = above.verdict()
    assert not verdict.verified and [f.kind for f in verdict.failures] == [kind]
    assert (verdict.failures[0].time, verdict.failures[0].between) == (1.5, ["a", "b"])


@pytest.mark.parametrize("kind", RATES)
def test_a_rate_may_be_above_its_joint_s_limit_by_rounding_only(kind: str) -> None:
    assert Findings().measure(kind, 2.0 * RATE_SLACK, "text", limit=2.0)
    assert not Findings().measure(kind, 2.0 * RATE_SLACK * (1.0 + 1e-9), "text", limit=2.0)
    assert RATE_SLACK <= 1.001


@pytest.mark.parametrize("order", [(1e-4, 3e-4, 2e-4), (3e-4, 1e-4, 2e-4), (1e-4, 2e-4, 3e-4)])
def test_the_worst_figure_of_a_kind_is_kept(order: tuple[float, ...]) -> None:
    findings = Findings()
    for number, amount in enumerate(order):
        findings.measure("penetration_m", amount, "text", time=float(number))
    [measure] = findings.verdict().measures
    assert (measure.amount, measure.time, measure.limit) == (3e-4, float(order.index(3e-4)), LIMITS["penetration_m"])


def test_the_worst_rate_is_the_nearest_to_its_own_limit() -> None:
    findings = Findings()
    findings.measure(RATES[0], 3.0, "text", limit=6.0)
    findings.measure(RATES[0], 1.0, "text", limit=1.2)
    findings.measure(RATES[0], 4.0, "text", limit=9.0)
    assert findings.verdict().measures[0].amount == 1.0


@pytest.mark.parametrize("amount", [math.nan, math.inf])
def test_what_is_no_number_fails(amount: float) -> None:
    findings = Findings()
    assert not findings.measure("gap_m", amount, "text") and not findings.verdict().verified


def test_the_table_is_the_one_of_the_docs() -> None:
    """The limits are promises: a change of one is a change of what "verified" means, and is made here too."""
    known = {"position_m": 2e-3, "penetration_m": 1e-3, "slip_m": 1e-3, "joint_limit_rad": 1e-3, "gap_m": 2e-3,
             "orientation_rad": 5e-3, "start_m": 1e-6, "jump_m": 1e-5, "during_m": 2e-3}  # fmt: skip
    assert {kind: LIMITS[kind] for kind in known} == known
