"""What one action does to a packed state, where it depends on more of the state than the values of a few fields."""

from __future__ import annotations

from ...langs.frozen import dataclass
from .expressions import Check, Test

Addition = tuple[int, int, int]
"""Mask and value: what of the mask holds before must be nothing or just the value, else a functional predicate would
have two values; then the bits to set."""


@dataclass(frozen=True, slots=True)
class Step:
    """One action of a general row: tests on the state, fields to empty where they hold a value, bits to keep, then what
    is added; conditional deletions and additions with their conditions."""

    tests: tuple[Test, ...]
    check: Check | None
    drops: tuple[tuple[int, int], ...]
    keep: int
    guards: tuple[Addition, ...]
    set: int
    dropped: tuple[tuple[Check, int], ...]
    added: tuple[tuple[Check, Addition], ...]
    action: int

    def possible(self, s: int) -> bool:
        """Whether the tests hold in a state."""
        holds = all((s & mask == value) is same for mask, value, same in self.tests)
        return holds and (self.check is None or self.check(s))

    def apply(self, s: int, out: list[tuple[int, int]]) -> None:
        """Append the successor of a state in which the tests hold, unless a functional predicate would have two
        values in it."""
        if self.check is not None and not self.check(s):
            return
        t = s & self.keep
        for mask, value in self.drops:
            if s & mask == value:
                t &= ~mask
        for check, keep in self.dropped:
            if check(s):
                t &= keep
        for mask, value, _ in self.guards:
            if t & mask and t & mask != value:
                return
        t |= self.set
        for check, (mask, value, bits) in self.added:
            if check(s):
                if t & mask and t & mask != value:
                    return
                t |= bits
        out.append((t, self.action))
