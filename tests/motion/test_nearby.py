"""Pairs by blocks: every pair that is near is found, in the order of all pairs, with its own margin and owners."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tamplang.runtime.planner.motion.collision.broad_phase import NO_PAIRS, Blocks, OwnerMargins, Pairs
from tamplang.runtime.skeleton import Array

NEAR = 0.3


def _runs(counts: list[int], owner: int) -> tuple[Array, int]:
    begins = np.cumsum([0, *counts])
    owners = [owner + k % 2 for k in range(len(counts))]
    return np.array(list(zip(begins, counts, owners, strict=False)), dtype=np.int64), int(begins[-1])


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.integers(1, 4), min_size=1, max_size=4), st.lists(st.integers(1, 4), min_size=1, max_size=4),
    st.integers(0, 10**6),
)  # fmt: skip
def test_all_pairs_that_are_near_are_found_in_order(mine: list[int], others: list[int], seed: int) -> None:
    random = np.random.default_rng(seed)
    (a, count), (b, other_count) = _runs(mine, 0), _runs(others, 2)
    points, other_points = random.uniform(-1, 1, (count, 3)), random.uniform(-1, 1, (other_count, 3))
    margins = np.full((4, 4), 0.05)
    margins[0, 2], margins[1, 3] = -np.inf, 0.2
    least = random.uniform(0.0, 0.05, (4, 4))
    blocks = Blocks()
    special = {(i, j): (margins[i, j], least[i, j]) for i in range(len(margins)) for j in range(len(margins))}
    blocks.grid(7, a, b, OwnerMargins(0.0, special))
    found = blocks.near((points, points), (other_points, other_points), NEAR)

    owner, other_owner = np.repeat(a[:, 2], a[:, 1]), np.repeat(b[:, 2], b[:, 1])
    wanted = [
        (i, k, margins[owner[i], other_owner[k]], [7, owner[i], other_owner[k]])
        for i, k in itertools.product(range(count), range(other_count))
    ]
    must = [w for w in wanted if np.linalg.norm(points[w[0]] - other_points[w[1]]) < NEAR + w[2]]
    told = [(int(i), int(k)) for i, k in zip(found.first, found.second, strict=True)]
    assert {(i, k) for i, k, *_ in must} <= set(told)
    assert told == sorted(told)
    by_pair = {(i, k): (margin, tag) for i, k, margin, tag in wanted if np.isfinite(margin)}
    for pair, margin, tag in zip(told, found.wanted, found.tags, strict=True):
        assert by_pair[pair][0] == margin
        assert by_pair[pair][1] == list(tag)
    assert found.least.tolist() == [least[one, other] for _, one, other in found.tags.tolist()]


def test_what_is_far_is_left_out_and_what_took_part_stays() -> None:
    runs = np.array([(0, 2, 0), (2, 1, 1)])
    blocks = Blocks()
    blocks.pairs(0, np.array([(0, 1, 0)]), np.array([(1, 1, 0)]), np.zeros((1, 2)))
    blocks.grid(0, runs, np.array([(3, 1, 1)]), OwnerMargins(0.0, {}))
    close = np.zeros((4, 3))
    far = np.array([[0.0, 0, 0], [9.0, 0, 0], [20.0, 0, 0], [20.1, 0, 0]])
    every = blocks.near((close, close), (close, close), NEAR)
    assert list(zip(every.first.tolist(), every.second.tolist(), strict=True)) == [(0, 1), (0, 3), (1, 3), (2, 3)]
    some = blocks.near((far, far), (far, far), NEAR)
    assert list(zip(some.first.tolist(), some.second.tolist(), strict=True)) == [(2, 3)]
    both, kept = every[np.array([0, 3])].joined(every)
    assert both.places.tolist() == every.places.tolist()
    assert kept.tolist() == [True, False, False, True]
    none: Pairs = NO_PAIRS
    assert not len(none.joined(NO_PAIRS)[0].places)


def test_of_many_things_the_same_pairs_are_found_as_of_few() -> None:
    random = np.random.default_rng(0)
    parts, _ = _runs([2, 3], 0)
    things = np.array([(k, 1, 2 + k) for k in range(600)])
    points = random.uniform(-1, 1, (5, 3))
    others = random.uniform(-4, 4, (600, 3))
    special = {(0, 2): (0.5, 0.1), (2, 0): (0.5, 0.1), (1, 5): (-np.inf, 0.0), (5, 1): (-np.inf, 0.0)}
    wanted = OwnerMargins(0.05, special)
    many, few = Blocks(), Blocks()
    many.grid(3, parts, things, wanted)
    for k in range(0, 600, 150):
        few.grid(3, parts, things[k : k + 150], wanted)
    assert len(many) >= len(few)
    pairs = [blocks.near((points, points), (others, others), 1.0) for blocks in (many, few)]
    told = [{(i, k, w, m, *tag) for i, k, w, m, tag in zip(
        p.first.tolist(), p.second.tolist(), p.wanted.tolist(), p.least.tolist(), p.tags.tolist(), strict=True
    )} for p in pairs]  # fmt: skip
    assert told[0] == told[1] and len(told[0]) > 20
    assert pairs[0].places.tolist() == sorted(pairs[0].places.tolist())
