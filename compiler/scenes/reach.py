"""What all modules of a scene together may reach: the delete relaxation once more, with the lengths that rules ask for.

Every quantity errs on the hopeful side: shapes are no farther apart than the boxes around them, chains reach as far as
all modules in one line. What is refused here is impossible, and no more is known of the rest. Pure Python, for `check`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from ...langs.frozen import dataclass
from ...langs.trees import parts
from .. import ir
from ..symbolic.domains import Domains, FlatRule, flat_rules
from ..symbolic.lengths import end_radius, longest_chain, shape_radius
from ..symbolic.normal_form import NormalForm
from .check_start import Box, volumes

SLACK = 1e-6

Interval = tuple[float, float]
Sets = dict[str, set[str]]


@dataclass(frozen=True, slots=True)
class Miss:
    """A bound on a length that no pair of objects meets: by which rule, and the pair that comes nearest to it."""

    rule: str
    bound: ir.Compare
    pair: tuple[str, str]
    length: float
    limit: float


class Lengths:
    """Least distances between objects of a scene at the start, by the boxes around them."""

    def __init__(self, problem: ir.Problem) -> None:
        self.world = problem.world
        self.boxes: dict[str, list[Box]] = {}
        self.radii: dict[str, float] = {}
        for volume in volumes(problem.world):
            for name in dict.fromkeys((volume.name, volume.owner)):
                self.boxes.setdefault(name, []).append(volume.bounds)
        for body in problem.world.bodies.values():
            self.radii[body.name] = shape_radius(body.shape)
        for module in problem.world.modules.values():
            for end in module.type.effectors:
                self.radii[f"{module.name}.{end.name}"] = end_radius(module.type, end.name)
        self._known: dict[tuple[str, str], float] = {}

    def apart(self, one: str, other: str) -> float:
        key = (one, other)
        if key not in self._known:
            pairs = ((a, b) for a in self.boxes.get(one, ()) for b in self.boxes.get(other, ()))
            self._known[key] = min((_gap(a, b) for a, b in pairs), default=0.0)
        return self._known[key]


def _gap(a: Box, b: Box) -> float:
    return math.hypot(*(max(a[i] - b[i + 3], b[i] - a[i + 3], 0.0) for i in range(3)))


_known_rules: list[tuple[ir.Problem, list[FlatRule]]] = []
"""The rules of the program that was looked at last: its tasks share them."""


def _flat_rules_of(problem: ir.Problem) -> list[FlatRule]:
    """Its rules by themselves; their names may be those of other formulas' variables."""
    if _known_rules:
        before, flat = _known_rules[0]
        if before.rules is problem.rules and before.derived is problem.derived:
            return flat
    flat = flat_rules(problem, NormalForm(problem))
    _known_rules[:] = [(problem, flat)]
    return flat


