"""Answers that this process has found before: solving the same task again, as notebooks, editors and `--watch` do, asks
the same questions about the same scene.

An answer depends on nothing but the question, its skeleton and what the scene says; so it is the same whether it is
found again or kept. What is kept is bounded, and handed out as a copy.
"""

from __future__ import annotations

import hashlib
import io
import pickle
from collections import OrderedDict
from collections.abc import Hashable
from dataclasses import replace
from itertools import count
from threading import Lock
from typing import Any

from ....compiler.ir import Problem
from ...skeleton import Skeleton, fixed_poses
from .requests import Answer, Question
from .settings import BOUNDS


class _Pickler(pickle.Pickler):
    """Leaves out where bodies are that never move."""

    def __init__(self, problem: Problem, file: io.BytesIO) -> None:
        super().__init__(file, protocol=5)
        self._shared = fixed_poses(problem.world)

    def persistent_id(self, obj: object) -> str | None:
        return "fixed" if obj is self._shared else None


class _Unpickler(pickle.Unpickler):
    """Puts in where they are."""

    def __init__(self, problem: Problem, content: bytes) -> None:
        super().__init__(io.BytesIO(content))
        self._shared = fixed_poses(problem.world)

    def persistent_load(self, pid: object) -> object:
        return self._shared


class KeptAnswers:
    """Pickled answers by scene, skeleton and question; those that were asked for least lately make room."""

    def __init__(self) -> None:
        self._recent: list[tuple[Problem, int]] = []
        """The problems that were asked about last, and the numbers of their scenes."""
        self._scenes: OrderedDict[str, int] = OrderedDict()
        """The numbers of scenes by what tells them apart."""
        self._count = 0
        self._answers: OrderedDict[Hashable, bytes] = OrderedDict()
        self._bytes = 0
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._answers)

    def holds(self, skeleton: Skeleton, question: Question[Any]) -> bool:
        """Whether the answer is kept."""
        with self._lock:
            return self._key(skeleton, question) in self._answers

    def answer(self, skeleton: Skeleton, question: Question[Answer]) -> Answer | None:
        """The answer, where it is kept."""
        with self._lock:
            key = self._key(skeleton, question)
            content = self._answers.get(key)
            if content is None:
                return None
            self._answers.move_to_end(key)
        found: Answer = _Unpickler(skeleton.problem, content).load()
        return found

    def keep(self, skeleton: Skeleton, question: Question[Any], answer: Any) -> None:
        """Keep an answer that is not too large."""
        written = io.BytesIO()
        _Pickler(skeleton.problem, written).dump(answer)
        content = written.getvalue()
        if len(content) > BOUNDS.largest_answer:
            return
        with self._lock:
            key = self._key(skeleton, question)
            self._bytes += len(content) - len(self._answers.pop(key, b""))
            self._answers[key] = content
            while self._bytes > BOUNDS.kept_answers:
                self._bytes -= len(self._answers.popitem(last=False)[1])

    def _key(self, skeleton: Skeleton, question: Question[Any]) -> Hashable:
        return self._scene(skeleton.problem), skeleton.phases, skeleton.final_mode, skeleton.coming, question.key

    def _scene(self, problem: Problem) -> int:
        """The number of the scene of a problem. As long as a process has met one alone, nothing is compared."""
        for known, number in reversed(self._recent):
            if known is problem:
                return number
        if len(self._recent) == 1 and not self._scenes:
            self._scenes[_digest(self._recent[0][0])] = self._recent[0][1]
        digest = _digest(problem) if self._recent else None
        number = self._count if digest is None else self._scenes.setdefault(digest, self._count)
        self._count = max(self._count, number + 1)
        self._recent = [*self._recent[1 - BOUNDS.recent_problems :], (problem, number)]
        while len(self._scenes) > BOUNDS.kept_scenes:
            self._scenes.popitem(last=False)
        return number


_DEEP = count()


def _digest(problem: Problem) -> str:
    """What tells problems apart whose answers may differ: all but where they come from, and what guides the search. Of
    one that is nested too deeply nothing equal is found."""
    bare = replace(problem, task="", file="", seed=0, heuristic=None, sources=(), files={}, names={})
    try:
        return hashlib.sha256(pickle.dumps(bare, protocol=5)).hexdigest()
    except RecursionError:
        return f"nested too deeply, {next(_DEEP)}"


KEPT = KeptAnswers()
"""Those of this process."""
