"""Answers about frozen records, remembered by the record itself: to compare one takes as long as it is large."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

Record = TypeVar("Record")
Answer = TypeVar("Answer")
Arguments = ParamSpec("Arguments")

ANSWERS = 8192
"""Of one record so many answers are kept at most: each phase of a long plan has a mode of its own."""


def remembered(
    most: int,
) -> Callable[[Callable[Concatenate[Record, Arguments], Answer]], Callable[Concatenate[Record, Arguments], Answer]]:
    """Lets a function of a frozen record, and of further hashable arguments by position, answer anew only where the
    very same record was not asked about with equal arguments; the answers on the last `most` records are kept. They are
    shared: nobody may change them."""

    def decorate(
        function: Callable[Concatenate[Record, Arguments], Answer],
    ) -> Callable[Concatenate[Record, Arguments], Answer]:
        known: dict[int, tuple[Record, dict[tuple[Hashable, ...], Answer]]] = {}

        @wraps(function)
        def call(record: Record, /, *arguments: Arguments.args, **keywords: Arguments.kwargs) -> Answer:
            found = known.get(id(record))
            if found is None:
                if len(known) >= most:
                    del known[next(iter(known))]
                found = known[id(record)] = (record, {})
            answers, key = found[1], (*arguments, *keywords.items())
            if key in answers:
                return answers[key]
            answer = function(record, *arguments, **keywords)
            if len(answers) >= ANSWERS:
                del answers[next(iter(answers))]
            answers[key] = answer
            return answer

        return call

    return decorate
