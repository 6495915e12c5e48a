"""States up to the names of interchangeable modules, and of the two ends of a module."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ...langs.trees import parts
from ..ir import Action, Chain, Fact, Formula, Function, Object, Problem, Value, Var, effects_of
from .layout import BIT, Layout
from .settings import SYMBOLIC
from .successors import Successors
from .symmetry import is_reversible


def renaming(successors: Successors) -> Renaming | None:
    """Gives states that differ only in the names of interchangeable modules, or of the two ends of
    such a module, the same int (mostly: ties may remain). None when there are too few such modules."""
    layout, problem = successors.layout, successors.problem
    named = _named(problem)
    if _reads_positions(successors) or not _plain_places(layout):
        return None
    groups: list[list[str]] = []
    for module in problem.world.modules.values():
        objects = _objects(problem, module.name)
        if named & set(objects):
            continue
        for group in groups:
            swapped = dict(zip(_objects(problem, group[0]), objects, strict=False))
            same_type = problem.world.modules[group[0]].type == module.type
            if same_type and _invariant(layout, swapped | {b: a for a, b in swapped.items()}):
                group.append(module.name)
                break
        else:
            groups.append([module.name])
    large = [g for g in groups if len(g) >= SYMBOLIC.renamed_from]
    return Renaming(layout, large) if large else None


def _objects(problem: Problem, module: str) -> list[str]:
    return [module, *(f"{module}.{e.name}" for e in problem.world.modules[module].type.effectors)]


def _invariant(layout: Layout, swapped: Mapping[str, str]) -> bool:
    """Whether the static facts stay the same under a renaming."""
    return {(f[0], *(swapped.get(n, n) for n in f[1:])) for f in layout.static} == layout.static


def _plain_places(layout: Layout) -> bool:
    """Whether small objects occur only in flags of one or two arguments and as keys of fields."""
    if any(len(fact) > 3 for fact in layout.flags):
        return False
    if any(set(fact[1:]) & layout.small for fact in layout.bits):
        return False
    loose = [p for p, kind in layout.kinds.items() if kind == BIT]
    places = [(p, k) for p in loose for k in range(len(layout.problem.predicates[p].variables))]
    if any(layout.domains.at(p, k) & layout.small for p, k in places):
        return False
    return not any(set(field.values) & layout.small for field in layout.fields.values())


def _reads_positions(successors: Successors) -> bool:
    """Whether some guard may ask where a module or effector is at the start; those then differ."""
    layout = successors.layout
    goal = successors.normal.normal(successors.problem.goal, {}, False)
    conditions = [(f, layout.domains.variable_domains(r)) for r in layout.domains.rules for f in r.conjuncts]
    return any(_touches(layout, term, names) for term, names in _functions([*conditions, (goal, {})]))


def _functions(
    items: Iterable[tuple[Formula, Mapping[str, frozenset[str]]]],
) -> Iterable[tuple[Function, Mapping[str, frozenset[str]]]]:
    for formula, names in items:
        for part in parts(formula):
            if isinstance(part, Function) and part.name in ("distance", "stride", "load", "torque"):
                yield part, names


def _touches(layout: Layout, term: Function, names: Mapping[str, frozenset[str]]) -> bool:
    if term.name == "load" and isinstance(term.args[0], Var) and term.args[0].name not in names:
        return False
    for arg in term.args[: 1 if term.name in ("load", "torque") else 2]:
        if isinstance(arg, Object):
            if arg.name in layout.small:
                return True
        elif not isinstance(arg, Var) or arg.name not in names or names[arg.name] & layout.small:
            return True
    return False


def _named(problem: Problem) -> set[str]:
    """Objects that the goal or a rule mentions by name."""
    formulas = [problem.goal, *(r.condition for r in problem.rules.values())]
    formulas += [d.body for d in problem.derived.values()]
    found = {part.name for formula in formulas for part in parts(formula) if isinstance(part, Object)}
    for rule in problem.rules.values():
        for effect in effects_of(rule.effects):
            found |= {a.name for a in effect.literal.args if isinstance(a, Object)}
    return found


def _turnable(layout: Layout, objects: list[str]) -> bool:
    """Whether the two ends of a module stand for each other in every rule."""
    if len(objects) != 3:
        return False
    first, second = layout.problem.world.modules[objects[0]].type.effectors
    alike = first.type == second.type and is_reversible(layout.problem.world.modules[objects[0]].type)
    return alike and _invariant(layout, {objects[1]: objects[2], objects[2]: objects[1]})


def renamed_action(action: Action, names: Mapping[str, str]) -> Action:
    """The action with other names for modules and ends."""

    def renamed(value: Value) -> Value:
        if isinstance(value, Chain):
            return Chain(tuple((names.get(m, m), names.get(a, a), names.get(b, b)) for m, a, b in value.modules))
        return names.get(value, value) if isinstance(value, str) else value

    return Action(action.rule, tuple(map(renamed, action.args)))


Linked = tuple[list[Fact], dict[str, list[tuple[int, str]]]]
"""The links that hold, and for each object its neighbours by them."""


class Renaming:
    """Sorts interchangeable modules, and their ends, by what holds of them and of what they are linked to."""

    def __init__(self, layout: Layout, groups: list[list[str]]) -> None:
        self.layout = layout
        problem = layout.problem
        self.groups = [[_objects(problem, name) for name in group] for group in groups]
        self.objects = [o for group in self.groups for module in group for o in module]
        self.turnable = [_turnable(layout, group[0]) for group in self.groups]
        mine = set(self.objects)
        self.places: dict[str, list[tuple[str, int, int]]] = {o: [] for o in self.objects}
        cleared = 0
        self.pairs: list[tuple[int, Fact]] = []
        for fact, bit in layout.flags.items():
            if len(fact) == 2 and fact[1] in mine:
                self.places[fact[1]].append((fact[0], bit.bit_length() - 1, 1))
            elif len(fact) == 3 and (fact[1] in mine or fact[2] in mine):
                self.pairs.append((bit, fact))
            else:
                continue
            cleared |= bit
        for (predicate, key), place in layout.fields.items():
            if key in mine:
                self.places[key].append((predicate, place.shift, place.mask))
                cleared |= place.mask << place.shift
        self.kept = ~cleared
        self.pair_mask = 0
        for bit, _ in self.pairs:
            self.pair_mask |= bit
        self._shapes: dict[int, dict[str, int]] = {}
        """Colours by the flags alone: they come first, so that few flag words stand for all."""
        self._links: dict[int, Linked] = {}
        self._alone: dict[tuple[int, tuple[tuple[int, ...], ...]], list[int]] = {}
        """Colours of modules without links, by the number of steps and what holds of them."""
        self._known: dict[int, int] = {}

    def canonical(self, state: int) -> int:
        """The renamed state that stands for all that are the same but for names."""
        found = self._known.get(state)
        if found is None:
            found = self._known[state] = self._canonical(state)
        return found

    def names(self, state: int) -> dict[str, str]:
        """What each module and end of the state is called in `canonical(state)`."""
        return self._named(state, self._values(state), self._linked(state))

    def renamed(self, state: int) -> tuple[int, dict[str, str]]:
        """Both at once."""
        values, links = self._values(state), self._linked(state)
        names = self._named(state, values, links)
        return self._called(state, names, values, links), names

    def _values(self, state: int) -> dict[str, tuple[int, ...]]:
        return {o: tuple([state >> shift & mask for _, shift, mask in self.places[o]]) for o in self.objects}

    def _linked(self, state: int) -> Linked:
        word = state & self.pair_mask
        known = self._links.get(word)
        if known is None:
            facts = [fact for bit, fact in self.pairs if word & bit]
            around: dict[str, list[tuple[int, str]]] = {o: [] for o in self.objects}
            for fact in facts:
                symmetric = self.layout.problem.predicates[fact[0]].symmetric
                for k, (here, there) in enumerate(((fact[1], fact[2]), (fact[2], fact[1]))):
                    if here in around:
                        around[here].append((0 if symmetric else k, there))
            known = self._links[word] = facts, around
        return known

    def _named(self, state: int, values: Mapping[str, tuple[int, ...]], links: Linked) -> dict[str, str]:
        flags = state & self.layout.flag_mask
        shape = self._shapes.get(flags)
        if shape is None:
            bare = {o: tuple([flags >> shift & mask for _, shift, mask in self.places[o]]) for o in self.objects}
            shape = self._shapes[flags] = self._colours(bare, links)
        colours = self._colours(values, links)
        return self._order({o: (shape[o], colours[o]) for o in self.objects})

    def _canonical(self, state: int) -> int:
        return self.renamed(state)[0]

    def _called(
        self, state: int, names: Mapping[str, str], values: Mapping[str, tuple[int, ...]], links: Linked
    ) -> int:
        renamed = state & self.kept
        for old, new in names.items():
            for value, (_, shift, _) in zip(values[old], self.places[new], strict=True):
                renamed |= value << shift
        for fact in links[0]:
            pair = (fact[0], names.get(fact[1], fact[1]), names.get(fact[2], fact[2]))
            renamed |= self.layout.flags[self.layout.canonical(pair)]
        return renamed

    def _colours(self, values: Mapping[str, tuple[int, ...]], links: Linked) -> dict[str, int]:
        """A number per object that depends on what holds of it and, step by step, of its neighbours."""
        facts, around = links
        steps = min(len(facts), len(self.objects)) + 1
        colours: dict[str, int] = {}
        linked: list[list[str]] = []
        for group in self.groups:
            for module in group:
                if any(around[o] for o in module):
                    linked.append(module)
                    continue
                key = (steps, tuple([values[o] for o in module]))
                alone = self._alone.get(key)
                if alone is None:
                    found = self._refined([module], {o: hash(values[o]) for o in module}, around, steps)
                    alone = self._alone[key] = [found[o] for o in module]
                colours.update(zip(module, alone, strict=True))
        together = {o: hash(values[o]) for module in linked for o in module}
        return colours | self._refined(linked, together, around, steps)

    def _refined(
        self, modules: Sequence[list[str]], colours: dict[str, int],
        around: Mapping[str, list[tuple[int, str]]], steps: int,
    ) -> dict[str, int]:  # fmt: skip
        """Colours after so many steps to neighbours; modules of no group, which keep their names, count as 0."""
        for _ in range(steps if modules else 0):
            fresh = {}
            for module in modules:
                whole = hash(tuple(sorted([colours[o] for o in module])))
                for o in module:
                    near = sorted([hash((k, colours.get(there, 0))) for k, there in around[o]])
                    fresh[o] = hash((colours[o], whole, tuple(near)))
            colours = fresh
        return colours

    def _order(self, colours: Mapping[str, tuple[int, int]]) -> dict[str, str]:
        names: dict[str, str] = {}
        for group, turnable in zip(self.groups, self.turnable, strict=True):
            sides = []
            for module in group:
                ends = module[1:]
                if turnable and colours[ends[1]] < colours[ends[0]]:
                    ends = [ends[1], ends[0]]
                sides.append((colours[module[0]], [colours[e] for e in ends], [module[0], *ends]))
            sides.sort(key=lambda side: side[:2])
            for (_, _, old), new in zip(sides, group, strict=True):
                names.update(zip(old, new, strict=True))
        return names
