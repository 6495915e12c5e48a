"""What is asked about skeletons, as values that other processes can answer as well; an answer depends on nothing but
the question and its skeleton."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from ...budget import Budget
from ...seeds import Seed
from ...skeleton import BoundResult, Configuration, Skeleton, beginning, own_poses
from ..motion.keyframes.sequence import solve_sequence, window_feasible
from ..motion.path.whole_path import solve_path
from ..motion.phases import UnsupportedPhase, solve_sequence_path
from ..motion.phases.relief import relieved
from ..motion.settings import MotionSettings
from ..statics import borne

Answer = TypeVar("Answer")


class Question(ABC, Generic[Answer]):
    """Questions with the same key, about the same skeleton, have the same answer."""

    @property
    def key(self) -> Hashable:
        return self

    @abstractmethod
    def solved(self, skeleton: Skeleton, budget: Budget) -> Answer:
        """The answer, computed in this process. Raises OutOfTime."""


@dataclass(frozen=True, eq=False)
class SequenceRequest(Question[BoundResult]):
    """P_seq of a skeleton from the start, with at most `tries` starts of a span; the first of them from the switch
    configurations 1 … K in `warm`, if there are any."""

    settings: MotionSettings
    seed: Seed
    tries: int | None
    warm: Sequence[Configuration] | None = None

    @property
    def key(self) -> Hashable:
        warm = None if self.warm is None else _values(self.warm)
        return SequenceRequest, self.settings, self.seed, self.tries, warm

    def solved(self, skeleton: Skeleton, budget: Budget) -> BoundResult:
        return solve_sequence(skeleton, self.settings, self.seed, budget, warm=self.warm, tries=self.tries)


@dataclass(frozen=True)
class WindowRequest(Question[BoundResult]):
    """P_seq of phases `first` … `last` alone."""

    settings: MotionSettings
    seed: Seed
    first: int
    last: int

    def solved(self, skeleton: Skeleton, budget: Budget) -> BoundResult:
        return window_feasible(skeleton, self.first, self.last, self.settings, self.seed, budget)


@dataclass(frozen=True, eq=False)
class AttemptRequest(Question[tuple[BoundResult, BoundResult | None]]):
    """P_seq from the switch configurations 1 … K in `warm`, with random numbers from `draw`, and where it is feasible
    P_seqPath of the first `motions` phases between those it finds."""

    settings: MotionSettings
    draw: Seed
    tries: int | None
    warm: Sequence[Configuration]
    motions: int
    thorough: bool

    @property
    def key(self) -> Hashable:
        return AttemptRequest, self.settings, self.draw, self.tries, self.motions, self.thorough, _values(self.warm)

    def solved(self, skeleton: Skeleton, budget: Budget) -> tuple[BoundResult, BoundResult | None]:
        sequence = solve_sequence(skeleton, self.settings, self.draw, budget, warm=self.warm, tries=self.tries)
        if not sequence.feasible:
            return sequence, None
        first = beginning(skeleton, self.motions)
        return sequence, sequence_path(first, sequence, self.settings, self.draw, budget, self.thorough)


@dataclass(frozen=True, eq=False)
class PathRequest(Question[BoundResult]):
    """P_seqPath between the switch configurations of `sequence`, with nothing known of its phases."""

    settings: MotionSettings
    seed: Seed
    thorough: bool
    sequence: BoundResult
    sampled_to: float = math.inf

    @property
    def key(self) -> Hashable:
        asked = self.settings, self.seed, self.thorough, self.sampled_to
        return PathRequest, *asked, _values(self.sequence.configurations)

    def solved(self, skeleton: Skeleton, budget: Budget) -> BoundResult:
        return sequence_path(
            skeleton, self.sequence, self.settings, self.seed, budget, self.thorough, sampled_to=self.sampled_to
        )


def _values(configurations: Sequence[Configuration]) -> Hashable:
    """What tells configurations of one scene apart."""
    parts = (part for c in configurations for part in (c.modules, own_poses(c.bodies)))
    return tuple((name, row.tobytes()) for part in parts for name, row in part.items())


def sequence_path(
    skeleton: Skeleton, sequence: BoundResult, settings: MotionSettings, seed: Seed, budget: Budget,
    thorough: bool = True, known: BoundResult | None = None, sampled_to: float = math.inf,
) -> BoundResult:  # fmt: skip
    """P_seqPath of a skeleton, or of its beginning, between the switch configurations of `sequence`; as one program
    where phases cannot be told apart. Unless `thorough`, hard phases fail soon; those of more joints than `sampled_to`
    get no way among samples; what is `known` of phases between the same switches stays. Raises OutOfTime."""
    sequence = replace(sequence, configurations=sequence.configurations[: len(skeleton) + 1])
    try:
        found = solve_sequence_path(
            skeleton, sequence.configurations, settings, seed, budget, thorough, known, sampled_to
        )
    except UnsupportedPhase:
        found = solve_path(skeleton, settings, seed, budget, sequence, pinned=True)
    refused = borne(skeleton, found)
    if refused.feasible or not found.feasible:
        return refused
    return relieved(skeleton, found, refused, settings, seed, budget)
