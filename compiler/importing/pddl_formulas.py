"""PDDL's conditions and effects as text of this language."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import field

from ...langs.diagnostics import did_you_mean
from ...langs.frozen import dataclass
from .names import NO_PREDICATES, GivenNames
from .nodes import Faults, Group, Node, Token
from .pddl_tables import Tables, TypedWord, known_type, typed

NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?")
_REFUSED = ("preference", "always", "sometime", "within", "at-most-once", "sometime-after", "sometime-before",
            "hold-during", "hold-after", "always-within", "at", "over")  # fmt: skip
_NUMERIC = ("<", ">", "<=", ">=")
_CHANGES = ("increase", "decrease", "assign", "scale-up", "scale-down")
COST = "total-cost"


@dataclass(slots=True)
class Vocabulary:
    """What a translation goes by, and what it finds out: how far predicates reach, which ones rules change,
    which functions are `priced`, that is, used by costs. Those that are `partial` have no value for some objects."""

    tables: Tables
    types: GivenNames = field(default_factory=GivenNames)
    predicates: GivenNames = field(default_factory=lambda: GivenNames(words=NO_PREDICATES))
    functions: GivenNames = field(default_factory=GivenNames)
    objects: GivenNames = field(default_factory=GivenNames)
    rules: GivenNames = field(default_factory=GivenNames)
    changed: set[str] = field(default_factory=set)
    derived: set[str] = field(default_factory=set)
    priced: set[str] = field(default_factory=set)
    partial: set[str] = field(default_factory=set)
    unions: dict[tuple[str, ...], tuple[str, str]] = field(default_factory=dict)
    """For each `either` that is asked for the type above all of it, and the predicate that holds of what is of it."""

    def union(self, types: tuple[str, ...], kind: str) -> str:
        """The predicate that holds of what is of one of `types`, of those of the type `kind`; empty where all are."""
        members = self.tables.members(types)
        if len(members) == len(self.tables.members((kind,))):
            return ""
        types = tuple(sorted(set(types)))
        if types not in self.unions:
            self.unions[types] = kind, self.predicates.fresh(f"is_{'_or_'.join(types)}")
        above, predicate = self.unions[types]
        self.unions[types] = self.tables.common((above, kind)), predicate
        return predicate

    def type_name(self, name: str) -> str:
        """A type in this language."""
        return "object" if name == "object" else self.types[name]


class Formulas:
    """Translates what one action, derived predicate or goal says. In a goal, `constants` are things of the scene; else
    each that is used becomes a variable of its own, listed in `used`. `asked` are conditions that costs add: that there
    is a value."""

    def __init__(self, faults: Faults, words: Vocabulary, scene: bool = False) -> None:
        self.faults, self.words, self.tables, self.scene = faults, words, words.tables, scene
        self.names = GivenNames(words.objects[o] for o in words.tables.objects) if scene else GivenNames()
        self.variables: dict[str, tuple[str, str]] = {}
        self.types: dict[str, tuple[str, ...]] = {}
        self.used: dict[str, str] = {}
        self.read: set[str] = set()
        self.asked: list[str] = []

    # --- variables -----------------------------------------------------------------------------------------------

    def bind(self, node: Node | None) -> list[tuple[str, str]]:
        """Names and types of a list of parameters, known from here on."""
        if not isinstance(node, Group):
            if node is not None:
                self.faults.tell("E0019", node, "expected parameters in brackets, such as `(?x - ball)`")
            return []
        return [self._bound(item) for item in typed(self.faults, node.items, variables=True)]

    def _bound(self, item: TypedWord) -> tuple[str, str]:
        if item.name in self.variables:
            self.faults.tell("E0022", item.word, f"`{item.name}` is bound twice")
        kind = known_type(self.tables, self.faults, item)
        name = self.names.fresh(item.name[1:])
        self.variables[item.name] = name, kind
        self.types[name] = item.types
        return name, kind

    def asks(self, parameters: Iterable[tuple[str, str]]) -> list[str]:
        """What has to hold of variables that are of `either` of several types."""
        found = [(self.words.union(self.types[name], kind), name) for name, kind in parameters]
        return [f"({predicate} {name})" for predicate, name in found if predicate]

    def shown(self, parameters: Iterable[tuple[str, str]]) -> str:
        """Parameters as this language writes them, those of one type together."""
        groups: list[tuple[str, list[str]]] = []
        for name, kind in parameters:
            if not groups or groups[-1][0] != kind:
                groups.append((kind, []))
            groups[-1][1].append(name)
        return ", ".join(f"{' '.join(names)}: {self.words.type_name(kind)}" for kind, names in groups)

    def term(self, node: Node) -> tuple[str, str]:
        """A variable or object, and its type."""
        if isinstance(node, Group):
            self.faults.tell("E0020", node, f"`({node.head} …)` is no name: functions have no place among arguments")
        elif node.text.startswith("?"):
            if node.text in self.variables:
                return self.variables[node.text]
            self.faults.unknown(node, "variable", list(self.variables))
        elif node.text not in self.tables.objects:
            self.faults.unknown(node, "object", list(self.tables.objects))
        elif self.scene:
            return self.words.objects[node.text], self.tables.objects[node.text]
        else:
            if node.text not in self.used:
                self.used[node.text] = self.names.fresh(node.text)
            return self.used[node.text], self.tables.objects[node.text]
        return "unknown", "object"

    # --- conditions ----------------------------------------------------------------------------------------------

    def conjuncts(self, node: Node) -> list[str]:
        """A condition as the parts of a conjunction."""
        if isinstance(node, Group) and node.head == "and":
            return [part for item in node.rest for part in self.conjuncts(item)]
        if isinstance(node, Group) and not node.items:
            return []
        return [self.condition(node)]

    def condition(self, node: Node) -> str:
        """A condition, in brackets of its own where it has parts."""
        if isinstance(node, Token) or (node.items and not node.head):
            self.faults.tell("E0019", node, "expected a condition in brackets, such as `(at ?x ?y)`")
            return "(unknown)"
        if node.head in ("and", "or", ""):
            parts = [self.condition(item) for item in node.rest]
            if not parts:
                return "1 = 2" if node.head == "or" else "1 = 1"
            return parts[0] if len(parts) == 1 else f"({f' {node.head} '.join(parts)})"
        if node.head == "not":
            return self._denied(self._parts(node, 1)[0])
        if node.head == "imply":
            left, right = self._parts(node, 2)
            return f"({self._denied(left)} or {self.condition(right)})"
        if node.head in ("exists", "forall"):
            return self._quantified(node)
        if node.head == "=":
            left, right = self._parts(node, 2)
            if any(isinstance(side, Group) or NUMBER.fullmatch(side.text) for side in (left, right)):
                self.faults.tell("E0020", node, "numbers have no counterpart in conditions")
                return "1 = 1"
            return f"{self.term(left)[0]} = {self.term(right)[0]}"
        return self.literal(node)

    def _denied(self, node: Node) -> str:
        text = self.condition(node)
        if isinstance(node, Group) and node.head == "=":
            return text.replace(" = ", " != ")
        return f"not {text}" if text.startswith(("(", "exists", "forall")) else f"not ({text})"

    def _parts(self, node: Group, count: int) -> Sequence[Node]:
        if len(node.rest) != count:
            self.faults.tell("E0019", node, f"`{node.head}` takes {count} parts, not {len(node.rest)}")
        return [*node.rest, *[Group(node.start, node.end)] * count][:count]

    def _quantified(self, node: Group) -> str:
        binders, body = self._parts(node, 2)
        before = self._enter(binders)
        parameters = self.bind(binders)
        inner = self.condition(body)
        asked = self.asks(parameters)
        if asked and node.head == "exists":
            inner = " and ".join([*asked, inner])
        elif asked:
            inner = " or ".join([*(f"not {literal}" for literal in asked), inner])
        self._leave(before, parameters)
        return f"{node.head} {self.shown(parameters)} {{ {inner} }}" if parameters else inner

    def _enter(self, binders: Node) -> dict[str, tuple[str, str]]:
        """The variables outside of a quantifier, whose own hide those of the same name."""
        before = dict(self.variables)
        for word in binders.items if isinstance(binders, Group) else ():
            self.variables.pop(word.text if isinstance(word, Token) else "", None)
        return before

    def _leave(self, before: dict[str, tuple[str, str]], parameters: Iterable[tuple[str, str]]) -> None:
        self.variables = before
        for name, _ in parameters:
            self.names.release(name)

    def literal(self, node: Group) -> str:
        """A literal, whose predicate reaches as far as its arguments."""
        known = self.tables.predicates
        if node.head in known:
            arguments = [self.term(item) for item in node.rest]
            self.read.add(node.head)
            if len(arguments) != len(known[node.head]):
                self.faults.tell("E0022", node, f"`{node.head}` takes {len(known[node.head])} arguments, not "
                                 f"{len(arguments)}")  # fmt: skip
            else:
                kinds = zip(known[node.head], (kind for _, kind in arguments), strict=True)
                known[node.head] = [self.tables.common(pair) for pair in kinds]
            return f"({' '.join([self.words.predicates[node.head], *(name for name, _ in arguments)])})"
        if node.head in _REFUSED or node.head in _NUMERIC:
            self.faults.tell("E0020", node, f"`{node.head}` has no counterpart here, so it cannot be imported")
        else:
            first = node.items[0]
            assert isinstance(first, Token)
            words = ["and", "or", "not", "imply", "exists", "forall", "when"]
            self.faults.unknown(first, "predicate", [*known, *words])
        return "(unknown)"

    # --- effects -------------------------------------------------------------------------------------------------

    def effects(self, node: Node, costs: list[str] | None) -> list[str]:
        """Effects; those on the total cost go to `costs`, where None allows none."""
        added: list[str] = []
        deleted: list[str] = []
        others: list[str] = []
        self._collect(node, (added, deleted, others), costs)
        lost = [f"not {literal}" for literal in dict.fromkeys(deleted) if literal not in added]
        return [*lost, *dict.fromkeys(added), *others]

    def _collect(self, node: Node, into: tuple[list[str], list[str], list[str]], costs: list[str] | None) -> None:
        if isinstance(node, Token) or (node.items and not node.head):
            self.faults.tell("E0019", node, "expected an effect in brackets, such as `(at ?x ?y)`")
        elif node.head in ("and", ""):
            for item in node.rest:
                self._collect(item, into, costs)
        elif node.head == "not":
            inner = self._parts(node, 1)[0]
            if isinstance(inner, Token) or inner.head in ("not", "and", "or", "forall", "exists", "when", "="):
                self.faults.tell("E0019", node, "an effect deletes a literal, such as `(not (at ?x ?y))`")
            else:
                into[1].append(self._change(inner))
        elif node.head == "when":
            condition, body = self._parts(node, 2)
            asked = " and ".join(self.conjuncts(condition)) or "1 = 1"
            if told := self.effects(body, None):
                into[2].append(f"if {asked} {{ {', '.join(told)} }}")
        elif node.head == "forall":
            self._for_all(node, into)
        elif node.head in _CHANGES:
            self._cost(node, costs)
        elif node.head in ("or", "exists", "imply", "oneof", "probabilistic", "="):
            self.faults.tell("E0020", node, f"`{node.head}` has no counterpart among effects")
        else:
            into[0].append(self._change(node))

    def _change(self, node: Group) -> str:
        read = set(self.read)
        text = self.literal(node)
        self.read = read
        self.words.changed.add(node.head)
        if node.head in self.words.derived:
            self.faults.tell("E0022", node, f"`{node.head}` is derived: no action can change it")
        return text

    def _for_all(self, node: Group, into: tuple[list[str], list[str], list[str]]) -> None:
        binders, body = self._parts(node, 2)
        before = self._enter(binders)
        parameters = self.bind(binders)
        told = self.effects(body, None)
        if told and (asked := self.asks(parameters)):
            told = [f"if {' and '.join(asked)} {{ {', '.join(told)} }}"]
        self._leave(before, parameters)
        if told:
            into[2].append(f"for {self.shown(parameters)} {{ {', '.join(told)} }}" if parameters else ", ".join(told))

    # --- costs ---------------------------------------------------------------------------------------------------

    def _cost(self, node: Group, costs: list[str] | None) -> None:
        target, value = self._parts(node, 2)
        name = target.head if isinstance(target, Group) else target.text
        if node.head != "increase" or name != COST:
            self.faults.tell("E0020", node, f"`({node.head} ({name}) …)` has no counterpart here: numbers other than "
                             "the total cost cannot change")  # fmt: skip
        elif costs is None:
            self.faults.tell("E0020", node, "a cost that depends on a condition has no counterpart here")
        else:
            costs.append(self.value(value))

    def value(self, node: Node) -> str:
        """A number, a function or a sum or product of them."""
        if isinstance(node, Token):
            if NUMBER.fullmatch(node.text) and not node.text.startswith("-"):
                return number(node.text)
            if node.text not in self.tables.functions:
                self.faults.tell("E0020", node, f"a cost is a number from 0 on, or a function, not `{node.text}`")
                return "0"
            node = Group(node.start, node.end, [node])
        if node.head in ("+", "*") and len(node.rest) > 1:
            return f"({f' {node.head} '.join(self.value(item) for item in node.rest)})"
        if node.head not in self.tables.functions or node.head == COST:
            self.faults.tell("E0022" if node.head else "E0019", node, f"unknown function `{node.head}`",
                             did_you_mean(node.head, self.tables.functions))  # fmt: skip
            return "0"
        arguments = [self.term(item) for item in node.rest]
        known = self.tables.functions[node.head]
        if len(arguments) != len(known):
            self.faults.tell("E0022", node, f"`{node.head}` takes {len(known)} arguments, not {len(arguments)}")
            return "0"
        self.tables.functions[node.head] = [
            self.tables.common(pair) for pair in zip(known, (kind for _, kind in arguments), strict=True)
        ]
        self.words.priced.add(node.head)
        names = [name for name, _ in arguments]
        if node.head in self.words.partial:
            self.asked.append(f"({' '.join([self.words.predicates[f'{node.head} known'], *names])})")
        return f"{self.words.functions[node.head]}({', '.join(names)})"


def number(text: str) -> str:
    """A number as this language writes it. Raises ValueError."""
    value = float(text)
    return f"{value:g}" if float(f"{value:g}") == value else repr(value)
