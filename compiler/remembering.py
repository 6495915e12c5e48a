"""Answers about frozen records, remembered by the record itself: to compare one takes as long as it is large."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

Record = TypeVar("Record")
Answer = TypeVar("Answer")
Arguments = ParamSpec("Arguments")


def remembered(
    most: int,
) -> Callable[[Callable[Concatenate[Record, Arguments], Answer]], Callable[Concatenate[Record, Arguments], Answer]]:
    """Lets a function of a frozen record, and of further hashable arguments by position, answer anew only where the
    very same record was not asked about with equal arguments; the last `most` answers are kept. They are shared:
    nobody may change them."""

    def decorate(
        function: Callable[Concatenate[Record, Arguments], Answer],
    ) -> Callable[Concatenate[Record, Arguments], Answer]:
        known: dict[tuple[Hashable, ...], tuple[Record, Answer]] = {}

        @wraps(function)
        def call(record: Record, /, *arguments: Arguments.args, **keywords: Arguments.kwargs) -> Answer:
            key = (id(record), *arguments, *keywords.items())
            found = known.get(key)
            if found is None:
                if len(known) >= most:
                    del known[next(iter(known))]
                found = known[key] = (record, function(record, *arguments, **keywords))
            return found[1]

        return call

    return decorate
