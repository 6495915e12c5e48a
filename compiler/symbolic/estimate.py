"""The automatic estimate: never more than the cost of the cheapest plan.

Two parts, both derived from the rules. Landmarks: every unmet conjunct of the goal needs an action that achieves it,
and before it whatever all its achievers need; an action that can serve several landmarks is shared among them. Hops:
before a landmark can be achieved, something must be where an achiever can fire; `locations` bounds the moves until
then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field
from typing import Any

from ...langs.frozen import dataclass
from ..ir import And, Effect, EffectFor, EffectItem, Fact, Literal, Number, Object, Or, Term, Type
from .achievers import Achiever, Achievers
from .domains import FlatRule
from .expressions import Test, literal_test, test_source
from .links import Links
from .locations import EdgeFamily, families
from .prices import Price, Prices
from .settings import SYMBOLIC
from .successors import Successors, has_chains

Tables = tuple[tuple[float, ...], ...]
"""By the most modules that a chain has: the least cost of moves, from nowhere and from every place."""


@dataclass(frozen=True, slots=True)
class Located:
    """Tables of moves of one family, for states in which some of the tests holds, or none does; for all without tests.
    The moves end where some achiever may fire."""

    family: int
    tables: Tables
    tests: tuple[Test, ...]
    some: bool
    achievers: tuple[Achiever, ...]


@dataclass(slots=True)
class Landmark:
    """Some fact of `facts` must come to hold, if none does, once a parent is needed (a goal always is)."""

    facts: tuple[Fact, ...]
    tests: tuple[Test, ...]
    parents: list[int] = field(default_factory=list)
    goal: bool = False
    weight: float = 0.0
    tables: list[Located] = field(default_factory=list)


class Estimate:
    """A lower bound on the cost from a state to the goal; infinite where the goal is out of reach. What an action of a
    rule costs at least is read from the rules, or told by `costs`."""

    def __init__(self, successors: Successors, costs: Mapping[str, float] | None = None) -> None:
        self.successors = successors
        self.layout = successors.layout
        self.costs = costs or {f.rule.name: self._least_cost(f) for f in self.layout.domains.rules}
        self.landmarks: list[Landmark] = []
        self._known: dict[frozenset[Fact], int] = {}
        self.achievers = Achievers(successors)
        for facts in self._goals():
            self._add(facts, None, 0)
        served: dict[str, int] = {}
        for flat in self.layout.domains.rules:
            served[flat.rule.name] = max(self._served(flat), served.get(flat.rule.name, 0))
        self.families = families(successors.guards, self.costs)
        self.links = Links(successors.guards, self.costs)
        moving = {rule for family in self.families for rule in family.rules}
        self.counts_links = self.links.counted and not moving & self.links.rules
        for landmark in self.landmarks:
            rules = {a.flat.rule.name for a in self.achievers.first(landmark.facts)}
            landmark.weight = min((self.costs[r] / max(served[r], 1) for r in rules), default=math.inf)
            self._locate(landmark)
        counted = {rule for mark in self.landmarks for t in mark.tables for rule in self.families[t.family].rules}
        counted |= self.links.rules if self.counts_links else set()
        self.separate = not any(served[rule] for rule in counted)
        self.prices = [Prices(family) for family in self.families]
        self.text = self.source()
        self.value = self._compiled(self.text)

    def priced(self, price: Price) -> Callable[[int], float]:
        """The estimate once actions cost more by how strained they are."""
        return self._compiled(self.source(price))

    def _compiled(self, text: str) -> Callable[[int], float]:
        names: dict[str, Any] = {"inf": math.inf, "stages": self.links.stages, "ALL": ((0, 0.0),)}
        names |= {f"table_{i}": table for i, table in enumerate(self._tables)}
        names |= {f"holders_{i}": holders for i, holders in enumerate(self._holders)}
        exec(compile(text, "<estimate>", "exec"), names)
        value: Callable[[int], float] = names["value"]
        return value

    # --- landmarks -----------------------------------------------------------------------------------------------

    def _goals(self) -> Iterator[tuple[Fact, ...]]:
        """The conjuncts of the goal that are facts, or alternatives of facts."""
        goal = self.successors.normal.normal(self.successors.problem.goal, {}, False)
        parts = goal.operands if isinstance(goal, And) else (goal,)
        for part in parts:
            if has_chains(part):
                continue
            settled = self.successors.guards.reduce(part, {}, None)
            for conjunct in settled.operands if isinstance(settled, And) else (settled,):
                alternatives = conjunct.operands if isinstance(conjunct, Or) else (conjunct,)
                if all(isinstance(a, Literal) and _is_ground(a) for a in alternatives):
                    yield tuple(_fact(a) for a in alternatives if isinstance(a, Literal))

    def _add(self, facts: tuple[Fact, ...], parent: int | None, depth: int) -> None:
        known = self._known.setdefault(frozenset(facts), len(self.landmarks))
        if known < len(self.landmarks):
            if parent is None:
                self.landmarks[known].goal = True
            elif parent != known and parent not in self.landmarks[known].parents and known > parent:
                self.landmarks[known].parents.append(parent)
            return
        tests = tuple(literal_test(self.layout, _literal(f)) for f in facts)
        self.landmarks.append(Landmark(facts, tests, [] if parent is None else [parent], parent is None))
        if depth < SYMBOLIC.estimate_depth:
            for needed in self._needed(facts):
                self._add(needed, known, depth + 1)

    def _needed(self, facts: tuple[Fact, ...]) -> Iterator[tuple[Fact, ...]]:
        """Sets of facts, none true at the start, one of which every achiever of a landmark needs."""
        achievers = self.achievers.first(facts)
        if not achievers:
            return
        conditions = [[f for f in a.flat.conjuncts if isinstance(f, Literal)] for a in achievers]
        for predicate in dict.fromkeys(f.predicate for f in conditions[0] if self.achievers.fluent(f)):
            union: dict[Fact, None] = {}
            for achiever, literals in zip(achievers, conditions, strict=True):
                options = [self.achievers.instances(f, achiever) for f in literals if f.predicate == predicate]
                smallest = min(options, key=len, default=None)
                if smallest is None:
                    break
                union.update(dict.fromkeys(smallest))
                if len(union) > SYMBOLIC.most_instances:
                    break
            else:
                if union and not any(self._holds(f, self.successors.initial) for f in union):
                    yield tuple(union)

    def _holds(self, fact: Fact, state: int) -> bool:
        mask, value = self.layout.encode(fact)
        return state & mask == value

    def _served(self, flat: FlatRule) -> int:
        """How many landmarks one action of a rule can serve at most."""
        domains = self.layout.domains.variable_domains(flat)
        total = 0
        looped = {id(e) for item in flat.rule.effects for e in _looped(item)}
        for effect, types in flat.additions():
            counts: dict[Fact, int] = {}
            for landmark in self.landmarks:
                for fact in landmark.facts:
                    if fact[0] == effect.literal.predicate and self._may_add(effect.literal, fact, types, domains):
                        key = self.layout.canonical(fact)
                        counts[key] = counts.get(key, 0) + 1
            total += sum(counts.values()) if id(effect) in looped else max(counts.values(), default=0)
        return total

    def _may_add(
        self, literal: Literal, fact: Fact, types: dict[str, Type], domains: dict[str, frozenset[str]]
    ) -> bool:
        orders = [fact[1:]]
        if self.successors.problem.predicates[fact[0]].symmetric:
            orders.append(fact[:0:-1])
        options = [self.layout.domains.term(a, types, domains) for a in literal.args]
        return any(all(n in o for n, o in zip(order, options, strict=True)) for order in orders)

    def _least_cost(self, flat: FlatRule) -> float:
        cost = flat.rule.cost
        return float(cost.value) if isinstance(cost, Number) else 0.0

    # --- hops ----------------------------------------------------------------------------------------------------

    def _locate(self, landmark: Landmark) -> None:
        """For each location family the tables of moves that come before the landmark: one for states in which no
        achiever has to wait for the landmark itself, else a narrower one for those in which some do."""
        achievers = _distinct(self.achievers.first(landmark.facts))
        late = [self.achievers.waiting(a, landmark.facts) if achievers[1:] else [] for a in achievers]
        early = [a for a, waiting in zip(achievers, late, strict=True) if not waiting]
        facts = dict.fromkeys(fact for waiting in late for fact in waiting)
        guards = tuple(literal_test(self.layout, _literal(f)) for f in facts)
        for k, family in enumerate(self.families):
            always = self._tables_of(family, achievers)
            before = self._tables_of(family, early) if early and guards else always
            if before == always:
                options = [Located(k, always, (), True, tuple(achievers))]
            else:
                early_ones = Located(k, before, guards, False, tuple(early))
                options = [early_ones, Located(k, always, guards, True, tuple(achievers))]
            landmark.tables += [option for option in options if _some(option.tables)]

    def _tables_of(self, family: EdgeFamily, achievers: Sequence[Achiever]) -> Tables:
        return self._by_modules(lambda modules: self._table(family, achievers, modules))

    def _priced(self, located: Located, price: Price) -> Tables:
        prices = self.prices[located.family]
        return self._by_modules(lambda modules: prices.table(located.achievers, modules, price))

    def _by_modules(self, table: Callable[[int], tuple[float, ...] | None]) -> Tables:
        """Tables for ever longer chains where links are counted; none where there is no last one."""
        most = self.links.count
        last = table(most)
        if last is None:
            return ()
        if not self.counts_links:
            return (last,)
        return (*(table(m) or last for m in range(1, most)), last)

    def _table(self, family: EdgeFamily, achievers: Sequence[Achiever], modules: int) -> tuple[float, ...] | None:
        """The moves until some achiever may fire while no chain has more than so many modules; None when it may fire
        wherever its robot is."""
        starts = None
        for achiever in achievers:
            places = family.starts(achiever.flat, achiever.env, modules)
            if places is None:
                return None
            starts = places if starts is None else starts | places
        if starts is None:
            return None
        return family.moves(starts, modules)

    # --- code ----------------------------------------------------------------------------------------------------

    def source(self, price: Price | None = None) -> str:
        """The Python text of the estimate."""
        self._tables: list[Tables] = []
        self._holders: list[dict[int, tuple[int, int]]] = []
        counted, lines = self._counted_lines()
        for i, landmark in enumerate(self.landmarks):
            if i in counted:
                continue
            needed = "" if landmark.goal else f"({' or '.join(f'n{p}' for p in landmark.parents)}) and "
            held = " or ".join(f"({test_source(t)})" for t in landmark.tests) or "False"
            lines.append(f"    n{i} = {needed}not ({held})")
            lines.append(f"    if n{i}: total += {_number(landmark.weight)}")
        lines += self._hop_lines(counted, price)
        return "\n".join(["def value(s):", "    total = 0", *lines, "    return total", ""])

    def _counted_lines(self) -> tuple[set[int], list[str]]:
        """Many goals of one fact each are counted at once: fields that differ from the goal's are added up by one
        carry per field. What each of them needs first is counted along, less what is held already."""
        lonely = {
            i: mark
            for i, mark in enumerate(self.landmarks)
            if mark.goal and len(mark.tests) == 1 and mark.tests[0][0] and not mark.parents
        }
        children = {i: [j for j, m in enumerate(self.landmarks) if i in m.parents] for i in lonely}
        groups: dict[tuple[float, tuple[float, ...]], list[int]] = {}
        masks = 0
        for i, mark in lonely.items():
            below = [self.landmarks[j] for j in children[i]]
            alone = all(m.parents == [i] and not m.goal for m in below)
            leaves = not any(j in m.parents for j in children[i] for m in self.landmarks)
            if alone and leaves and len(below) <= 1 and not mark.tests[0][0] & masks and not mark.tables:
                masks |= mark.tests[0][0]
                groups.setdefault((mark.weight, tuple(m.weight for m in below)), []).append(i)
        counted: set[int] = set()
        lines: list[str] = []
        for (weight, below_weights), members in groups.items():
            inner = [j for i in members for j in children[i]]
            if len(members) < 4 or any(self.landmarks[j].tables for j in inner) or math.isinf(weight):
                continue
            counted.update(members, inner)
            lines += self._count(members, weight, below_weights, children)
        return counted, lines

    def _count(
        self, members: list[int], weight: float, below: tuple[float, ...], children: Mapping[int, list[int]]
    ) -> list[str]:
        mask = value = high = 0
        for i in members:
            m, v, _ = self.landmarks[i].tests[0]
            mask, value, high = mask | m, value | v, high | 1 << (m.bit_length() - 1)
        low = mask & ~high
        lines = [
            f"    u = (s ^ {value}) & {mask}",
            f"    u = ((u & {low}) + {low} | u) & {high}",
            f"    total += {_number(weight + sum(below))} * u.bit_count()",
        ]
        if below:
            held: dict[int, dict[int, tuple[int, int]]] = {}
            for i in members:
                for m, v, _ in self.landmarks[children[i][0]].tests:
                    held.setdefault(m, {})[v] = self.landmarks[i].tests[0][:2]
            for m, holders in held.items():
                name = f"holders_{len(self._holders)}"
                self._holders.append(holders)
                lines.append(f"    t = {name}.get(s & {m})")
                lines.append(f"    if t is not None and s & t[0] != t[1]: total -= {_number(below[0])}")
        return lines

    def _hop_lines(self, counted: set[int], price: Price | None) -> list[str]:
        """The moves that are needed, for each number of links that may be made before: the cheapest of all."""
        groups: dict[tuple[int, Tables], list[str]] = {}
        for i, landmark in enumerate(self.landmarks):
            for at in landmark.tables if i not in counted else ():
                held = " or ".join(f"({test_source(t)})" for t in at.tests)
                when = "" if not at.tests else f" and ({held})" if at.some else f" and not ({held})"
                tables = at.tables if price is None else self._priced(at, price)
                groups.setdefault((at.family, tables), []).append(f"n{i}{when}")
        if not groups:
            return []
        stages = f"stages(s & {self.links.mask})" if self.counts_links else "ALL"
        lines = ["    hops = inf", f"    for q, c in {stages}:", "        v = 0"]
        for (k, tables), members in groups.items():
            name = f"table_{len(self._tables)}"
            self._tables.append(((), *tables) if self.counts_links else tables)
            reads = [f"t[s >> {f.shift} & {f.mask}]" for f in self.families[k].fields]
            lines.append(f"        if {' or '.join(members)}:")
            lines.append(f"            t = {name}[q]")
            lines.append(f"            m = {f'min({chr(44).join(reads)})' if len(reads) > 1 else reads[0]}")
            lines.append("            if m > v: v = m")
        lines += ["        if c + v < hops: hops = c + v", "        if not v: break"]
        lines.append("    total += hops" if self.separate else "    if hops > total: total = hops")
        return lines


def _looped(item: EffectItem, inside: bool = False) -> Iterator[Effect]:
    """The effects that an action may have for several values of a variable, also below conditions."""
    if not isinstance(item, Effect):
        for inner in item.effects:
            yield from _looped(inner, inside or isinstance(item, EffectFor))
    elif inside:
        yield item


def _distinct(achievers: list[Achiever]) -> list[Achiever]:
    """Achievers of one rule with the same bindings once."""
    found = {(id(a.flat), tuple(sorted(a.env.items()))): a for a in achievers}
    return list(found.values())


def _some(tables: Tables) -> bool:
    """Whether some place is a move away."""
    return any(any(table[1:]) for table in tables)


def _is_ground(literal: Literal) -> bool:
    return all(isinstance(a, Object) for a in literal.args)


def _fact(literal: Literal) -> Fact:
    return (literal.predicate, *(a.name for a in literal.args if isinstance(a, Object)))


def _literal(fact: Fact) -> Literal:
    args: tuple[Term, ...] = tuple(Object(name) for name in fact[1:])
    return Literal(fact[0], args)


def _number(value: float) -> str:
    if math.isinf(value):
        return "inf"
    return str(int(value)) if value == int(value) else repr(value)