class Reach:
    """The fixed point for the scene's modules and `more` others: which objects can stand at each place of a predicate.
    Facts about effectors are kept apart from facts about things, since a thing lies where no robot may ever stand."""

    def __init__(self, problem: ir.Problem, lengths: Lengths, more: int) -> None:
        self.problem = problem
        self.lengths = lengths
        self.normal = NormalForm(problem)
        self.domains = Domains(problem, self.normal, _flat_rules_of(problem))
        modules = problem.world.modules.values()
        self.modules = len(modules) + more
        self.longest = longest_chain(modules, len(modules), more)
        self.single = longest_chain(modules, 1)
        self.ends = frozenset(problem.of_type("effector"))
        radii = [lengths.radii.get(e, 0.0) for e in self.ends] or [0.0]
        self.radii = min(radii), max(radii)
        self._columns: dict[tuple[str, int, bool], set[str]] = {}
        self._near: dict[tuple[int, str], set[str]] = {}
        for predicate, *names in problem.init:
            self._grow(predicate, [{name} for name in names])
        helpful = self._helpful()
        while any([self._fire(flat) for flat in helpful]):
            pass

    def _helpful(self) -> list[FlatRule]:
        """The rules that add what the goal speaks of, or what such a rule asks: no other changes what is asked here."""
        literals = parts(self.normal.normal(self.problem.goal, {}, False))
        wanted = {p.predicate for p in literals if isinstance(p, ir.Literal)}
        waiting, found = list(self.domains.rules), list[FlatRule]()
        while True:
            more, rest = list[FlatRule](), list[FlatRule]()
            for flat in waiting:
                helps = any(e.literal.predicate in wanted for e, _ in flat.additions())
                (more if helps else rest).append(flat)
            if not more:
                return found
            found, waiting = found + more, rest
            wanted |= {c.predicate for f in more for c in f.conjuncts if isinstance(c, ir.Literal)}

    # --- what can hold -------------------------------------------------------------------------------------------

    def column(self, predicate: str, position: int) -> set[str]:
        """The objects that can stand at a place of a predicate."""
        columns = self._columns
        return columns.get((predicate, position, True), set()) | columns.get((predicate, position, False), set())

    def possible(self, formula: ir.Formula) -> bool:
        """Whether a closed formula may come to hold."""
        return self._possible(self.normal.normal(formula, {}, False), {})

    def _possible(self, formula: ir.Formula, binding: Mapping[str, str]) -> bool:
        match formula:
            case ir.Literal():
                return self._may_hold(formula, binding)
            case ir.And():
                return all(self._possible(f, binding) for f in formula.operands)
            case ir.Or():
                return any(self._possible(f, binding) for f in formula.operands)
            case ir.Exists():
                return self._possible(formula.body, binding)
            case ir.Forall():
                return all(self._possible(formula.body, b) for b in self._bindings(formula.variables, binding))
            case ir.Compare():
                return self._compares(formula, {})
            case _:
                return True

    def _bindings(
        self, variables: tuple[ir.Variable, ...], binding: Mapping[str, str]
    ) -> Iterator[Mapping[str, str]]:
        if not variables or not isinstance(variables[0].type, ir.ObjectType):
            yield binding
            return
        for name in self.problem.of_type(variables[0].type.name):
            yield from self._bindings(variables[1:], {**binding, variables[0].name: name})

    def _may_hold(self, literal: ir.Literal, binding: Mapping[str, str]) -> bool:
        names = [a.name if isinstance(a, ir.Object) else binding.get(getattr(a, "name", "")) for a in literal.args]
        symmetric = self.problem.predicates[literal.predicate].symmetric
        orders = (names, names[::-1]) if symmetric else (names,)
        return any(self._stands(literal.predicate, order) for order in orders)

    def _stands(self, predicate: str, names: list[str | None]) -> bool:
        classes = [self._class(predicate, names)] if all(names) else [True, False]
        return any(
            all(
                name in column if name is not None else column
                for k, name in enumerate(names)
                for column in [self._columns.get((predicate, k, c), set())]
            )
            for c in classes
        )

    def _class(self, predicate: str, names: list[str | None]) -> bool:
        """Whether a functional fact is about an effector."""
        key_at = self.problem.predicates[predicate].functional_in
        return key_at is not None and names[key_at] in self.ends

    # --- the fixed point -----------------------------------------------------------------------------------------

    def _grow(self, predicate: str, columns: list[set[str]]) -> bool:
        key_at = self.problem.predicates[predicate].functional_in
        grown = False
        for about_end in (True, False):
            own = [set(c) for c in columns]
            if key_at is not None:
                own[key_at] = own[key_at] & self.ends if about_end else own[key_at] - self.ends
            if (key_at is None and about_end) or not all(own):
                continue
            for k, names in enumerate(own):
                here = self._columns.setdefault((predicate, k, about_end), set())
                grown = grown or not names <= here
                here |= names
        return grown

    def _fire(self, flat: FlatRule) -> bool:
        names = self._objects(flat, {})
        if names is None:
            return False
        grown = False
        frozen = {name: frozenset(found) for name, found in names.items()}
        for effect, types in flat.additions():
            literal = effect.literal
            columns = [set(self.domains.term(a, types, frozen)) for a in literal.args]
            symmetric = self.problem.predicates[literal.predicate].symmetric
            for order in (columns, columns[::-1]) if symmetric else (columns,):
                grown = self._grow(literal.predicate, order) or grown
        return grown

    def _objects(self, flat: FlatRule, binding: Mapping[str, str]) -> Sets | None:
        """The objects that each variable of a rule can be, or None when it can never fire."""
        known = self.domains.variable_domains(flat)
        found = {name: {binding[name]} & values if name in binding else set(values) for name, values in known.items()}
        types = {v.name: v.type for v in flat.variables}
        for literal in flat.conjuncts:
            if isinstance(literal, ir.Literal) and not self._restrict(literal, found, types):
                return None
        for compare in flat.conjuncts:
            if isinstance(compare, ir.Compare) and not self._narrow(compare, found):
                return None
        return found if all(found.values()) else None

    def _restrict(self, literal: ir.Literal, found: Sets, types: dict[str, ir.Type]) -> bool:
        key_at = self.problem.predicates[literal.predicate].functional_in
        classes = [False]
        if key_at is not None:
            frozen = {name: frozenset(values) for name, values in found.items()}
            keys = self.domains.term(literal.args[key_at], types, frozen)
            classes = [c for c, some in ((True, keys & self.ends), (False, keys - self.ends)) if some]
        for k, arg in enumerate(literal.args):
            column: set[str] = set()
            for about_end in classes:
                column |= self._columns.get((literal.predicate, k, about_end), set())
            if not column:
                return False
            if isinstance(arg, ir.Var) and arg.name in found:
                found[arg.name] &= column
        return True

    def _narrow(self, compare: ir.Compare, found: Sets) -> bool:
        """Keep the objects between which a bound on a length may hold; whether there are any."""
        names = _measured(compare)
        if names is None or not all(name in found for name in names):
            return self._compares(compare, {})
        one, other = names
        near: set[str] = set()
        kept = set()
        for name in found[one]:
            close = self._close(compare, one, other, name) & found[other]
            near |= close
            if close:
                kept.add(name)
        found[one], found[other] = kept, near
        return bool(kept)

    def _close(self, compare: ir.Compare, one: str, other: str, name: str) -> set[str]:
        key = (id(compare), name)
        if key not in self._near:
            objects = self.problem.objects
            self._near[key] = {o for o in objects if self._compares(compare, {one: name, other: o})}
        return self._near[key]

    def nearest(self, goal: ir.Formula) -> Miss | None:
        """The bound on a length nearest to being met among those that keep the goal's facts from coming true."""
        wanted = {p.predicate: p for p in parts(self.normal.normal(goal, {}, False)) if isinstance(p, ir.Literal)}
        misses: list[Miss] = []
        for flat in self.domains.rules:
            for effect, _ in flat.additions():
                literal = wanted.get(effect.literal.predicate)
                if literal is None:
                    continue
                pairs = zip(effect.literal.args, literal.args, strict=True)
                binding = {a.name: o.name for a, o in pairs if isinstance(a, ir.Var) and isinstance(o, ir.Object)}
                misses += self._misses(flat, binding)
        return min(misses, key=lambda m: m.length - m.limit, default=None)

    def _misses(self, flat: FlatRule, binding: Mapping[str, str]) -> Iterator[Miss]:
        known = self.domains.variable_domains(flat)
        found = {name: {binding[name]} & values if name in binding else set(values) for name, values in known.items()}
        types = {v.name: v.type for v in flat.variables}
        literals = [f for f in flat.conjuncts if isinstance(f, ir.Literal)]
        if not all(self._restrict(literal, found, types) for literal in literals) or not all(found.values()):
            return
        for compare in flat.conjuncts:
            names = _measured(compare) if isinstance(compare, ir.Compare) else None
            if names is None or not all(name in found for name in names) or not isinstance(compare, ir.Compare):
                continue
            options = []
            for a in sorted(found[names[0]]):
                for b in sorted(found[names[1]]):
                    low, high = self._sides(compare, {names[0]: a, names[1]: b})
                    options.append((low - high, low, high, (a, b)))
            miss, low, high, pair = min(options)
            if miss > SLACK:
                yield Miss(flat.rule.name, compare, pair, low, high)

    # --- lengths -------------------------------------------------------------------------------------------------

    def _compares(self, compare: ir.Compare, env: Mapping[str, str]) -> bool:
        if compare.operator not in ("<", "<=", ">", ">="):
            return True
        low, high = self._sides(compare, env)
        return low <= high + SLACK

    def _sides(self, compare: ir.Compare, env: Mapping[str, str]) -> Interval:
        """The least value of the side that must be small, and the largest of the other."""
        small, large = compare.left, compare.right
        if compare.operator in (">", ">="):
            small, large = large, small
        return self._interval(small, env)[0], self._interval(large, env)[1]

    def _interval(self, term: ir.Term, env: Mapping[str, str]) -> Interval:
        match term:
            case ir.Number():
                return term.value, term.value
            case ir.Arith():
                return _arithmetic(term.operator, [self._interval(t, env) for t in term.operands])
            case ir.Function(name="distance" | "stride"):
                names = [_object(a, env) for a in term.args[:2]]
                known = names[0] is not None and names[1] is not None
                return (self.lengths.apart(str(names[0]), str(names[1])) if known else 0.0), math.inf
            case ir.Function(name="radius"):
                return self._radius(term.args[0], env)
            case ir.Function(name="reach"):
                return 0.0, self.longest if len(term.args) == 1 else self.single
            case ir.Function(name="length"):
                return 1.0, float(max(self.modules, 1))
            case _:
                return -math.inf, math.inf

    def _radius(self, term: ir.Term, env: Mapping[str, str]) -> Interval:
        if isinstance(term, ir.ChainEnd | ir.ChainModule):
            return self.radii
        name = _object(term, env)
        if name is None:
            return 0.0, max(self.lengths.radii.values(), default=0.0)
        value = self.lengths.radii.get(name, 0.0)
        return value, value


def _object(term: ir.Term, env: Mapping[str, str]) -> str | None:
    if isinstance(term, ir.Object):
        return term.name
    return env.get(term.name) if isinstance(term, ir.Var) else None


def _measured(compare: ir.Compare) -> tuple[str, str] | None:
    """The two variables whose distance a comparison speaks of."""
    for part in parts(compare):
        if isinstance(part, ir.Function) and part.name in ("distance", "stride"):
            one, other = part.args[:2]
            if isinstance(one, ir.Var) and isinstance(other, ir.Var) and one != other:
                return one.name, other.name
    return None


def _arithmetic(operator: str, sides: list[Interval]) -> Interval:
    (a, b), (c, d) = sides[0], sides[-1]
    if operator == "neg":
        return -b, -a
    if operator == "+":
        return a + c, b + d
    if operator == "-":
        return a - d, b - c
    if operator == "*" and all(map(math.isfinite, (a, b, c, d))):
        products = [x * y for x in (a, b) for y in (c, d)]
        return min(products), max(products)
    return -math.inf, math.inf
