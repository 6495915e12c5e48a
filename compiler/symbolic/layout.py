"""How a state is packed into one int: flag bits first, then fixed-width fields of functional predicates, then the
bits of the other facts.

The flags are the facts between small objects (effectors and modules); their bits form the flag word. A functional
predicate of two parameters whose values are many has one field per key: 0 for no value, else the value's number.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...langs.frozen import dataclass
from ..ir import Fact, Predicate, Problem
from .domains import Domains

STATIC, FLAG, FIELD, BIT = "static", "flag", "field", "bit"


@dataclass(frozen=True, slots=True)
class Field:
    """Where the value of `predicate` for one key lies: `(state >> shift) & mask`."""

    predicate: str
    key: str
    shift: int
    mask: int
    values: tuple[str, ...]
    """Value number i + 1 denotes `values[i]`."""
    numbers: dict[str, int]

    def read(self, state: int) -> str | None:
        number = state >> self.shift & self.mask
        return self.values[number - 1] if number else None


class Layout:
    """Bits and fields of one problem. Facts that can never hold have no place."""

    def __init__(self, problem: Problem, domains: Domains) -> None:
        self.problem = problem
        self.small = frozenset(problem.of_type("effector")) | frozenset(problem.of_type("module"))
        self.domains = domains
        self.kinds = {p.name: self._kind(p) for p in problem.predicates.values()}
        self.flags: dict[Fact, int] = {}
        self.bits: dict[Fact, int] = {}
        self.fields: dict[tuple[str, str], Field] = {}
        self._next = 0
        order = {name: i for i, name in enumerate(problem.objects)}
        for predicate in problem.predicates.values():
            if self.kinds[predicate.name] in (FLAG, BIT):
                self._add_flags(predicate, order)
        self.flag_mask = (1 << self._next) - 1
        for predicate in problem.predicates.values():
            if self.kinds[predicate.name] == FIELD:
                self._add_fields(predicate, order)
        for predicate in problem.predicates.values():
            swept = predicate.name in domains.swept or predicate.functional_in is not None
            if self.kinds[predicate.name] == BIT and swept:
                self._add_bits(predicate, order)
        self.static = frozenset(f for f in problem.init if self.kinds[f[0]] == STATIC)
        self.initial = 0
        for fact in sorted(problem.init - self.static):
            self.initial |= self.encode(fact)[1]

    def _kind(self, predicate: Predicate) -> str:
        if predicate.name not in self.domains.changed:
            return STATIC
        small = [self.domains.at(predicate.name, k) <= self.small for k in range(len(predicate.variables))]
        if all(small):
            return FLAG
        field = predicate.functional_in is not None and len(small) == 2 and not predicate.symmetric
        return FIELD if field else BIT

    def _add_flags(self, predicate: Predicate, order: dict[str, int]) -> None:
        """Bits for facts between small objects, in the order of the objects."""
        for fact in self._product(predicate, order, self.small):
            if self.canonical(fact) not in self.flags:
                self.flags[self.canonical(fact)] = 1 << self._take(1)

    def _add_bits(self, predicate: Predicate, order: dict[str, int]) -> None:
        """Bits for all facts that an effect may delete without naming them."""
        for fact in self._product(predicate, order, frozenset(order)):
            fact = self.canonical(fact)
            if fact not in self.flags and fact not in self.bits:
                self.bits[fact] = 1 << self._take(1)

    def _product(self, predicate: Predicate, order: dict[str, int], among: frozenset[str]) -> list[Fact]:
        facts: list[Fact] = [(predicate.name,)]
        for k in range(len(predicate.variables)):
            names = sorted(self.domains.at(predicate.name, k) & among, key=order.__getitem__)
            facts = [(*f, n) for f in facts for n in names]
        return facts

    def _add_fields(self, predicate: Predicate, order: dict[str, int]) -> None:
        key_at = predicate.functional_in or 0
        values = tuple(sorted(self.domains.at(predicate.name, 1 - key_at), key=order.__getitem__))
        numbers = {v: i + 1 for i, v in enumerate(values)}
        width = len(values).bit_length()
        for key in sorted(self.domains.at(predicate.name, key_at), key=order.__getitem__):
            mask = (1 << width) - 1
            self.fields[predicate.name, key] = Field(predicate.name, key, self._take(width), mask, values, numbers)

    def _take(self, width: int) -> int:
        self._next += width
        return self._next - width

    def canonical(self, fact: Fact) -> Fact:
        """One of the two orders of a symmetric fact."""
        if self.problem.predicates[fact[0]].symmetric and fact[1] > fact[2]:
            return (fact[0], fact[2], fact[1])
        return fact

    def field_of(self, fact: Fact) -> tuple[Field, str] | None:
        """The field that holds this functional fact, and its value there; None without place."""
        key_at = 1 + (self.problem.predicates[fact[0]].functional_in or 0)
        found = self.fields.get((fact[0], fact[key_at]))
        return None if found is None else (found, fact[3 - key_at])

    def encode(self, fact: Fact) -> tuple[int, int]:
        """Mask and value: the fact holds in `state` iff `state & mask == value`. A fact that can never hold: (0, 1)."""
        if self.kinds[fact[0]] == FIELD:
            found = self.field_of(fact)
            if found is None or found[1] not in found[0].numbers:
                return 0, 1
            place, value = found
            return place.mask << place.shift, place.numbers[value] << place.shift
        fact = self.canonical(fact)
        bit = self.flags.get(fact) or self.bits.get(fact) or self._loose(fact)
        return (bit, bit) if bit else (0, 1)

    def _loose(self, fact: Fact) -> int:
        """Facts of other objects get their bit when they are first met."""
        if all(self.domains.at(fact[0], k) >= {name} for k, name in enumerate(fact[1:])):
            if all(name in self.small for name in fact[1:]):
                return 0
            self.bits[fact] = 1 << self._take(1)
            return self.bits[fact]
        return 0

    def others(self, fact: Fact) -> int:
        """Bits of the facts that a functional predicate cannot hold together with `fact`."""
        predicate = self.problem.predicates[fact[0]]
        if predicate.functional_in is None or self.kinds[fact[0]] == FIELD:
            return 0
        return _union(self.encode(rival)[0] for rival in self.rivals(fact))

    def rivals(self, fact: Fact) -> list[Fact]:
        """The facts with a bit that a functional predicate cannot hold together with `fact`."""
        predicate, fact = self.problem.predicates[fact[0]], self.canonical(fact)
        keys = self._keys(predicate, fact)
        found = [f for f, _ in self._all_bits() if f[0] == fact[0]]
        return [f for f in found if f != fact and keys & self._keys(predicate, f)]

    def _keys(self, predicate: Predicate, fact: Fact) -> set[str]:
        """What a functional fact gives a value: both, where its order makes no difference."""
        return set(fact[1:]) if predicate.symmetric else {fact[1 + (predicate.functional_in or 0)]}

    def _all_bits(self) -> list[tuple[Fact, int]]:
        return [*self.flags.items(), *self.bits.items()]

    def matching_bits(self, predicate: str, args: tuple[str | None, ...]) -> int:
        """Bits of all facts of a predicate that agree with `args`, where None agrees with everything."""
        symmetric = self.problem.predicates[predicate].symmetric
        orders = (args, args[::-1]) if symmetric else (args,)
        return _union(
            bit
            for fact, bit in self._all_bits()
            if fact[0] == predicate
            and any(all(a is None or a == b for a, b in zip(order, fact[1:], strict=True)) for order in orders)
        )

    def about(self, state: int, names: frozenset[str]) -> tuple[int, int]:
        """Mask and value of all that a state says of some objects: true and false facts, and values of fields."""
        mask = _union(bit for fact, bit in self._all_bits() if not names.isdisjoint(fact[1:]))
        for place in self.fields.values():
            if place.key in names or place.read(state) in names:
                mask |= place.mask << place.shift
        return mask, state & mask

    def true_flags(self, word: int) -> frozenset[Fact]:
        """The flags that hold in a flag word; symmetric ones in both orders."""
        return self._both_orders(f for f, bit in self.flags.items() if word & bit)

    def facts(self, state: int) -> frozenset[Fact]:
        """All logic facts that hold in a state, static ones included, symmetric ones in both orders."""
        held = [f for f, bit in self._all_bits() if state & bit]
        for place in self.fields.values():
            value = place.read(state)
            if value is not None:
                key_at = self.problem.predicates[place.predicate].functional_in or 0
                pair = (place.key, value) if key_at == 0 else (value, place.key)
                held.append((place.predicate, *pair))
        return self.static | self._both_orders(held)

    def _both_orders(self, facts: Iterable[Fact]) -> frozenset[Fact]:
        found = set(facts)
        found |= {(f[0], f[2], f[1]) for f in found if self.problem.predicates[f[0]].symmetric}
        return frozenset(found)


def _union(bits: Iterable[int]) -> int:
    total = 0
    for bit in bits:
        total |= bit
    return total
