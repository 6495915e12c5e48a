"""Scopes: what a name stands for at one place of the text."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field

from ...langs import syntax
from ...langs.frozen import dataclass
from ...langs.source import Span
from ...langs.trees import parts
from .. import ir
from .kinds import UNKNOWN, Kind


@dataclass(frozen=True, slots=True)
class Typed:
    """A lowered term with its kind. `literal` marks plain numbers that pass for lengths: those that stand in the
    text without a unit, and inner products, as vectors do not say whether they are places or directions. `items` are
    the components of what is written as a vector."""

    term: ir.Term
    kind: Kind
    literal: bool = False
    items: tuple[Typed, ...] = ()

    @property
    def is_zero(self) -> bool:
        return self.literal and isinstance(self.term, ir.Number) and self.term.value == 0

    @property
    def value(self) -> float | None:
        return self.term.value if isinstance(self.term, ir.Number) else None


BROKEN = Typed(ir.Number(0), UNKNOWN)


@dataclass(frozen=True, slots=True)
class Entry:
    """A variable, parameter or loop counter: what it lowers to and where it is declared."""

    typed: Typed
    span: Span | None


@dataclass(frozen=True, slots=True)
class Family:
    """The things of a scene that share a base name, such as `plate[1]`, `plate[2]`: type and number of indices."""

    type: str
    indices: int
    span: Span


@dataclass(slots=True)
class Objects:
    """The things that a scene or module declares. `ground` maps their full names to types once the scene is built;
    before that it is None and any index is believed. `ends` maps a module type to its effectors and their types.
    `incomplete` where a scene is used that nothing declares, so that anything could be its name."""

    families: dict[str, Family] = field(default_factory=dict)
    ground: dict[str, str] | None = None
    ends: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    incomplete: bool = False


@dataclass(frozen=True, slots=True)
class Scope:
    """Names in sight. `place` is "rule", "motion", "scene", "goal" or "heuristic" and decides which functions and
    constructs may stand here; `values_known` says that parameters have values, so that loops can be unrolled."""

    place: str
    entries: Mapping[str, Entry] = field(default_factory=dict)
    objects: Objects = field(default_factory=Objects)
    values_known: bool = False
    wildcard: bool = False
    used: frozenset[str] = frozenset()

    def with_entries(self, entries: Iterable[tuple[str, Entry]]) -> Scope:
        merged = {**self.entries, **dict(entries)}
        used = self.used | {t.name for e in merged.values() if isinstance(t := e.typed.term, ir.Var)}
        return Scope(self.place, merged, self.objects, self.values_known, self.wildcard, frozenset(used))

    def with_wildcard(self) -> Scope:
        return Scope(self.place, self.entries, self.objects, self.values_known, True, self.used)

    def fresh(self, name: str) -> str:
        """A name for a bound variable of the IR that captures none in sight."""
        while name in self.used:
            name += "'"
        return name

    def names(self) -> Iterator[str]:
        yield from self.entries
        yield from self.objects.families


def names_in(part: object) -> set[str]:
    """The names that a part of the syntax tree speaks of."""
    return {node.name for node in parts(part) if isinstance(node, syntax.Name)}
