"""Actions as lists of facts: conditions without negation, disjunction or quantifier, effects without wildcards.

What a condition denies has a predicate of its own (`not_p`) that effects keep up to date. A functional fact that some
condition wants absent, or some effect deletes without naming it, has the value `nothing`, or the key `nobody`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, product

from ...langs.diagnostics import UsageError
from ..ir import And, Any_, Compare, Exists, Forall, Formula, Literal, Not, Object, ObjectType, Or, Term, Var
from .expressions import ground
from .guards import Guards
from .layout import FIELD, Layout
from .lifted_chains import LiftedChain
from .normal_form import FALSE, TRUE
from .settings import SYMBOLIC

NOTHING, NOBODY = Object("`nothing"), Object("`nobody")
THING = "`thing"
"""Names of the export's own, which no task can give."""

Change = tuple[Literal, bool]
"""A literal and whether it is deleted."""


@dataclass(slots=True)
class Schema:
    """One action: its conditions, those that hold or not for good, and what it deletes and adds. `env` holds
    the values of the rule's other variables."""

    rule: str
    parameters: list[str]
    conditions: list[tuple[Literal, bool]]
    static: list[Literal]
    changes: list[Change]
    more: list[Literal] = field(default_factory=list)
    """Conditions that bind what wildcards stand for."""
    env: Mapping[str, object] = field(default_factory=dict)
    chains: Mapping[str, LiftedChain] = field(default_factory=dict)
    same: Mapping[str, str] = field(default_factory=dict)
    """The rule's chains, and its variables that are ends of them, by the parameter that they stand for."""
    deleted: list[Literal] = field(default_factory=list)
    added: list[Literal] = field(default_factory=list)

    def fresh(self) -> Var:
        """A new parameter."""
        self.parameters.append(f"any`{len(self.parameters)}")
        return Var(self.parameters[-1])


def denial(predicate: str) -> str:
    """The predicate that holds where another one does not."""
    return f"`not_{predicate}"


def alternatives(formula: Formula) -> list[list[Formula]]:
    """A reduced formula in disjunctive normal form. Raises UsageError where it is too large or quantified."""
    match formula:
        case Or():
            found = [option for part in formula.operands for option in alternatives(part)]
        case And():
            found = [list(chain(*options)) for options in product(*map(alternatives, formula.operands))]
        case Exists() | Forall():
            raise UsageError("PDDL without quantifiers cannot say a condition over things that a rule does not name")
        case _:
            found = [[formula]]
    if len(found) > SYMBOLIC.strips_alternatives:
        raise UsageError(f"a condition has more than {SYMBOLIC.strips_alternatives} alternatives, too many for PDDL")
    return found


