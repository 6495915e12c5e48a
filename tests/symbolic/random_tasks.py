"""Small random tasks as text: every kind of predicate, condition and effect that the language has.

`compiled(seed)` gives the problem of a seed; the text is the same for ever. Scenes are small enough that all states of
many of them can be visited, and lengths differ clearly from the bounds that they are compared with.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_text
from tamplang.langs.diagnostics import SourceError

MODULES = """module stub() {
    effector A: effector sphere(5 cm)
    joint j: revolute(z) in -1 rad .. 1 rad
    link 30 cm: capsule(2 cm)
    effector B: effector sphere(5 cm)
}
module rod() {
    effector A: effector sphere(5 cm)
    joint j: revolute(z) in -1 rad .. 1 rad
    link 50 cm: capsule(2 cm)
    effector B: effector sphere(5 cm)
}
motion [near X Y: object] symmetric { at switch gap(X, Y) <= 100 m }
motion [below X Y: object] { at switch bottom(X) <= top(Y) + 100 m }
"""
BELOW = {
    "object": ("object", "thing", "spot", "effector"),
    "thing": ("thing", "spot"),
    "spot": ("spot",),
    "effector": ("effector",),
    "module": ("module",),
}
"""The types whose objects fit a parameter of a type."""
MOST_TRIES = 60
"""Texts that are wrong for a reason (a goal that nothing reaches) are drawn anew at most so often."""


@dataclass(frozen=True)
class Declared:
    """A predicate and what stands behind its parameters."""

    name: str
    types: tuple[str, ...]
    static: bool = False
    symmetric: bool = False
    functional: int | None = None
    derived: bool = False

    def text(self) -> str:
        parameters = ", ".join(f"X{k}: {t}" for k, t in enumerate(self.types))
        if self.symmetric:
            parameters = f"X0 X1: {self.types[0]}"
        flags = [" static"] * self.static + [" symmetric"] * self.symmetric
        if self.functional is not None:
            flags.append(f" functional in X{self.functional}")
        return f"predicate ({' '.join([self.name, parameters]).strip()}){''.join(flags)}"


@dataclass
class Scope:
    """The terms in sight by type; chains and numbers apart."""

    terms: dict[str, list[str]] = field(default_factory=dict)
    chains: list[str] = field(default_factory=list)
    numbers: list[str] = field(default_factory=list)

    def fitting(self, kind: str) -> list[str]:
        return [term for below in BELOW[kind] for term in self.terms.get(below, ())]

    def inner(self) -> Scope:
        return Scope({t: [*names] for t, names in self.terms.items()}, [*self.chains], [*self.numbers])


class Draw:
    """One text."""

    def __init__(self, seed: str) -> None:
        self.chance = random.Random(seed)
        self.modules = self.chance.choice([0, 1, 1, 2, 2])
        self.objects = {"thing": ["a", "b"], "spot": ["s", "t"]}
        self.objects = {kind: names[: self.chance.randint(1, 2)] for kind, names in self.objects.items()}
        self.objects["module"] = [f"m[{k}]" for k in range(1, self.modules + 1)]
        self.objects["effector"] = [f"{m}.{end}" for m in self.objects["module"] for end in "AB"]
        self.names = 0
        self.predicates = [self.predicate(f"p{k}") for k in range(self.chance.randint(3, 5))]
        if self.modules:
            self.predicates.append(Declared("linked", ("effector", "effector"), symmetric=True))
        self.fluents = [p for p in self.predicates if not p.static]
        self.readable = [*self.predicates]
        self.derivations = [self.derivation(f"d{k}") for k in range(self.chance.randint(0, 2))]

    def likely(self, share: float) -> bool:
        return self.chance.random() < share

    def fresh(self, stem: str) -> str:
        self.names += 1
        return f"{stem}{self.names}"

    # --- declarations --------------------------------------------------------------------------------------------

    def predicate(self, name: str) -> Declared:
        kinds = ["thing", "spot", "thing", "object"] + ["effector", "module", "effector"] * (self.modules > 0)
        count = 0 if name == "p0" else self.chance.choice([1, 1, 2, 2, 2, 2, 3])
        types = tuple(self.chance.choice(kinds) for _ in range(count))
        symmetric = count == 2 and self.likely(0.35)
        if symmetric:
            types = types[:1] * 2
        functional = self.chance.randrange(count) if count and self.likely(0.45) else None
        return Declared(name, types, name != "p0" and self.likely(0.15), symmetric, functional)

    def derivation(self, name: str) -> str:
        count = self.chance.randint(0, 2)
        kinds = [t for t, found in self.objects.items() if found]
        declared = Declared(name, tuple(self.chance.choice(kinds) for _ in range(count)), derived=True)
        scope = Scope()
        shown = []
        for kind in declared.types:
            variable = self.fresh("D")
            scope.terms.setdefault(kind, []).append(variable)
            shown.append(f"{variable}: {kind}")
        body = self.formula(scope, 3)
        self.readable.append(declared)
        return f"derived ({' '.join([name, ', '.join(shown)]).strip()}) = {body}"

    def variable(self, scope: Scope) -> str:
        """Bind one more variable; its declaration."""
        choice = self.chance.random()
        if choice < 0.12 and self.modules:
            name = self.fresh("c")
            scope.chains.append(name)
            for end in ("first", "last"):
                scope.terms.setdefault("effector", []).append(f"{name}.{end}")
            return f"{name}: chain of {self.chance.choice(['module', 'module', 'stub'])} by linked"
        if choice < 0.2:
            name = self.fresh("k")
            scope.numbers.append(name)
            last = "2"
            if scope.chains:
                chain = scope.chains[-1]
                last = f"length({chain})"
                scope.terms.setdefault("effector", []).extend([f"{chain}[{name}].in", f"{chain}[{name}].out"])
                scope.terms.setdefault("module", []).append(f"{chain}[{name}]")
            return f"{name}: 1 .. {last}"
        kind = self.chance.choice([t for t, found in self.objects.items() if found] + ["object"])
        name = self.fresh("X")
        scope.terms.setdefault(kind, []).append(name)
        return f"{name}: {kind}"

    # --- conditions ----------------------------------------------------------------------------------------------

    def literal(self, scope: Scope, among: Sequence[Declared], any_share: float = 0.0) -> str | None:
        for _ in range(6):
            predicate = self.chance.choice(among)
            args = []
            for kind in predicate.types:
                fitting = scope.fitting(kind)
                if self.likely(any_share):
                    args.append("ANY")
                elif fitting:
                    args.append(self.chance.choice(fitting))
            if len(args) == len(predicate.types):
                return f"({' '.join([predicate.name, *args])})"
        return None

    def comparison(self, scope: Scope) -> str | None:
        kind = self.chance.choice(list(BELOW))
        fitting, shaped = scope.fitting(kind), scope.fitting("object")
        options = []
        if scope.chains:
            options.append(f"length({self.chance.choice(scope.chains)}) {self.chance.choice(['>=', '<', '=', '!='])} 2")
        if scope.numbers:
            options.append(f"{self.chance.choice(scope.numbers)} {self.chance.choice(['<=', '>', '='])} 1")
        if len(fitting) >= 2:
            one, other = self.chance.sample(fitting, 2)
            options.append(f"{one} {self.chance.choice(['=', '!='])} {other}")
        if len(shaped) >= 2:
            one, other = self.chance.sample(shaped, 2)
            bound = self.chance.choice(["1.7 m", "2.6 m", "20 m"])
            options.append(f"distance({one}, {other}) {self.chance.choice(['<=', '<', '>'])} {bound}")
        return self.chance.choice(options) if options else None

    def formula(self, scope: Scope, depth: int) -> str:
        choice = self.chance.random()
        if depth > 0 and choice < 0.2:
            inner = scope.inner()
            variables = ", ".join(self.variable(inner) for _ in range(self.chance.randint(1, 2)))
            return f"{self.chance.choice(['exists', 'forall'])} {variables} {{ {self.formula(inner, depth - 1)} }}"
        if depth > 0 and choice < 0.4:
            join = self.chance.choice([" and ", " or "])
            return f"({join.join(self.formula(scope, depth - 1) for _ in range(2))})"
        if depth > 0 and choice < 0.55:
            return f"not ({self.formula(scope, depth - 1)})"
        if choice > 0.85:
            return self.comparison(scope) or "(p0)"
        return self.literal(scope, self.readable) or "(p0)"

    # --- rules ---------------------------------------------------------------------------------------------------

    def effects(self, scope: Scope, depth: int) -> list[str]:
        found = []
        for _ in range(self.chance.randint(1, 3)):
            choice = self.chance.random()
            if depth and choice < 0.15:
                inner = ", ".join(self.effects(scope, depth - 1))
                found.append(f"if {self.formula(scope, 1)} {{ {inner} }}")
            elif depth and choice < 0.28:
                bound = scope.inner()
                variable = self.variable(bound)
                if ": chain" not in variable:
                    found.append(f"forall {variable} {{ {', '.join(self.effects(bound, depth - 1))} }}")
            elif choice < 0.4:
                found += filter(None, [self.motion(scope)])
            elif choice < 0.67:
                found.append(f"not {self.literal(scope, self.fluents, 0.3) or '(p0)'}")
            else:
                literal = self.literal(scope, self.fluents)
                found += [literal] if literal else []
        return found or ["(p0)"]

    def motion(self, scope: Scope) -> str | None:
        """A motion literal, added or deleted."""
        name, fitting = self.chance.choice(["near", "below"]), scope.fitting("object")
        if not fitting:
            return None
        if self.likely(0.6):
            return f"[{name} {self.chance.choice(fitting)} {self.chance.choice(fitting)}]"
        return f"not [{name} {self.chance.choice([*fitting, 'ANY'])} {self.chance.choice([*fitting, 'ANY'])}]"

    def rule(self, number: int) -> str:
        scope = Scope()
        parameters = [self.variable(scope) for _ in range(self.chance.randint(1, 3))]
        pre = [self.formula(scope, self.chance.randint(0, 2)) for _ in range(self.chance.randint(0, 2))]
        numbers = ["2", "0.5", "1", "3"]
        cost = self.chance.choice(numbers)
        comparison = self.comparison(scope)
        if comparison and self.likely(0.5):
            cost = f"if {comparison} then {self.chance.choice(numbers)} else {self.chance.choice(numbers)}"
        lines = [f"rule r{number}({', '.join(parameters)}) {{"]
        lines += [f"    pre  {', '.join(pre)}"] * bool(pre)
        lines += [f"    post {', '.join(self.effects(scope, 2))}"]
        lines += [f"    cost {cost}"] * self.likely(0.5)
        return "\n".join([*lines, "}"])

    # --- the task ------------------------------------------------------------------------------------------------

    def facts(self) -> Iterator[str]:
        scope = Scope({kind: [*names] for kind, names in self.objects.items()})
        used: set[tuple[str, str]] = set()
        for _ in range(self.chance.randint(2, 7)):
            predicate = self.chance.choice(self.predicates)
            literal = self.literal(scope, [predicate])
            if literal is None or predicate.name == "linked":
                continue
            args = literal[1:-1].split()[1:]
            keys = set() if predicate.functional is None else {(predicate.name, args[predicate.functional])}
            if predicate.symmetric and keys:
                keys = {(predicate.name, name) for name in args}
            if not keys & used:
                used |= keys
                yield f"    fact {literal}"

    def text(self) -> str:
        kinds = {"thing": "thing", "spot": "spot"}
        bodies = [(kinds[kind], name) for kind in kinds for name in self.objects[kind]]
        rules = [self.rule(k) for k in range(self.chance.randint(2, 4))]
        lines = ["type thing < object", "type spot < thing", MODULES]
        lines += [*(p.text() for p in self.predicates), *self.derivations, *rules, "task t() {"]
        lines += [f"    {kind} {name}: sphere(5 cm) at ({k} m, 0, 0)" for k, (kind, name) in enumerate(bodies)]
        for k, name in enumerate(self.objects["module"]):
            lines.append(f"    {self.chance.choice(['stub', 'stub', 'rod'])} {name}: at ({k} m, 3 m, 0)")
        lines += [*self.facts()]
        scope = Scope({kind: [*names] for kind, names in self.objects.items()})
        goals = [self.formula(scope, 2) for _ in range(self.chance.randint(1, 2))]
        return "\n".join([*lines, f"    goal {', '.join(goals)}", "}", ""])


@cache
def task_text(seed: int) -> str:
    """The text of a task that compiles."""
    return _drawn(seed)[0]


@cache
def compiled(seed: int) -> Problem:
    """The problem of `task_text`."""
    return _drawn(seed)[1]


@cache
def _drawn(seed: int) -> tuple[str, Problem]:
    for attempt in range(MOST_TRIES):
        text = Draw(f"{seed}/{attempt}").text()
        try:
            return text, compile_text(text)[0]
        except SourceError:
            continue
    raise AssertionError(f"no task of seed {seed} compiles")
