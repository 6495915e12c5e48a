"""Numbers of things in words."""

from __future__ import annotations


def counted(number: int, noun: str, nouns: str | None = None) -> str:
    """`1 node`, `2 nodes`; `nouns` is the plural where it has no plain `s`."""
    return f"{number} {noun if number == 1 else nouns or f'{noun}s'}"