class Strips:
    """Turns conditions and effects of schemas into positive ones, and knows what must be declared for that."""

    def __init__(self, guards: Guards) -> None:
        self.guards = guards
        self.layout: Layout = guards.layout
        self.denied: set[str] = set()
        self.asked: set[tuple[str, int]] = set()
        """Places of denied predicates at which a parameter stands, which may be anything of the type."""
        self.emptied: set[str] = set()
        self.unheld: set[str] = set()

    # --- what is needed ------------------------------------------------------------------------------------------

    def note(self, schema: Schema) -> None:
        """Remember which predicates need a negation, `nothing` or `nobody`."""
        for literal, positive in schema.conditions:
            if any(isinstance(a, Any_) for a in literal.args):
                self._place(literal)
                self.emptied.add(literal.predicate)
            elif not positive:
                self.denied.add(literal.predicate)
                self.asked |= {(literal.predicate, k) for k, a in enumerate(literal.args) if isinstance(a, Var)}
        for literal, negated in schema.changes:
            if not negated or self.layout.kinds[literal.predicate] != FIELD:
                continue
            key, value = self._split(literal)
            if isinstance(key, Any_) and isinstance(value, Any_):
                raise UsageError(f"PDDL cannot say that all facts ({literal.predicate} …) end at once")
            if isinstance(key, Any_) and self._bound(schema, literal) is None:
                self.unheld.add(literal.predicate)
            if isinstance(value, Any_) and self._bound(schema, literal) is None:
                self.emptied.add(literal.predicate)

    def single(self, changes: Sequence[Change]) -> Iterator[Formula]:
        """What must hold so that no functional predicate has two values after the changes."""
        gone = [literal for literal, negated in changes if negated]
        added = [literal for literal, negated in changes if not negated]
        for literal in added:
            if self.guards.problem.predicates[literal.predicate].functional_in is None or len(literal.args) < 2:
                continue
            if self.layout.kinds[literal.predicate] == FIELD:
                yield from self._one_value(literal, gone, added)
            else:
                yield from self._alone(literal, gone, added)

    def _one_value(self, literal: Literal, gone: Sequence[Literal], added: Sequence[Literal]) -> Iterator[Formula]:
        key, value = self._split(literal)
        for other in added:
            if other.predicate == literal.predicate and self._split(other)[0] == key and other != literal:
                raise UsageError(f"PDDL cannot say that two values of ({literal.predicate} …) are the same")
        dropped = [self._split(g)[1] for g in gone if g.predicate == literal.predicate and self._split(g)[0] == key]
        if not any(isinstance(v, Any_) for v in dropped):
            held = [self._pair(literal.predicate, key, v) for v in dict.fromkeys([value, *dropped])]
            yield Or((Not(self._pair(literal.predicate, key, Any_())), *held))

    def _alone(self, literal: Literal, gone: Sequence[Literal], added: Sequence[Literal]) -> Iterator[Formula]:
        if not all(isinstance(a, Object) for a in literal.args):
            raise UsageError(f"PDDL without quantifiers cannot say that ({literal.predicate} …) has one value")
        for fact in self.layout.rivals(ground(literal)):
            other = Literal(fact[0], tuple(map(Object, fact[1:])))
            if any(a in added for a in self._orders(other)):
                yield FALSE
            elif not any(self._covers(g, o) for g in gone for o in self._orders(other)):
                yield Not(other)

    def _covers(self, pattern: Literal, literal: Literal) -> bool:
        pairs = zip(pattern.args, literal.args, strict=False)
        return pattern.predicate == literal.predicate and all(isinstance(p, Any_) or p == a for p, a in pairs)

    def _place(self, literal: Literal) -> None:
        if self.layout.kinds[literal.predicate] != FIELD:
            raise UsageError(f"PDDL without quantifiers cannot ask for any ({literal.predicate} …)")

    def _split(self, literal: Literal) -> tuple[Term, Term]:
        key_at = self.guards.problem.predicates[literal.predicate].functional_in or 0
        return literal.args[key_at], literal.args[1 - key_at]

    def _pair(self, predicate: str, key: Term, value: Term) -> Literal:
        key_at = self.guards.problem.predicates[predicate].functional_in or 0
        return Literal(predicate, (key, value) if key_at == 0 else (value, key))

    def _bound(self, schema: Schema, pattern: Literal) -> Literal | None:
        """The condition that names the only fact that a deletion with a wildcard for the value may mean."""
        key, value = self._split(pattern)
        if not isinstance(value, Any_):
            return None
        known = (c for c, positive in schema.conditions if positive and c.predicate == pattern.predicate)
        return next((c for c in known if self._split(c)[0] == key and not isinstance(self._split(c)[1], Any_)), None)

    # --- translation ---------------------------------------------------------------------------------------------

    def settle(self, schema: Schema) -> None:
        """Fill in `more`, `deleted` and `added`."""
        for literal, positive in schema.conditions:
            schema.more += self._condition(schema, literal, positive)
        deleted: dict[Literal, None] = {}
        added: dict[Literal, None] = {}
        for literal, negated in schema.changes:
            if negated:
                for fact in self._deletions(schema, literal):
                    self._change(deleted, added, fact)
        for literal, negated in schema.changes:
            if not negated:
                self._change(added, deleted, literal)
                self._displace(deleted, added, literal)
        schema.deleted, schema.added = list(deleted), list(added)

    def _condition(self, schema: Schema, literal: Literal, positive: bool) -> list[Literal]:
        if not any(isinstance(a, Any_) for a in literal.args):
            return [literal if positive else Literal(denial(literal.predicate), literal.args)]
        key, _ = self._split(literal)
        if not positive:
            return [self._pair(literal.predicate, key, NOTHING)]
        value = schema.fresh()
        return [self._pair(literal.predicate, key, value), Literal(THING, (value,))]

    def _deletions(self, schema: Schema, literal: Literal) -> Iterator[Literal]:
        if not any(isinstance(a, Any_) for a in literal.args):
            yield literal
        elif self.layout.kinds[literal.predicate] != FIELD:
            yield from self._named(literal)
        else:
            bound = self._bound(schema, literal)
            if bound is None:
                key, value = self._split(literal)
                free = schema.fresh()
                key, value = (free, value) if isinstance(key, Any_) else (key, free)
                bound = self._pair(literal.predicate, key, value)
                schema.more.append(bound)
            yield bound

    def _named(self, literal: Literal) -> list[Literal]:
        """All facts that a deletion with wildcards may mean."""
        domains = self.layout.domains
        options: list[list[Term]] = []
        for k, arg in enumerate(literal.args):
            names = (o for o in self.guards.problem.objects if o in domains.at(literal.predicate, k))
            options.append([Object(n) for n in names] if isinstance(arg, Any_) else [arg])
        found = [Literal(literal.predicate, args) for args in product(*options)]
        if len(found) > SYMBOLIC.strips_facts:
            many = f"more than {SYMBOLIC.strips_facts} facts ({literal.predicate} …)"
            raise UsageError(f"an effect deletes {many}, too many for PDDL")
        return found

    def _change(self, gained: dict[Literal, None], lost: dict[Literal, None], literal: Literal) -> None:
        for order in self._orders(literal):
            gained[order] = None
            lost.pop(order, None)
        adds = gained, lost
        if literal.predicate in self.denied:
            for order in self._orders(literal):
                other = Literal(denial(order.predicate), order.args)
                adds[1][other] = None
                adds[0].pop(other, None)

    def _orders(self, literal: Literal) -> list[Literal]:
        orders = [literal]
        if self.guards.problem.predicates[literal.predicate].symmetric:
            orders.append(Literal(literal.predicate, literal.args[::-1]))
        return list(dict.fromkeys(orders))

    def _displace(self, deleted: dict[Literal, None], added: dict[Literal, None], literal: Literal) -> None:
        """A new functional fact ends the emptiness of its key, and that nobody has its value."""
        key, value = self._split(literal) if len(literal.args) == 2 else (NOTHING, NOTHING)
        if literal.predicate in self.emptied:
            deleted[self._pair(literal.predicate, key, NOTHING)] = None
        if literal.predicate in self.unheld:
            deleted[self._pair(literal.predicate, NOBODY, value)] = None

    def left_behind(self, schema: Schema) -> list[Literal]:
        """What a schema adds because a functional fact is gone and no other came in its place."""
        found: list[Literal] = []
        for literal in schema.deleted:
            if literal.predicate not in self.emptied | self.unheld or set(literal.args) <= {NOTHING, NOBODY}:
                continue
            key, value = self._split(literal)
            new = [self._split(a) for a in schema.added if a.predicate == literal.predicate]
            real = key != NOBODY and value != NOTHING
            if real and literal.predicate in self.emptied and all(k != key for k, _ in new):
                found.append(self._pair(literal.predicate, key, NOTHING))
            if real and literal.predicate in self.unheld and all(v != value for _, v in new):
                found.append(self._pair(literal.predicate, NOBODY, value))
        return found

    # --- the start -----------------------------------------------------------------------------------------------

    def initial(self, facts: frozenset[tuple[str, ...]]) -> Iterator[tuple[str, ...]]:
        """The facts that stand for what does not hold at the start."""
        domains = self.layout.domains
        for predicate in sorted(self.denied):
            places = self.guards.problem.predicates[predicate].variables
            every = [
                self._all(predicate, k) if (predicate, k) in self.asked else domains.at(predicate, k)
                for k in range(len(places))
            ]
            for names in product(*map(sorted, every)):
                if (predicate, *names) not in facts:
                    yield (denial(predicate), *names)
        for predicate in sorted(self.emptied | self.unheld):
            key_at = self.guards.problem.predicates[predicate].functional_in or 0
            held = {f[1 + key_at] for f in facts if f[0] == predicate}
            used = {f[2 - key_at] for f in facts if f[0] == predicate}
            pairs = [(k, NOTHING.name) for k in self._all(predicate, key_at) - held if predicate in self.emptied]
            pairs += [(NOBODY.name, v) for v in self._all(predicate, 1 - key_at) - used if predicate in self.unheld]
            yield from ((predicate, *(pair if key_at == 0 else pair[::-1])) for pair in sorted(pairs))

    def _all(self, predicate: str, position: int) -> set[str]:
        """Whatever a parameter of a predicate may denote by its type."""
        kind = self.guards.problem.predicates[predicate].variables[position].type
        return set(self.guards.problem.of_type(kind.name)) if isinstance(kind, ObjectType) else set()


def literals(option: Sequence[Formula], layout: Layout) -> tuple[list[tuple[Literal, bool]], list[Compare]]:
    """An alternative as literals, each with whether it must hold, and comparisons of lengths or things."""
    conditions: list[tuple[Literal, bool]] = []
    static: list[Compare] = []
    for part in option:
        if part in (TRUE, FALSE):
            continue
        if isinstance(part, Compare):
            static.append(part)
        elif isinstance(part, Literal):
            conditions.append((part, True))
        elif isinstance(part, Not) and isinstance(part.operand, Literal):
            conditions.append((part.operand, False))
        else:
            raise UsageError(f"PDDL cannot say {part}")
    return conditions, static


def contradicts(conditions: Sequence[tuple[Literal, bool]]) -> bool:
    """Whether the same literal must hold and must not."""
    seen: dict[Literal, bool] = {}
    return any(seen.setdefault(literal, positive) is not positive for literal, positive in conditions)
