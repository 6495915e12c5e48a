"""Questions that are probably asked next, answered ahead in other processes.

The loop that asks stays the same, in the same order; an answer depends on the question alone, so that it does not
matter where, when or whether it was computed ahead. What was computed for nothing is dropped.

    ahead.expect(skeleton, question, budget)     # perhaps later
    ahead.answer(skeleton, question, budget)     # now: from another process if it has it, else computed here
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Hashable, Iterator
from concurrent.futures import Future, wait
from contextlib import contextmanager
from typing import Any

from ....compiler.ir import Fact, Problem
from ....langs.frozen import dataclass
from ...budget import Budget
from ...parallel import ClusterUnavailable, Side, WorkerLost, WorkFailed, open_executor
from ...skeleton import Phase, Skeleton
from .kept_answers import KEPT, KeptAnswers
from .requests import Answer, Question, WindowRequest
from .settings import BOUNDS


@dataclass(frozen=True, slots=True)
class _Work:
    """A question about a skeleton that is under way, or answered."""

    skeleton: Skeleton
    question: Question[Any]
    future: Future[Any]


class Speculation:
    """Answers to questions, computed ahead by `side` where there is one, or `kept` from earlier. It never changes an
    answer."""

    def __init__(self, side: Side | None = None, kept: KeptAnswers | None = None) -> None:
        self._side, self._kept = side, KeptAnswers() if kept is None else kept
        self._prepared: list[Future[None]] = []
        self._under_way: dict[Hashable, _Work] = {}
        self._problem: Problem | None = None
        self._packed = _Packed(b"", "")

    @property
    def helps(self) -> bool:
        """Whether it is of use to expect anything."""
        return self._side is not None

    def prepare(self, problem: Problem) -> None:
        """Let the other processes start, and load what the questions about this problem need."""
        if self._side is not None:
            packed = self._pack(problem)
            self._prepared = [self._side.submit(_prepare, packed) for _ in range(self._side.width)]

    def expect(self, skeleton: Skeleton, question: Question[Any], budget: Budget) -> bool:
        """Have the question answered by another process, if there is room; whether there was."""
        if self._side is None:
            return False
        key = _key(skeleton, question)
        if key in self._under_way or self._kept.holds(skeleton, question):
            return True
        ready = sum(future.done() for future in self._prepared)
        if sum(not work.future.done() for work in self._under_way.values()) >= BOUNDS.queued * ready:
            return False
        seconds = None if budget.seconds is None else budget.remaining
        try:
            packed = self._pack(skeleton.problem)
            bare = _Bare(skeleton.phases, skeleton.final_mode, skeleton.coming)
            future = self._side.submit(_answer, packed, bare, question, seconds)
        except ClusterUnavailable:
            self._side = None
            return False
        self._under_way[key] = _Work(skeleton, question, future)
        return True

    def expects(self, skeleton: Skeleton, question: Question[Any]) -> bool:
        """Whether the question is answered, or being answered, by another process."""
        work = self._under_way.get(_key(skeleton, question)) if self._under_way else None
        return work is not None and (work.future.done() or work.future.running())

    def answer(self, skeleton: Skeleton, question: Question[Answer], budget: Budget) -> Answer:
        """The answer. Work that was lost with its process, or failed, is done here. Raises OutOfTime."""
        found = self._kept.answer(skeleton, question)
        if found is None:
            found = self._answer(skeleton, question, budget)
            self._kept.keep(skeleton, question, found)
        return found

    def _answer(self, skeleton: Skeleton, question: Question[Answer], budget: Budget) -> Answer:
        work = self._under_way.pop(_key(skeleton, question), None) if self._under_way else None
        if work is None or work.future.cancel():
            return question.solved(skeleton, budget)
        while not work.future.done():
            budget.check()
            if not self._take_over(budget):
                wait([work.future], BOUNDS.answer_period)
        try:
            found: Answer = work.future.result()
        except (WorkerLost, WorkFailed, ClusterUnavailable):
            return question.solved(skeleton, budget)
        return found

    def _take_over(self, budget: Budget) -> bool:
        """Instead of waiting, answer here a window that was not begun: it is asked in any case. Whether there was."""
        for key, work in self._under_way.items():
            if isinstance(work.question, WindowRequest) and not work.future.done() and work.future.cancel():
                done: Future[Any] = Future()
                done.set_result(work.question.solved(work.skeleton, budget))
                self._under_way[key] = _Work(work.skeleton, work.question, done)
                return True
        return False

    def forget(self) -> None:
        """Drop what was expected and not begun."""
        self._under_way = {k: w for k, w in self._under_way.items() if w.future.done() or not w.future.cancel()}

    def _pack(self, problem: Problem) -> _Packed:
        if problem is not self._problem:
            content = pickle.dumps(problem)
            self._problem, self._packed = problem, _Packed(content, hashlib.sha256(content).hexdigest())
        return self._packed


def _key(skeleton: Skeleton, question: Question[Any]) -> Hashable:
    return skeleton.phases, skeleton.final_mode, skeleton.coming, question.key


@contextmanager
def opened(jobs: int = 1, cluster: str | None = None) -> Iterator[Speculation]:
    """Answers from `jobs` processes, this one included, or from this one and the workers of a cluster, or those that
    this process has kept. What is under way at the end is dropped at once. Raises ClusterUnavailable."""
    if cluster is None and jobs == 1:
        yield Speculation(kept=KEPT)
        return
    from ...parallel.processes import Processes

    side = Processes(jobs - 1) if cluster is None else open_executor(cluster=cluster)
    try:
        yield Speculation(side, KEPT)
    finally:
        side.kill()
        side.shutdown(wait=True, cancel_futures=True)


# --- in the other process ----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Packed:
    """A pickled problem and its hash."""

    content: bytes
    digest: str


@dataclass(frozen=True, slots=True)
class _Bare:
    """A skeleton without its problem."""

    phases: tuple[Phase, ...]
    final_mode: frozenset[Fact]
    coming: tuple[tuple[str, str], ...]


_problems: dict[str, Problem] = {}


def _problem(packed: _Packed) -> Problem:
    """The problem, unpacked once: what is built for it is found again by the object."""
    if packed.digest not in _problems:
        _problems.clear()
        _problems[packed.digest] = pickle.loads(packed.content)
    return _problems[packed.digest]


def _prepare(packed: _Packed) -> None:
    _problem(packed)


def _answer(packed: _Packed, bare: _Bare, question: Question[Answer], seconds: float | None) -> Answer:
    skeleton = Skeleton(_problem(packed), bare.phases, bare.final_mode, bare.coming)
    return question.solved(skeleton, Budget(seconds))
