"""The delete relaxation, by projections: which objects can ever stand at each place of each predicate.

Deletions, negations and numeric guards are ignored and every argument is taken by itself, so the sets are too large but
never too small: what they exclude can never happen. The work grows with the number of objects, not of actions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from .. import ir

Columns = list[set[str]]
Domains = dict[str, set[str]]


@dataclass(slots=True)
class RelaxedWorld:
    """What the relaxation needs to know of a task. `types` and `objects` as in `ir.Problem`."""

    types: Mapping[str, str | None]
    objects: Mapping[str, str]
    derived: Mapping[str, ir.Derived]
    predicates: Mapping[str, ir.Predicate]
    rules: Mapping[str, ir.Rule]
    init: frozenset[ir.Fact]
    by_type: dict[str, frozenset[str]] = field(default_factory=dict)

    def of_type(self, name: str) -> frozenset[str]:
        """All objects of type `name` or below it."""
        if name not in self.by_type:
            self.by_type[name] = frozenset(o for o, t in self.objects.items() if self.is_a(t, name))
        return self.by_type[name]

    def is_a(self, name: str, ancestor: str) -> bool:
        current: str | None = name
        while current is not None:
            if current == ancestor:
                return True
            current = self.types[current]
        return False


class Relaxation:
    """The fixed point. `columns` maps a predicate that can hold to its possible objects by place; `domains` maps a rule
    that can fire to the possible objects of its variables (of object types)."""

    def __init__(self, world: RelaxedWorld) -> None:
        self.world = world
        self.columns: dict[str, Columns] = {}
        self.domains: dict[str, Domains] = {}
        for fact in world.init:
            self.grow(fact[0], [{name} for name in fact[1:]])
        self._settle()

    def _settle(self) -> None:
        """Read each definition and rule, and again whenever something grows that it reads."""
        readers: dict[str, list[ir.Derived | ir.Rule]] = {}
        readable: list[ir.Derived | ir.Rule] = [*self.world.derived.values(), *self.world.rules.values()]
        for reader in readable:
            condition = reader.condition if isinstance(reader, ir.Rule) else reader.body
            chains = {v.type.predicate for v in reader.variables if isinstance(v.type, ir.ChainType)}
            for predicate in chains | {literal.predicate for literal in needed_literals(condition)[0]}:
                readers.setdefault(predicate, []).append(reader)
        waiting = {id(reader): reader for reader in reversed(readable)}
        while waiting:
            _, reader = waiting.popitem()
            for predicate in self.fire(reader) if isinstance(reader, ir.Rule) else self.derive(reader):
                waiting.update({id(r): r for r in readers.get(predicate, ())})

    def grow(self, predicate: str, more: Sequence[set[str] | frozenset[str]]) -> bool:
        """Add objects to the places of a predicate; whether anything was new."""
        columns = self.columns.get(predicate)
        if columns is None:
            self.columns[predicate] = [set(m) for m in more]
            return True
        changed = False
        for column, new in zip(columns, more, strict=True):
            if not new <= column:
                column |= new
                changed = True
        return changed

    def derive(self, derived: ir.Derived) -> set[str]:
        """The predicates that grow by a definition: none, or its own."""
        domains = self.solve(derived.variables, derived.body)
        if domains is None:
            return set()
        columns = [domains[v.name] for v in derived.variables]
        return {derived.name} if self.grow(derived.name, columns) else set()

    def fire(self, rule: ir.Rule) -> set[str]:
        """The predicates that grow when a rule fires."""
        domains = self.solve(rule.variables, rule.condition)
        if domains is None:
            return set()
        self.domains[rule.name] = domains
        grown: set[str] = set()
        for effect, loops in ir.effects_with_loops(rule.effects):
            if effect.negated or effect.literal.motion:
                continue
            columns = self.places(rule, effect.literal, loops)
            name = effect.literal.predicate
            grown |= {name} if self.grow(name, columns) else set()
            if self.world.predicates[name].symmetric and self.grow(name, columns[::-1]):
                grown.add(name)
        return grown

    def places(self, rule: ir.Rule, literal: ir.Literal, loops: Iterable[ir.Variable]) -> list[set[str]]:
        """The objects that the arguments of an effect of a rule that can fire can be, within loops."""
        found = self.domains[rule.name]
        inner = {**found, **{v.name: set(self.of(v)) for v in loops if isinstance(v.type, ir.ObjectType)}}
        by = {v.name: v.type.predicate for v in rule.variables if isinstance(v.type, ir.ChainType)}
        return [self.values(arg, inner, by) for arg in literal.args]

    def of(self, variable: ir.Variable) -> frozenset[str]:
        return self.world.of_type(variable.type.name) if isinstance(variable.type, ir.ObjectType) else frozenset()

    def solve(self, variables: Sequence[ir.Variable], condition: ir.Formula) -> Domains | None:
        """The objects that each variable, and each end of a chain that the condition speaks of, can be, or None when
        the condition can never hold."""
        domains = {v.name: set(self.of(v)) for v in variables if isinstance(v.type, ir.ObjectType)}
        literals, bound = needed_literals(condition)
        domains.update({v.name: set(self.of(v)) for v in bound if isinstance(v.type, ir.ObjectType)})
        if not all(domains.values()) and variables:
            return None
        equal = list(needed_equalities(condition))
        terms = [arg for literal in literals for arg in literal.args] + [term for pair in equal for term in pair]
        domains.update({_end(t): set(self.world.of_type("effector")) for t in terms if isinstance(t, ir.ChainEnd)})
        if not all(self.restrict(literal, domains) for literal in literals):
            return None
        for one, other in equal:
            if _end(one) in domains and _end(other) in domains:
                domains[_end(one)] = domains[_end(other)] = domains[_end(one)] & domains[_end(other)]
                if not domains[_end(one)]:
                    return None
        return domains

    def restrict(self, literal: ir.Literal, domains: Domains) -> bool:
        """Narrow the domains by one literal that must hold; whether it can."""
        columns = self.columns.get(literal.predicate)
        if columns is None:
            return False
        for arg, column in zip(literal.args, columns, strict=True):
            if _end(arg) in domains:
                domains[_end(arg)] &= column
                if not domains[_end(arg)]:
                    return False
            elif isinstance(arg, ir.Object) and arg.name not in column:
                return False
        return True

    def values(self, arg: ir.Term, domains: Domains, by: Mapping[str, str]) -> set[str]:
        """The objects that an argument of an effect can be. `by` names by what predicate each chain is connected: ends
        of modules within a chain are those that it connects, or the chain's own."""
        if isinstance(arg, ir.Object):
            return {arg.name}
        if isinstance(arg, ir.Any_):
            return set(self.world.objects)
        effectors = set(self.world.of_type("effector"))
        if isinstance(arg, ir.ChainModule):
            if not arg.side:
                return set(self.world.of_type("module"))
            outer = (domains.get(_end(ir.ChainEnd(arg.chain, last)), effectors) for last in (False, True))
            return set().union(*self.columns.get(by[arg.chain], ()), *outer) if arg.chain in by else effectors
        return domains.get(_end(arg), effectors)


