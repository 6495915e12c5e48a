"""Hop distances between locations: how many actions, at least, until something can happen at a place.

A location family is a functional predicate whose keys are small objects (such as what an effector stands on). A rule
that gives a key the value Y while some key has the value X is an edge X → Y, wherever its static guards may hold for
some choice of everything else: lengths that depend on chains or modules count with their largest value.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...langs.frozen import dataclass
from ...langs.trees import parts
from ..ir import (
    Arith,
    ChainEnd,
    ChainModule,
    Compare,
    Function,
    Literal,
    Number,
    Object,
    Term,
    Type,
    Var,
)
from .algebra import holds
from .domains import FlatRule
from .guards import Guards
from .layout import FIELD, Field
from .normal_form import free_names

Matrix = NDArray[np.bool_]
Interval = tuple[Any, Any]
UPPER = ("<=", "<")
LOWER = (">=", ">")
LENGTHS = ("distance", "stride")


@dataclass(frozen=True, slots=True)
class LocationEdge:
    """A rule that gives a key of a family a value: `matrix[x, y]` says whether it may go from place x to place y. With
    no `matrix` the places in `targets` are reached from anywhere. `env` holds the numbers of places of the variables
    that name one, to broadcast."""

    flat: FlatRule
    env: Mapping[str, Any]
    matrix: Matrix | None
    targets: NDArray[np.bool_]
    cost: float

    @property
    def rule(self) -> str:
        return self.flat.rule.name


class EdgeFamily:
    """One location predicate: its places, the fields of its small keys, and the edges between places."""

    def __init__(self, guards: Guards, predicate: str, costs: Mapping[str, float]) -> None:
        self.guards = guards
        self.predicate = predicate
        layout = guards.layout
        self.fields: list[Field] = [
            f for (p, key), f in layout.fields.items() if p == predicate and key in layout.small
        ]
        self.places: tuple[str, ...] = self.fields[0].values if self.fields else ()
        self.indices = np.array([guards.geometry.index[name] for name in self.places], dtype=np.int64)
        self.key_at = guards.problem.predicates[predicate].functional_in or 0
        self.costs = costs
        self._bounds: dict[int, LengthBounds] = {}
        self._reads_chains = {id(flat): reads_chains(flat) for flat in layout.domains.rules}
        self._edges_of_rules: dict[tuple[int, int], list[LocationEdge]] = {}
        self._edges_by_modules: dict[int, list[LocationEdge]] = {}
        self._distances: dict[tuple[bytes, int], tuple[float, ...]] = {}
        self._sources: dict[tuple[object, ...], tuple[str | None, NDArray[np.bool_]]] = {}
        self.rules = {e.rule for e in self.edges(len(guards.problem.world.modules))}
        """The rules that move something."""

    def bounds(self, modules: int) -> LengthBounds:
        """Bounds on guards while no chain has more than so many modules."""
        if modules not in self._bounds:
            self._bounds[modules] = LengthBounds(self.guards, modules)
        return self._bounds[modules]

    def edges(self, modules: int) -> list[LocationEdge]:
        """All edges between places while no chain has more than so many modules."""
        if modules not in self._edges_by_modules:
            found: list[LocationEdge] = []
            for flat in self.guards.layout.domains.rules:
                key = (id(flat), modules if self._reads_chains[id(flat)] else 0)
                if key not in self._edges_of_rules:
                    self._edges_of_rules[key] = self._edges(flat, self.costs[flat.rule.name], self.bounds(modules))
                found += self._edges_of_rules[key]
            self._edges_by_modules[modules] = found
        return self._edges_by_modules[modules]

    def _edges(self, flat: FlatRule, cost: float, bounds: LengthBounds) -> list[LocationEdge]:
        domains = self.guards.layout.domains.variable_domains(flat)
        found = []
        for effect, types in flat.additions():
            literal = effect.literal
            if literal.predicate != self.predicate:
                continue
            keys = self.guards.layout.domains.term(literal.args[self.key_at], types, domains)
            if not keys & self.guards.layout.small:
                continue
            targets = self._mask(self.guards.layout.domains.term(literal.args[1 - self.key_at], types, domains))
            source = self.place_variable(flat, types, domains, {})
            env: dict[str, Any] = {}
            matrix = None
            if source is not None:
                env = self._between(source, literal.args[1 - self.key_at])
                matrix = self._relation(flat, source, literal.args[1 - self.key_at], env, domains, bounds)
                matrix = matrix & targets[None, :]
            found.append(LocationEdge(flat, env, matrix, targets, cost))
        return found

    def place_variable(
        self, flat: FlatRule, types: Mapping[str, Type], domains: Mapping[str, frozenset[str]], env: Mapping[str, str]
    ) -> str | None:
        """The variable that a condition `(p X key)` with a small key binds to a place."""
        for formula in flat.conjuncts:
            if not isinstance(formula, Literal) or formula.predicate != self.predicate:
                continue
            key, value = formula.args[self.key_at], formula.args[1 - self.key_at]
            keys = self.guards.layout.domains.term(key, dict(types), dict(domains))
            if isinstance(key, Var) and key.name in env:
                keys = frozenset((env[key.name],))
            if keys <= self.guards.layout.small and isinstance(value, Var) and value.name not in env:
                return value.name
        return None

    def _between(self, source: str, target: Term) -> dict[str, Any]:
        """The variables of the place before and the one after, with the numbers of all places."""
        env: dict[str, Any] = {source: self.indices[:, None]}
        if isinstance(target, Var) and target.name != source:
            env[target.name] = self.indices[None, :]
        return env

    def _relation(
        self, flat: FlatRule, source: str, target: Term, env: Mapping[str, Any],
        domains: Mapping[str, frozenset[str]], bounds: LengthBounds,
    ) -> Matrix:  # fmt: skip
        count = len(self.places)
        possible = np.ones((count, count), dtype=bool) & self._mask(domains[source])[:, None]
        if isinstance(target, Var) and target.name == source:
            return possible & np.eye(count, dtype=bool)
        related: Matrix = possible & bounds.possible(flat, env)
        return related

    def starts(self, flat: FlatRule, env: Mapping[str, str], modules: int) -> NDArray[np.bool_] | None:
        """The places at which a rule with some variables bound may fire while no chain has more than so many modules;
        None when it names no place."""
        source, allowed = self._source(flat, env)
        if source is None:
            return None
        found: NDArray[np.bool_] = allowed & self.bounds(modules).possible(flat, {**env, source: self.indices})
        return found

    def _source(self, flat: FlatRule, env: Mapping[str, str]) -> tuple[str | None, NDArray[np.bool_]]:
        """The variable that names a place, and which places it may name."""
        small = self.guards.layout.small
        key = (id(flat), *((name, value in small) for name, value in env.items()))
        if key not in self._sources:
            types = {v.name: v.type for v in flat.variables}
            domains = self.guards.layout.domains.variable_domains(flat)
            source = self.place_variable(flat, types, domains, env)
            self._sources[key] = source, self._mask(frozenset() if source is None else domains[source])
        return self._sources[key]

    def strain(self, flat: FlatRule, env: Mapping[str, str], modules: int) -> Any:
        """By place, the least strain of a rule that fires there with some variables bound."""
        source, _ = self._source(flat, env)
        known = dict(env) if source is None else {**env, source: self.indices}
        return self.bounds(modules).strain(flat, known)

    def moves(self, starts: NDArray[np.bool_], modules: int) -> tuple[float, ...]:
        """The least cost of moves until some key is at one of `starts`: first from nowhere, then from every place;
        infinite without a way."""
        key = (starts.tobytes(), modules)
        if key not in self._distances:
            self._distances[key] = self.with_nowhere(self._shortest(starts, modules), modules)
        return self._distances[key]

    def _shortest(self, starts: NDArray[np.bool_], modules: int) -> list[float]:
        """Dijkstra's distances, all places of one cost at a time."""
        edges = self.edges(modules)
        best: Any = np.where(starts, 0.0, math.inf)
        waiting: Any = starts
        while waiting.any():
            cost = float(best[waiting].min())
            level = waiting & (best == cost)
            waiting = waiting & ~level
            for edge in edges:
                near: Any
                if edge.matrix is None:
                    near = np.full(len(best), bool((edge.targets & level).any()))
                else:
                    near = edge.matrix[:, level].any(axis=1)
                better = near & (best > cost + edge.cost)
                best[better] = cost + edge.cost
                waiting = waiting | better
        return [float(b) for b in best]

    def with_nowhere(self, distances: Sequence[float], modules: int) -> tuple[float, ...]:
        """Costs from every place, and before them the least cost from nowhere."""
        found = (
            edge.cost + min((d for d, t in zip(distances, edge.targets, strict=True) if t), default=math.inf)
            for edge in self.edges(modules)
            if edge.matrix is None
        )
        return min(found, default=math.inf), *distances

    def _mask(self, names: frozenset[str]) -> NDArray[np.bool_]:
        return np.array([p in names for p in self.places], dtype=bool)


