"""Frozen records as trees: what a record holds is read from its annotations, once per class.

A pass over the syntax tree or the IR says what it does with some of the records; `parts` and `mapped` know the way
through all others. Places in the text (`Span`) are no parts.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from inspect import get_annotations
from types import UnionType
from typing import Any, TypeVar, Union, get_args, get_origin

from .source import Span

Record = TypeVar("Record")


def children(record: object) -> Iterator[Any]:
    """The records directly inside a record, in the order of its fields; of a tuple, those that stand in it."""
    if isinstance(record, tuple):
        for item in record:
            if isinstance(item, tuple):
                yield from children(item)
            elif hasattr(item, "__dataclass_fields__"):
                yield item
        return
    kind: Any = type(record)
    for name in _holding(kind):
        value = getattr(record, name)
        if isinstance(value, tuple):
            yield from children(value)
        elif value is not None:
            yield value


def parts(record: object) -> Iterator[Any]:
    """A record, or the records of a tuple, and all that is inside, each before what it holds."""
    waiting = [*children(record)][::-1] if isinstance(record, tuple) else [record]
    while waiting:
        item = waiting.pop()
        yield item
        waiting += [*children(item)][::-1]


def mapped(record: Record, change: Callable[[Any], Any]) -> Record:
    """The record with everything directly inside it changed; itself where that changes nothing."""
    whole: Any = record
    kind: Any = type(record)
    changes: dict[str, Any] = {}
    for name in _holding(kind):
        value = getattr(whole, name)
        new = _changed(value, change)
        if new is not value:
            changes[name] = new
    found: Record = replace(whole, **changes) if changes else whole
    return found


def _changed(value: Any, change: Callable[[Any], Any]) -> Any:
    if isinstance(value, tuple):
        new = tuple([_changed(item, change) for item in value])
        return value if all(map(operator.is_, value, new)) else new
    return change(value) if hasattr(value, "__dataclass_fields__") else value


@cache
def _holding(kind: type) -> tuple[str, ...]:
    """The fields of a class that may hold records."""
    if not is_dataclass(kind):
        return ()
    homes = {name: base.__module__ for base in kind.__mro__[::-1] for name in get_annotations(base)}
    return tuple(f.name for f in fields(kind) if _may_hold(homes[f.name], str(f.type)))


@cache
def _may_hold(module: str, annotation: str) -> bool:
    """Few texts annotate all fields: each is read once, which `typing.get_type_hints` would do for every field."""
    return _has_records(eval(annotation, vars(sys.modules[module])))


def _has_records(hint: Any) -> bool:
    if get_origin(hint) in (tuple, Union, UnionType):
        return any(map(_has_records, get_args(hint)))
    return is_dataclass(hint) and hint is not Span
