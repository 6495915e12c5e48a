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
        self._scenes: list[tuple[Problem, str | None, int]] = []
        """Problems that were asked about, what tells whether they are the same, and the number of the scene."""
        self._count = 0
        self._answers: OrderedDict[Hashable, bytes] = OrderedDict()
        self._bytes = 0
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._answers)

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
        for known, _, number in reversed(self._scenes):
            if known is problem:
                return number
        digest = None
        if self._scenes:
            self._scenes = [(known, told or _digest(known), number) for known, told, number in self._scenes]
            digest = _digest(problem)
        same = (number for _, told, number in self._scenes if told == digest)
        number = next(same, self._count) if digest else self._count
        self._count = max(self._count, number + 1)
        self._scenes = [*self._scenes[-BOUNDS.kept_scenes :], (problem, digest, number)]
        return number


def _digest(problem: Problem) -> str:
    """What tells problems apart whose answers may differ: all but where they come from, and what guides the search."""
    bare = replace(problem, task="", file="", seed=0, heuristic=None, sources=(), files={}, names={})
    return hashlib.sha256(pickle.dumps(bare, protocol=5)).hexdigest()


KEPT = KeptAnswers()
"""Those of this process."""
