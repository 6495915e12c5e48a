"""Programs from Python values: texts with places for values, which are spelled as the language has them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from .langs.diagnostics import UsageError, did_you_mean

_PLACE = re.compile(r"\$(?:(\w+)|\{(\w+)\})")
_WORD = re.compile(r"[A-Za-z_]\w*(?:\[\w+\])*(?:\.\w+(?:\[\w+\])*)*|[-+]?[\d.]+(?:[eE][-+]?\d+)? ?[\w/^]*")
"""A name such as `c[1].A`, or a number with its unit."""


class Text(str):
    """A piece of a program, which goes into another one as it is."""

    __slots__ = ()


def fill(template: str, /, **values: Any) -> Text:
    """The text of a module, a rule, a scene or a whole program, with values in the places `$name` or `${name}`.

    A number is spelled as one, `metres(0.3)` and `degrees(45)` with their unit, a tuple or an array as `(x, y, z)`, and
    a text as a name such as "c[1]", or a number with its unit such as "20 cm". What `fill` made goes in whole, and so
    do lists of that, one below the other. Raises UsageError for a place without a value, a value without a place, and
    what the language has no spelling for.

    >>> stair = "base stair[$i]: box(0.3 m, 1 m, 2 cm) at $at"
    >>> stairs = [fill(stair, i=i, at=(metres(0.35 * i), metres(0), metres(0.2 * i))) for i in (1, 2)]
    >>> print(fill("scene steps() { $stairs }", stairs=stairs))
    scene steps() { base stair[1]: box(0.3 m, 1 m, 2 cm) at (0.35 m, 0 m, 0.2 m)
    base stair[2]: box(0.3 m, 1 m, 2 cm) at (0.7 m, 0 m, 0.4 m) }
    """
    used = set()

    def spelled_at(match: re.Match[str]) -> str:
        name = match[1] or match[2]
        if name not in values:
            raise UsageError(f"the template has a place ${name}, for which there is no value",
                             help=did_you_mean(name, values))  # fmt: skip
        used.add(name)
        return _spelled(name, values[name])

    text = _PLACE.sub(spelled_at, template)
    for name in values:
        if name not in used:
            places = [one or other for one, other in _PLACE.findall(template)]
            raise UsageError(f"the template has no place ${name}", help=did_you_mean(name, places))
    return Text(text)


def metres(value: float) -> Text:
    """A length.

    >>> metres(0.3)
    '0.3 m'
    """
    return Text(f"{_number('a length', value)} m")


def degrees(value: float) -> Text:
    """An angle.

    >>> degrees(45)
    '45 deg'
    """
    return Text(f"{_number('an angle', value)} deg")


def radians(value: float) -> Text:
    """An angle.

    >>> radians(1.5)
    '1.5 rad'
    """
    return Text(f"{_number('an angle', value)} rad")


def _spelled(name: str, value: Any) -> str:
    if isinstance(value, Text):
        return value
    if isinstance(value, str):
        if not _WORD.fullmatch(value):
            raise UsageError(f"${name} is neither a name nor a number with its unit, but {value!r}",
                             help="pieces of a program are made by `fill`")  # fmt: skip
        return value
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Iterable) and not isinstance(value, Mapping):
        items = list(value)
        if isinstance(value, list) and items and all(isinstance(v, Text) for v in items):
            return "\n".join(items)
        return f"({', '.join(_spelled(name, v) for v in items)})" if items or not isinstance(value, list) else ""
    return _number(f"${name}", value)


def _number(what: str, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float) or value - value != 0:
        raise UsageError(f"{what} has no spelling for {value!r}")
    return repr(value)
