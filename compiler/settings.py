"""Numbers that steer a search or a solver, as fields of one frozen record for each room (`settings.py` there).

A field says its unit, what it does, and how its value was found.
"""

from __future__ import annotations

from dataclasses import field, fields
from typing import Any, TypeVar

Value = TypeVar("Value")
NOT_MEASURED = "not measured"


def setting(value: Value, unit: str, what: str, reason: str = NOT_MEASURED) -> Value:
    """A field of a settings record. `unit` is "1" where the number has none; `reason` tells why it is this number."""
    found: Value = field(default=value, metadata={"unit": unit, "what": what, "reason": reason})
    return found


def override(record: Any, **values: Any) -> None:
    """Change settings for the rest of the process, as benchmarks do. Raises AttributeError where there is no such
    field."""
    known = {f.name for f in fields(record)}
    for name, value in values.items():
        if name not in known:
            raise AttributeError(f"{type(record).__name__} has no setting {name}")
        object.__setattr__(record, name, value)
