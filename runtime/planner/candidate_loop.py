"""The loop over candidates that `solve` and the windows of a horizon share (thesis, algorithm 1): one after the other
goes through the bounds, and what is refused goes back to the search, to the penalties, and to what is told at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count

from ...compiler.ir import Problem
from ...compiler.symbolic.strain import Strain
from ...compiler.symbolic.successors import Successors
from ..budget import Budget, OutOfTime, Status
from ..skeleton import Bound, Skeleton
from .bounds.multi_bound import MultiBound
from .bounds.settings import BOUNDS
from .bounds.verdicts import Judgement
from .conflicts.infeasibility import Refusals
from .search.best_first import Candidate, SkeletonSearch
from .search.candidate_repair import repaired
from .search.learned_penalties import LearnedPenalties
from .search.settings import SEARCH
from .search.skeleton_replay import build_skeleton


class CandidateLoop:
    """One search of a problem, the bounds that judge what it proposes, and what they refused. Refused beginnings of up
    to `remembered` actions are forbidden wherever their robots stand alike, not only at the start."""

    def __init__(
        self, problem: Problem, method: str, budget: Budget, bounds: MultiBound, refusals: Refusals,
        node_limit: int | None = None, remembered: int = 0,
    ) -> None:  # fmt: skip
        self.problem, self.bounds, self.refusals, self.remembered = problem, bounds, refusals, remembered
        with bounds.clock("compile"):
            self.search = SkeletonSearch(problem, Successors(problem), method, budget, node_limit)
            self.strain = Strain(self.search.successors)
            self.penalties = LearnedPenalties(self.strain)
        self._refused: tuple[Candidate, set[int]] | None = None
        """The last candidate that was refused, and the places of the actions that the refusals end with."""
        self._repairs = 0
        self.rounds = 0
        self.paths_refused = False
        """Whether some candidate had switches, but was refused a motion between them."""

    def proposals(
        self, propose: Callable[[], Candidate | None], go_on: Callable[[], bool], most: int | None = None
    ) -> Iterator[Candidate | None]:
        """At most so many candidates, one after the other; None where there is none, after which the loop ends unless
        `go_on` lets the search go on. Raises OutOfTime."""
        for _ in count() if most is None else range(most):
            with self.bounds.clock("search"):
                candidate = propose()
            yield candidate
            if candidate is None and not go_on():
                return

    def next(self) -> Candidate | None:
        """The last candidate with another way for those that were refused, while the others do as before; else the
        next one of the search."""
        refused, self._refused = self._refused, None
        if refused is not None and self._repairs < SEARCH.repairs:
            self._repairs += 1
            found = repaired(self.search, *refused)
            if found is not None:
                return found
        self._repairs = 0
        return self.search.next()

    def readmit(self) -> bool:
        """Where every candidate was refused: those that P_seq refused may come again once, and bounds try harder, with
        other numbers; where some had switches but no motion between them, all may, a few times. Whether that lets the
        search go on."""
        most = BOUNDS.readmissions if self.paths_refused else 1
        if self.search.status != Status.EXHAUSTED or self.rounds >= most:
            return False
        if not self.search.readmit() and not (self.paths_refused and self.search.readmit()):
            return False
        self.rounds += 1
        self.bounds.try_harder()
        return True

    def skeleton(self, candidate: Candidate) -> Skeleton:
        return build_skeleton(self.problem, candidate.actions, self.search.successors)

    def judge(
        self, candidate: Candidate, skeleton: Skeleton, motions: int | None = None, brisk: bool = False
    ) -> Judgement:
        """What the bounds say of a candidate, whose `skeleton` may be its beginning; refusals are learnt from, but for
        `brisk` ones. Raises OutOfTime."""
        strains = self.strain.along(candidate.numbers[: len(skeleton)])
        try:
            judgement = self.bounds.judge(skeleton, strains, motions, brisk)
        except OutOfTime:
            for conflict in self.bounds.cut_short():
                self.refusals.add(replace(skeleton, problem=self.refusals.problem), conflict)
            raise
        blamed = {conflict.last for conflict in judgement.conflicts}
        for conflict in judgement.conflicts:
            if conflict.bound != Bound.EXPECTED:
                self.refusals.add(replace(skeleton, problem=self.refusals.problem), conflict)
            if conflict.obstacles and conflict.bound == Bound.SEQ:
                self.search.forbid_beside(candidate, conflict.last, conflict.obstacles)
                continue
            if conflict.bound != Bound.EXPECTED:
                self.penalties.refused(candidate.numbers, conflict.first, conflict.last)
            paths = conflict.bound not in (Bound.SEQ, Bound.STATICS, Bound.EXPECTED)
            self.paths_refused |= paths
            if conflict.obstacles:
                self.search.no_goods.openings.forbid(candidate.numbers[conflict.last], conflict.obstacles)
            anywhere = not self.rounds and not paths and 0 < conflict.last < self.remembered
            from_start = conflict.from_start and not anywhere
            if from_start and conflict.bound == Bound.SEQ:
                openings = self._forbid_openings(candidate, skeleton, conflict.last)
                blamed |= openings
                if conflict.last in openings:
                    continue
            self.search.forbid_actions(candidate, conflict.first, conflict.last, from_start, 1 if paths else 0)
        if self.penalties.weight and not judgement.accepted:
            self.search.charge(self.penalties)
        self._refused = (candidate, blamed) if blamed else None
        return judgement

    def _forbid_openings(self, candidate: Candidate, skeleton: Skeleton, refused: int) -> set[int]:
        """After an action was refused in what was done from the start: forbid it, if it is refused from there whatever
        others do; after the first action also all others of the candidate that are refused so, before the search has
        tried each of them. Their places. Raises OutOfTime."""
        successors, openings, places = self.search.successors, self.search.no_goods.openings, set[int]()
        possible = {number for _, number in successors.expand(successors.initial)}
        asked = {k for k, n in enumerate(candidate.numbers[: len(skeleton)]) if n in possible and refused in (0, k)}
        leaving = [openings.leaving(number) for number in candidate.numbers]
        for k, movers, alone, conflict in self.bounds.refused_openings(skeleton, asked, leaving):
            openings.forbid(candidate.numbers[k], movers)
            places.add(k)
            if k != refused:
                self.refusals.add(replace(alone, problem=self.refusals.problem), conflict)
        return places
