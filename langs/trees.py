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


def children(record: object) -> list[Any]:
    """The records directly inside a record, in the order of its fields; of a tuple, those that stand in it."""
    found: list[Any] = []
    if isinstance(record, tuple):
        _add_records(record, found)
        return found
    kind: Any = type(record)
    for name in _holding(kind):
        value = getattr(record, name)
        if isinstance(value, tuple):
            if value:
                _add_records(value, found)
        elif value is not None:
            found.append(value)
    return found


def _add_records(items: tuple[Any, ...], found: list[Any]) -> None:
    for item in items:
        if isinstance(item, tuple):
            _add_records(item, found)
        elif hasattr(item, "__dataclass_fields__"):
            found.append(item)


def parts(record: object) -> Iterator[Any]:
    """A record, or the records of a tuple, and all that is inside, each before what it holds."""
    waiting = children(record)[::-1] if isinstance(record, tuple) else [record]
    while waiting:
        item = waiting.pop()
        yield item
        inside = children(item)
        if inside:
            inside.reverse()
            waiting += inside


def mapped(record: Record, change: Callable[[Any], Any]) -> Record:
    """The record with everything directly inside it changed; itself where that changes nothing."""
    whole: Any = record
    kind: Any = type(record)
    changes: dict[str, Any] = {}
    for name in _holding(kind):
        value = getattr(whole, name)
        if isinstance(value, tuple):
            new = _changed(value, change) if value else value
        else:
            new = change(value) if hasattr(value, "__dataclass_fields__") else value
        if new is not value:
            changes[name] = new
    found: Record = _with(whole, changes) if changes else whole
    return found


def _with(whole: Any, changes: dict[str, Any]) -> Any:
    """`dataclasses.replace`, which looks at every field's nature each time, for records that are just their fields."""
    kind: Any = type(whole)
    if hasattr(kind, "__post_init__"):
        return replace(whole, **changes)
    new = object.__new__(kind)
    for name in _names(kind):
        object.__setattr__(new, name, changes[name] if name in changes else getattr(whole, name))
    return new


@cache
def _names(kind: type) -> tuple[str, ...]:
    return tuple(f.name for f in fields(kind))


def _changed(items: tuple[Any, ...], change: Callable[[Any], Any]) -> tuple[Any, ...]:
    new = []
    for item in items:
        if isinstance(item, tuple):
            new.append(_changed(item, change))
        else:
            new.append(change(item) if hasattr(item, "__dataclass_fields__") else item)
    return items if all(map(operator.is_, items, new)) else tuple(new)


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