def _end(term: ir.Term) -> str:
    """How a variable, or an end of a chain, is called in domains; nothing else is."""
    if isinstance(term, ir.ChainEnd):
        return f"{term.chain}.{'last' if term.last else 'first'}"
    return term.name if isinstance(term, ir.Var) else ""


def needed_literals(formula: ir.Formula) -> tuple[list[ir.Literal], list[ir.Variable]]:
    """The positive literals that must hold, and the variables of the `exists` around them."""
    if isinstance(formula, ir.Literal):
        return [formula], []
    if isinstance(formula, ir.And):
        parts = [needed_literals(f) for f in formula.operands]
        return [x for p in parts for x in p[0]], [v for p in parts for v in p[1]]
    if isinstance(formula, ir.Exists):
        literals, bound = needed_literals(formula.body)
        return literals, [*formula.variables, *bound]
    return [], []


def needed_equalities(formula: ir.Formula) -> Iterator[tuple[ir.Term, ir.Term]]:
    """The pairs of terms that must be equal."""
    if isinstance(formula, ir.Compare) and formula.operator == "=":
        yield formula.left, formula.right
    for inner in formula.operands if isinstance(formula, ir.And) else ():
        yield from needed_equalities(inner)
    if isinstance(formula, ir.Exists):
        yield from needed_equalities(formula.body)


def movable(
    relaxation: Relaxation, motions: Mapping[str, ir.MotionPredicate], start: Iterable[ir.Fact]
) -> set[str]:
    """The objects that can follow another: those that some rule makes do so, where an added motion literal keeps their
    pose, and those that the motion literals of the start keep to what follows, as a thing on a carried thing."""
    following = {name: set(followers(motion)) for name, motion in motions.items()}
    found: set[str] = set()
    for name in relaxation.domains:
        rule = relaxation.world.rules[name]
        for effect, loops in ir.effects_with_loops(rule.effects):
            if effect.literal.motion and not effect.negated:
                places = relaxation.places(rule, effect.literal, loops)
                found.update(*(places[place] for place in following[effect.literal.predicate]))
    kept = [(fact[1:], place) for fact in sorted(start) for place in following[fact[0]]]
    grew = True
    while grew:
        more = {names[place] for names, place in kept if found.intersection(names[:place] + names[place + 1 :])}
        grew = not more <= found
        found |= more
    return found


def followers(motion: ir.MotionPredicate) -> Iterator[int]:
    """The places of a literal whose objects it has follow another."""
    names = [v.name for v in motion.variables]
    for row in motion.rows:
        kept = row.left
        if (
            row.when == "keep"
            and isinstance(kept, ir.Function)
            and kept.name == "pose"
            and isinstance(kept.args[0], ir.Var)
        ):
            yield names.index(kept.args[0].name)
