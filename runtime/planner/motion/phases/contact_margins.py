"""How much of the margin two objects keep in a phase. There are few kinds of pairs, so that kinds are stored, and what
each kind keeps over time is looked up in a table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .....compiler.motion.collision import PhaseContacts, pair, taper
from ....skeleton import Array
from .settings import PHASES

FULL, NEVER, START, END, BOTH, BESIDE, PRESSED = range(7)
"""The whole margin; none, as the two touch all the time; less near the start, near the end, or near both; only not to
overlap, as the two may touch; and by no more than `check` lets pass, as the two overlap at the start."""
REQUIRED = np.array([-PHASES.touching, -np.inf, *[-PHASES.contact_tolerance] * 4, -PHASES.pressed])
"""The clearance, metres, that accepts two things, by their kind."""

Kinds = NDArray[np.int8]


def kind_of(contact: PhaseContacts, one: str, other: str) -> int:
    """The kind of two objects."""
    objects = pair(one, other)
    if objects in contact.during:
        return NEVER
    if objects in contact.pressed:
        return PRESSED
    if objects in contact.beside:
        return BESIDE
    return (FULL, START, END, BOTH)[(objects in contact.start) + 2 * (objects in contact.end)]


def share_table(times: Array, slices: int) -> Array:
    """The share of the margin `(kinds, times)` at times counted in slices from the start of the phase; -inf: none."""
    here: frozenset[tuple[str, str]] = frozenset({("", "")})
    none: frozenset[tuple[str, str]] = frozenset()
    table = np.full((7, len(times)), -np.inf)
    table[[BESIDE, PRESSED]] = 0.0
    for kind, start, end in ((FULL, none, none), (START, here, none), (END, none, here), (BOTH, here, here)):
        share = taper(PhaseContacts(none, start, end), ("", ""), times, slices)
        table[kind] = -np.inf if share is None else share
    return table


def cross_kinds(contact: PhaseContacts, first: Sequence[str | None], second: Sequence[str | None]) -> Kinds:
    """The kinds `(first, second)` of objects; None is no object that contacts name."""
    names = {t for t in (*first, *second) if t is not None}
    number: dict[str | None, int] = {name: k for k, name in enumerate(sorted(names))}
    number[None] = len(names)
    table = np.full((len(names) + 1, len(names) + 1), FULL, np.int8)
    for a, b in contact.during | contact.start | contact.end | contact.beside:
        if a in names and b in names:
            table[number[a], number[b]] = table[number[b], number[a]] = kind_of(contact, a, b)
    rows, columns = ([number[t] for t in tags] for tags in (first, second))
    return np.asarray(table[np.ix_(rows, columns)])
