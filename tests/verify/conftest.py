"""Plans for the checker: real tasks with motions made by hand, so that no planner takes part."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tamplang.runtime.plan import Plan

from .motions import Maker, bent

BEND = math.asin(0.25 / 0.35)
"""Bends the crawler into an arch whose feet stand 0.5 m apart at the same height."""

HOP = """
import std.crawler
import std.rules

predicate (shown X: object)

## Lifts what it holds, for all to see.
rule show(A: effector, X: object) {
    pre   (grasped A X), not (shown X)
    post  (shown X)
}

task hop() {
    base left: box(0.3 m, 0.3 m, 0.05 m) at (0, 0, 0)
    base right: box(0.3 m, 0.3 m, 0.05 m) at (0.5 m, 0, 0)
    object ball: sphere(0.04 m) at (BALL)
    fact (grippable ball)
    crawler c: A on left
    goal (shown ball)
}
"""

PAIR = """
import std.crawler
import std.motion

predicate (waved c: module)

rule wave(c: module) {
    pre   not (waved c)
    post  (waved c)
}

task wave() {
    object slab: box(2 m, 2 m, 0.05 m) at (0, 0, 0)
    for k in 1 .. 2 {
        crawler c[k]: A on slab at (0, 0.8 m * k - 1.2 m)
    }
    goal forall k in 1 .. 2 { (waved c[k]) }
}
"""


def make_hop() -> Plan:
    """Four phases: set B down on the right, A back down on the left, B grasps a ball, and shows it."""
    arch, reach = bent(BEND), np.array([0.6, 0.2, 0.4, -0.5, 0.3, 0.4, 0.0])
    x, y, z = Maker.tip(reach, 0.05 + 0.04)
    maker = Maker(HOP.replace("BALL", f"{x:.9f} m, {y:.9f} m, {z:.9f} m"), "hop")
    maker.phase("step", ("c.A", "c.B", "left", "right"), [arch])
    maker.phase("step", ("c.B", "c.A", "right", "left"), [arch - 0.35 * np.eye(7)[3], arch], seconds=8.0)
    maker.phase("grasp", ("c.B", "ball"), [reach - 0.3 * np.eye(7)[1], reach], seconds=8.0)
    maker.phase("show", ("c.B", "ball"), [reach * 0.6])
    return maker.plan()


@pytest.fixture(scope="session")
def hop() -> Plan:
    return make_hop()


@pytest.fixture(scope="session")
def pair() -> Plan:
    """Two modules stand side by side; first one waves, then the other."""
    maker = Maker(PAIR, "wave")
    maker.phase("wave", ("c[1]",), [np.array([0.5, 0.2, 0.0, -0.3, 0.0, 0.3, 0.0])])
    maker.phase("wave", ("c[2]",), [np.array([-0.5, 0.4, 0.0, -0.3, 0.0, 0.3, 0.0])])
    return maker.plan()
