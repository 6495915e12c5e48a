"""Chains as parameters of actions: a chain of so many modules is a line of ends, two for each module.

Modules are told apart only by what a chain can be asked for: their type, how far they reach, how thick their ends are.
So there are as many actions as lengths, not as many as chains.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import permutations, product
from typing import Any

from ...langs.diagnostics import UsageError
from ...langs.frozen import dataclass
from ...langs.trees import mapped
from ..ir import (
    Chain,
    ChainEnd,
    ChainModule,
    ChainType,
    Compare,
    Exists,
    Forall,
    Formula,
    Function,
    Literal,
    Not,
    Number,
    Object,
    ObjectType,
    RangeType,
    Var,
    Variable,
)
from .algebra import Environment, Undefined, conjunction, disjunction
from .guards import Guards
from .normal_form import FALSE, substitute
from .settings import SYMBOLIC

BY_THING = ("distance", "stride", "load", "torque")
"""Functions whose value depends on which end is meant, not only on what modules are like it."""


@dataclass(frozen=True, slots=True)
class ModulePassage:
    """Modules of one kind walked through in one way: `relation` holds of each pair of ends by which one is entered and
    left. `kind` is the module type, `owned` whether a module of it has more than two ends."""

    relation: str
    kind: str
    pairs: tuple[tuple[str, str, str], ...]
    owned: bool


@dataclass(frozen=True, slots=True)
class LiftedChain:
    """A chain variable of which only the passages are known, and the parameters for the ends of each module. `sample`
    is such a chain, for what depends on no more."""

    type: ChainType
    passages: tuple[ModulePassage, ...]
    ends: tuple[tuple[str, str], ...]
    sample: Chain

    def part(self, index: int, side: str) -> Var:
        """The parameter for an end. Raises Undefined, and UsageError for a module itself."""
        if not 1 <= index <= len(self.passages):
            raise Undefined
        if not side:
            raise UsageError("PDDL has the ends of a chain, not its modules")
        return Var(self.ends[index - 1][("in", "out").index(side)])

    def holds(self, others: Sequence[str]) -> Iterator[Formula]:
        """What says that it is a chain: its links are there, and its ends are linked to none of `others`."""
        for passage, pair in zip(self.passages, self.ends, strict=True):
            yield Literal(passage.relation, tuple(map(Var, pair)))
        for (_, leave), (enter, _) in zip(self.ends, self.ends[1:], strict=False):
            yield Literal(self.type.predicate, (Var(leave), Var(enter)))
        for end in (self.ends[0][0], self.ends[-1][1]):
            yield from (Not(Literal(self.type.predicate, (Var(end), Object(other)))) for other in others)
        if any(passage.owned for passage in self.passages):
            for k, (enter, _) in enumerate(self.ends):
                yield from (Compare("!=", Var(enter), Var(name)) for pair in self.ends[:k] for name in pair)

    def values(self, text: str) -> dict[str, str] | None:
        """What the parameters are for a chain as plans write it; None where it has another length."""
        words = text.strip("[]").split()
        names = [name for pair in self.ends for name in pair]
        return dict(zip(names, words, strict=True)) if len(words) == len(names) else None


@dataclass(frozen=True, slots=True)
class LiftedRule:
    """A rule whose chains are parameters: `same` are variables that are an end of a chain, by the parameter that they
    stand for, `large` those that stay parameters, with what they may denote."""

    conjuncts: Sequence[Formula]
    chains: Mapping[str, LiftedChain]
    same: Mapping[str, str]
    domains: Mapping[str, frozenset[str]]
    large: Sequence[Variable]


class ChainLifting:
    """The lifted chains of a problem."""

    def __init__(self, guards: Guards) -> None:
        self.guards, self.problem = guards, guards.problem
        self._passages: dict[str, tuple[ModulePassage, ...]] = {}
        self.relations: dict[str, ModulePassage] = {}

    def choices(self, variables: Sequence[Variable]) -> Iterator[dict[str, LiftedChain]]:
        """All ways to say of how many modules, and of which, chains are. Raises UsageError where they are too many."""
        for count, found in enumerate(self._choices(variables, {})):
            if count >= SYMBOLIC.pddl_chains:
                raise UsageError("PDDL needs an action for each kind of chain, and the modules could form too many")
            yield found

    def _choices(
        self, variables: Sequence[Variable], known: dict[str, LiftedChain]
    ) -> Iterator[dict[str, LiftedChain]]:
        if not variables:
            yield known
            return
        first, *rest = variables
        assert isinstance(first.type, ChainType)
        for line in self._lines(first.type):
            others = [p.kind for chain in known.values() for p in chain.passages]
            if Counter([*others, *(p.kind for p in line)]) <= self._modules(first.type):
                ends = tuple((f"{first.name}`{k}i", f"{first.name}`{k}o") for k in range(1, len(line) + 1))
                chain = LiftedChain(first.type, line, ends, _sample(line))
                yield from self._choices(rest, {**known, first.name: chain})
            else:
                for chain in self._again(first.type, line, list(known.values())):
                    yield from self._choices(rest, {**known, first.name: chain})

    def _lines(self, kind: ChainType) -> Iterator[tuple[ModulePassage, ...]]:
        passages = self._of(kind)
        modules = self._modules(kind)
        for size in range(1, sum(modules.values()) + 1):
            for line in product(passages, repeat=size):
                if Counter(p.kind for p in line) <= modules:
                    yield line

    def _modules(self, kind: ChainType) -> Counter[str]:
        world = self.problem.world.modules
        return Counter(world[m].type.name for m in self.problem.of_type(kind.element) if m in world)

    def _again(
        self, kind: ChainType, line: tuple[ModulePassage, ...], known: Sequence[LiftedChain]
    ) -> Iterator[LiftedChain]:
        """A chain for which there are modules only where it is one of those that are known, from the same end or from
        the other."""
        for chain in known:
            if chain.type != kind:
                continue
            if chain.passages == line:
                yield chain
            if all(_turned(one, other) for one, other in zip(chain.passages[::-1], line, strict=False)) and len(
                chain.passages
            ) == len(line):
                ends = tuple((leave, enter) for enter, leave in chain.ends[::-1])
                yield LiftedChain(kind, line, ends, _sample(line))

    def _of(self, kind: ChainType) -> tuple[ModulePassage, ...]:
        if kind.element not in self._passages:
            found: dict[tuple[Any, ...], list[tuple[str, str, str]]] = {}
            many: dict[str, bool] = {}
            for name in self.problem.of_type(kind.element):
                module = self.problem.world.modules.get(name)
                if module is None:
                    continue
                ends = [f"{name}.{e.name}" for e in module.type.effectors]
                many[module.type.name] = len(ends) > 2
                for enter, leave in permutations(ends, 2):
                    found.setdefault(self._like(module.type.name, enter, leave), []).append((name, enter, leave))
            made = []
            for like, pairs in found.items():
                passage = ModulePassage(f"`way_{len(self.relations) + 1}", like[0], tuple(pairs), many[like[0]])
                self.relations[passage.relation] = passage
                made.append(passage)
            self._passages[kind.element] = tuple(made)
        return self._passages[kind.element]

    def _like(self, kind: str, enter: str, leave: str) -> tuple[Any, ...]:
        geometry = self.guards.geometry
        radii = [float(geometry.radius(geometry.index[end])) for end in (enter, leave)]
        return (kind, float(geometry.reach(enter, leave)), *radii)

    # --- formulas ------------------------------------------------------------------------------------------------

    def lift(self, part: Any, chains: Mapping[str, LiftedChain], env: Environment) -> Any:
        """A formula or term in which the ends of chains are parameters; ranges within it are written out, as they may
        count the modules of a chain. Raises Undefined of a term past the end of a chain."""
        if not chains:
            return part
        match part:
            case ChainEnd() if part.chain in chains:
                chain = chains[part.chain]
                return chain.part(len(chain.passages) if part.last else 1, "out" if part.last else "in")
            case ChainModule() if part.chain in chains:
                index = self.guards.resolve(self.lift(part.index, chains, env), env)
                if not isinstance(index, Number):
                    raise UsageError("PDDL cannot count the modules of a chain by what is not known")
                return chains[part.chain].part(round(index.value), part.side)
            case Function() if part.name not in BY_THING:
                return part
            case Literal() | Compare():
                try:
                    return mapped(part, lambda inner: self.lift(inner, chains, env))
                except Undefined:
                    return FALSE
            case Exists() | Forall() if any(isinstance(v.type, RangeType) for v in part.variables):
                return self._written_out(part, chains, env)
            case _:
                return mapped(part, lambda inner: self.lift(inner, chains, env))

    def _written_out(
        self, formula: Exists | Forall, chains: Mapping[str, LiftedChain], env: Environment
    ) -> Formula:
        ranges = [v for v in formula.variables if isinstance(v.type, RangeType)]
        others = tuple(v for v in formula.variables if v not in ranges)
        bodies = []
        for inner in self.guards.assignments(ranges, env):
            numbers = {v.name: inner[v.name] for v in ranges}
            body = self.guards.reduce(self.lift(formula.body, chains, inner), {**numbers}, None)
            bodies.append(type(formula)(others, body) if others else body)
        return conjunction(bodies) if isinstance(formula, Forall) else disjunction(bodies)


def _turned(one: ModulePassage, other: ModulePassage) -> bool:
    """Whether one passage is the other, walked the other way."""
    module, enter, leave = one.pairs[0]
    return (module, leave, enter) in other.pairs


def ends_of(chains: Mapping[str, LiftedChain]) -> list[Variable]:
    """The parameters for the ends of chains, each once."""
    names = dict.fromkeys(name for chain in chains.values() for pair in chain.ends for name in pair)
    return [Variable(name, ObjectType("effector")) for name in names]


def _sample(line: Sequence[ModulePassage]) -> Chain:
    """A chain of such passages, of different modules as far as there are such."""
    used: set[str] = set()
    found = []
    for passage in line:
        chosen = next((pair for pair in passage.pairs if pair[0] not in used), passage.pairs[0])
        used.add(chosen[0])
        found.append(chosen)
    return Chain(tuple(found))


def ends_named(
    conjuncts: Sequence[Formula], chains: Mapping[str, LiftedChain], domains: Mapping[str, frozenset[str]]
) -> tuple[dict[str, str], list[Formula]]:
    """Variables of a rule that equal an end of a chain, by the parameter for that, and the conditions with these."""
    ends = {v.name for v in ends_of(chains)}
    same: dict[str, str] = {}
    for formula in conjuncts:
        if not isinstance(formula, Compare) or formula.operator != "=":
            continue
        for one, other in ((formula.left, formula.right), (formula.right, formula.left)):
            if isinstance(one, Var) and isinstance(other, Var) and one.name in domains and other.name in ends:
                same.setdefault(one.name, other.name)
    renaming = {name: Var(other) for name, other in same.items()}
    found = [substitute(formula, renaming) for formula in conjuncts]
    return same, [f for f in found if not (isinstance(f, Compare) and f.operator == "=" and f.left == f.right)]
