"""Lengths of the scene: plain arithmetic agrees with coal, rows agree with single pairs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.compiler.ir import Body, Chain, Pose, Shape
from tamplang.compiler.symbolic.geometry import Placed, SceneLengths, _coal_distance, path_length, shape_distance
from tamplang.compiler.symbolic.symmetry import is_reversible

from .problems import CRAWLER, box, climb, lit, module, problem

lengths = st.floats(0.05, 1.0)
shapes = st.one_of(
    st.builds(lambda a, b, c: Shape("box", (a, b, c)), lengths, lengths, lengths),
    st.builds(lambda r: Shape("sphere", (r,)), lengths),
    st.builds(lambda r, h: Shape("capsule", (r, h)), lengths, lengths),
)


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    axis = draw(st.sampled_from([(1, 0, 0), (0, 1, 0), (0, 0, 1)]))
    angle = draw(st.one_of(st.sampled_from([0.0, math.pi / 2, math.pi]), st.floats(-3, 3)))
    x, y, z = (draw(st.floats(-3, 3)) for _ in range(3))
    s = math.sin(angle / 2)
    return (x, y, z, axis[0] * s, axis[1] * s, axis[2] * s, math.cos(angle / 2))


@settings(max_examples=80, deadline=None)
@given(shapes, poses(), shapes, poses())
def test_distance_agrees_with_coal(a: Shape, at: Pose, b: Shape, there: Pose) -> None:
    bodies = [Body("a", "object", a, at, False), Body("b", "object", b, there, False)]
    geometry = SceneLengths(problem(bodies, [], (), lit("held", "X")))
    exact = _coal_distance(Placed(a, at), Placed(b, there))
    assert geometry.distance(0, 1) == pytest.approx(exact, abs=1e-5)
    assert shape_distance(Placed(a, at), Placed(b, there)) == pytest.approx(exact, abs=1e-5)


def test_rows_agree_with_pairs() -> None:
    geometry = SceneLengths(climb(6, 2, seed=3))
    everything = np.arange(len(geometry.names))
    for i in range(len(everything)):
        distances = geometry.distance(np.array(i), everything)
        strides = geometry.stride(np.array(i), everything, 0.03)
        assert [geometry.distance(i, j) for j in range(len(everything))] == pytest.approx(list(distances))
        assert [geometry.stride(i, j, 0.03) for j in range(len(everything))] == pytest.approx(list(strides))


def test_stride_measures_shrunk_top_faces() -> None:
    low, high = box("low", "base", (1, 1, 0.2), (0, 0, 0)), box("high", "base", (1, 1, 0.4), (2, 0, 0.5))
    geometry = SceneLengths(problem([low, high], [], (), lit("held", "X")))
    assert geometry.stride(0, 1, 0.1) == pytest.approx(math.hypot(1.2, 0.6))
    assert geometry.stride(0, 1, 5.0) == pytest.approx(math.hypot(2.0, 0.6))


def test_reach_is_an_upper_bound() -> None:
    assert path_length(CRAWLER, "A", "B") == pytest.approx(1.0)
    assert path_length(CRAWLER, "B", "A") == pytest.approx(1.0)
    assert is_reversible(CRAWLER)
    geometry = SceneLengths(problem([], [module("m[1]", 0, 0, 0), module("m[2]", 1, 0, 0)], (), lit("held", "X")))
    chain = Chain((("m[1]", "m[1].A", "m[1].B"), ("m[2]", "m[2].B", "m[2].A")))
    assert geometry.chain_reach(chain) == pytest.approx(2.1)
    assert geometry.longest_reach(2) == pytest.approx(2.1)