class LengthBounds:
    """Whether static guards may hold when only some variables are known, and chains have at most so many modules:
    interval arithmetic on their terms."""

    def __init__(self, guards: Guards, modules: int) -> None:
        self.guards = guards
        geometry = guards.geometry
        self.longest = geometry.longest_reach(modules)
        self.single = geometry.longest_reach(1)
        self.modules = modules
        ends = [geometry.index[name] for name in guards.problem.of_type("effector")]
        radii = [float(geometry.radius(i)) for i in ends] or [0.0]
        self.radii = (min(radii), max(radii))
        self._compares: dict[int, list[tuple[int, Compare, tuple[str, ...]]]] = {}
        self._numbers: dict[Compare, int] = {}
        self._known: dict[tuple[int, tuple[tuple[str, object], ...]], Any] = {}

    def possible(self, flat: FlatRule, env: Mapping[str, Any]) -> Any:
        """True where no comparison among the conjuncts is refuted; arrays in `env` broadcast. Arrays of one shape hold
        the same numbers in every call."""
        found: Any = np.True_
        for number, formula, names in self._comparisons(flat):
            given = tuple((n, v if isinstance(v, str) else v.shape) for n in names if (v := env.get(n)) is not None)
            if (number, given) not in self._known:
                self._known[number, given] = self._may_hold(formula, env)
            found = found & self._known[number, given]
        return found

    def _comparisons(self, flat: FlatRule) -> list[tuple[int, Compare, tuple[str, ...]]]:
        """The comparisons of sizes among the conjuncts of a rule, with the same number where they are the same, and
        with their variables."""
        if id(flat) not in self._compares:
            found = [f for f in flat.conjuncts if isinstance(f, Compare) and f.operator in UPPER + LOWER]
            numbers = [self._numbers.setdefault(f, len(self._numbers)) for f in found]
            names = [tuple(sorted(free_names(f))) for f in found]
            self._compares[id(flat)] = list(zip(numbers, found, names, strict=True))
        return self._compares[id(flat)]

    def _may_hold(self, formula: Compare, env: Mapping[str, Any]) -> Any:
        low, high = self.interval(formula.left, env), self.interval(formula.right, env)
        if formula.operator in LOWER:
            low, high = high, low
        return holds("<=", low[0], high[1])

    def strain(self, flat: FlatRule, env: Mapping[str, Any]) -> Any:
        """The least that the strain of an action can be: how close the lengths that its rule bounds are to their
        limits, 1 at the limit; arrays in `env` broadcast."""
        least: Any = np.zeros(())
        for compare in length_bounds(flat):
            below, above = self.interval(compare.left, env), self.interval(compare.right, env)
            if compare.operator in LOWER:
                below, above = above, below
            if np.all(above[1] > 0.0):
                least = np.maximum(least, np.maximum(below[0], 0.0) / above[1])
        return least

    def interval(self, term: Term, env: Mapping[str, Any]) -> Interval:
        """Least and largest value of a term over everything that `env` leaves open."""
        match term:
            case Number():
                return term.value, term.value
            case Arith():
                return self._arithmetic(term, env)
            case Function():
                return self._function(term, env)
            case _:
                return -math.inf, math.inf

    def _arithmetic(self, term: Arith, env: Mapping[str, Any]) -> Interval:
        parts = [self.interval(t, env) for t in term.operands]
        if term.operator == "neg":
            return -parts[0][1], -parts[0][0]
        (a, b), (c, d) = parts
        if term.operator == "+":
            return a + c, b + d
        if term.operator == "-":
            return a - d, b - c
        if term.operator == "*" and all(np.all(np.isfinite(x)) for x in (a, b, c, d)):
            products = [x * y for x, y in itertools.product((a, b), (c, d))]
            return np.minimum.reduce(products), np.maximum.reduce(products)
        return -math.inf, math.inf

    def _function(self, term: Function, env: Mapping[str, Any]) -> Interval:
        if term.name in ("distance", "stride"):
            places = [self._place(a, env) for a in term.args[:2]]
            inset = term.args[2] if term.name == "stride" else Number(0.0)
            if places[0] is None or places[1] is None or not isinstance(inset, Number):
                return 0.0, math.inf
            geometry = self.guards.geometry
            if term.name == "distance":
                value = geometry.distance(places[0], places[1])
            else:
                value = geometry.stride(places[0], places[1], inset.value)
            return value, value
        if term.name == "radius":
            return self._radius(term.args[0], env)
        if term.name == "reach":
            return 0.0, self.longest if len(term.args) == 1 else self.single
        if term.name == "length":
            return 1.0, float(max(self.modules, 1))
        return -math.inf, math.inf

    def _radius(self, term: Term, env: Mapping[str, Any]) -> Interval:
        place = self._place(term, env)
        if place is not None:
            value = self.guards.geometry.radius(place)
            return value, value
        return self.radii if isinstance(term, ChainEnd | ChainModule) else (0.0, math.inf)

    def _place(self, term: Term, env: Mapping[str, Any]) -> Any:
        if isinstance(term, Object):
            return self.guards.geometry.index[term.name]
        if isinstance(term, Var) and term.name in env:
            known = env[term.name]
            return self.guards.geometry.index[known] if isinstance(known, str) else known
        return None


def length_bounds(flat: FlatRule) -> list[Compare]:
    """The comparisons that bound a length of the scene."""
    found = [f for f in flat.conjuncts if isinstance(f, Compare) and f.operator in UPPER + LOWER]
    return [f for f in found if any(isinstance(p, Function) and p.name in LENGTHS for p in parts(f))]


def reads_chains(flat: FlatRule) -> bool:
    """Whether a condition depends on how long some chain is."""
    found = (part for formula in flat.conjuncts for part in parts(formula) if isinstance(part, Function))
    return any(f.name in ("reach", "length", "load") and len(f.args) == 1 for f in found)


def families(guards: Guards, costs: Mapping[str, float]) -> list[EdgeFamily]:
    """The location families of a problem that have some place and some key."""
    layout = guards.layout
    names = [p for p, kind in layout.kinds.items() if kind == FIELD]
    keyed = [name for name in names if any(k in layout.small for p, k in layout.fields if p == name)]
    made = [EdgeFamily(guards, name, costs) for name in keyed]
    return [f for f in made if f.places]
