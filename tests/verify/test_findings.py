"""What the checker records can be written, wherever its figures come from."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from tamplang.runtime.verify.findings import Findings


def test_figures_of_arrays_are_written_as_numbers() -> None:
    findings = Findings()
    findings.measure("rest_rad", np.float64(0.25), "the arm turns")
    findings.fail("structure", "odd", amount=np.float32(0.5))
    text = msgspec.json.encode((list(findings.measures.values()), findings.failures))
    assert [m["amount"] for m in msgspec.json.decode(text)[0]] == [0.25]


def test_what_is_no_number_is_a_failure() -> None:
    findings = Findings()
    assert not findings.measure("rest_rad", math.nan, "the arm turns")
