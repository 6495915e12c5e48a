"""What searches learn of strains from what motion refused and accepted."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.compiler.symbolic.strain import Strain
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import Candidate, SkeletonSearch
from tamplang.runtime.planner.search.learned_penalties import LearnedPenalties
from tamplang.runtime.planner.search.settings import SEARCH

from ..loop.test_handover import ARM, SORT

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def begun(weight: float = 1.0) -> tuple[SkeletonSearch, Candidate, LearnedPenalties]:
    """A search for climbing 16 stairs, its first candidate, and a surcharge that knows nothing yet."""
    problem, _ = compile_problem(EXAMPLES / "climb.tamp", None, {"n": "16", "crawlers": "2"}, 0)
    search = SkeletonSearch(problem, Successors(problem), "astar", Budget(30.0))
    candidate = search.next()
    assert candidate is not None
    surcharge = LearnedPenalties(Strain(search.successors))
    surcharge.weight = weight
    return search, candidate, surcharge


def handed_on(surcharge: LearnedPenalties) -> LearnedPenalties:
    following = LearnedPenalties(surcharge.strain)
    following.inherit(surcharge)
    return following


def price(surcharge: LearnedPenalties, strain: float) -> float:
    return float(surcharge.price("stepTogether", strain))


def test_no_strain_that_motion_accepted_is_a_limit_in_later_windows() -> None:
    search, bold, surcharge = begun(weight=8.0)
    search.charge(surcharge)
    tame = search.next()
    assert tame is not None
    own = sum(search.successors.cost(n) for n in tame.numbers)
    assert tame.cost == pytest.approx(own) and tame.lower_bound <= own, "what is charged is no part of the cost"
    hardest = max(surcharge.strain.along(bold.numbers)[1:-1])
    assert max(surcharge.strain.along(tame.numbers)[1:-1]) < 0.8 * hardest
    surcharge.refused(tame.numbers, 1, len(tame.numbers) - 2)
    assert price(surcharge, hardest) > 2.0 * surcharge.weight
    surcharge.accepted(bold.numbers)
    following = handed_on(surcharge)
    assert price(following, hardest) <= following.weight + 1e-9


def test_what_was_refused_weighs_less_only_once_something_was_accepted() -> None:
    _, candidate, surcharge = begun()
    surcharge.refused(candidate.numbers, 0, len(candidate.numbers) - 1)
    assert surcharge.weight == 1.5
    same = handed_on(surcharge)
    assert same.weight == 1.5 and price(same, 0.5) == price(surcharge, 0.5)
    surcharge.accepted(candidate.numbers[:2])
    assert price(handed_on(surcharge), 0.5) < price(surcharge, 0.5)


def test_all_ways_of_doing_an_action_are_dearer_where_it_is_strained() -> None:
    """Also actions whose strain depends on where their robots stand: none is free of charge, however many are met."""
    search, candidate, surcharge = begun()
    search.charge(surcharge)
    successors, charged = search.successors, 0
    state = successors.initial
    for number in candidate.numbers[:6]:
        for _, other in successors.expand(state):
            strain = surcharge.strain.of(state, other)
            assert (surcharge.of(state, other) > 0.0) == (strain > 0.0)
            charged += strain > 0.0 and not surcharge.strain.settled(other)
        state = successors.after(state, number)
    assert charged > 20


def limit(surcharge: LearnedPenalties) -> float:
    """The strain at which an action costs as much more as the weight says."""
    return float(0.5 / (price(surcharge, 0.5) / surcharge.weight) ** (1.0 / SEARCH.penalty_power))


def test_a_limit_is_forgotten_by_a_tenth_once_something_was_accepted() -> None:
    search, _, surcharge = begun(weight=1.0)
    search.charge(surcharge)
    tame = search.next()
    assert tame is not None
    surcharge.refused(tame.numbers, 1, len(tame.numbers) - 1)
    known = limit(surcharge)
    assert known < 0.95
    surcharge.accepted(tame.numbers[:0])
    assert limit(handed_on(surcharge)) == pytest.approx(1.0 - 0.9 * (1.0 - known))


def test_a_single_refused_action_is_forbidden_not_dearer() -> None:
    _, candidate, surcharge = begun(weight=1.0)
    strains = surcharge.strain.along(candidate.numbers)
    hardest = strains.index(max(strains))
    surcharge.refused(candidate.numbers, hardest, hardest)
    assert surcharge.weight == 1.0 and limit(surcharge) == pytest.approx(1.0)


def test_what_is_hardly_strained_is_not_refused_for_that() -> None:
    """Robots that all stand on one floor are as near as can be to all that stands on it."""
    problem, _ = compile_text(ARM + SORT, "sort.tamp", None, {})
    search = SkeletonSearch(problem, Successors(problem), "astar", Budget(30.0))
    candidate = search.next()
    assert candidate is not None
    surcharge = LearnedPenalties(Strain(search.successors))
    assert 0.0 < max(surcharge.strain.along(candidate.numbers)) < 0.1
    surcharge.refused(candidate.numbers, 0, len(candidate.numbers) - 1)
    assert surcharge.weight == 0.0
