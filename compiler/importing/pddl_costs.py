"""Action costs of PDDL: what functions of objects are worth becomes facts, a predicate for each number."""

from __future__ import annotations

from collections.abc import Iterable
from math import prod

from .names import plain_name
from .nodes import Faults, Group, Token
from .pddl_formulas import COST, NUMBER, Formulas, Vocabulary, number
from .pddl_tables import PddlFile

MOST_IN_A_ROW = 40
"""How many numbers are asked for one behind the other; `if` may be nested 100 deep."""


def check_metric(problem: PddlFile) -> bool:
    """Whether plans are judged by their total cost. Other metrics are refused."""
    metric = problem.the(":metric")
    if metric is None:
        return False
    parts = metric.rest
    named = parts[1] if len(parts) == 2 else None
    name = named.head if isinstance(named, Group) else None if named is None else named.text
    way = parts[0].text if parts and isinstance(parts[0], Token) else None
    if way != "minimize" or name != COST:
        problem.faults.tell("E0020", metric, "only `(:metric minimize (total-cost))` has a counterpart here")
    return True


class Costs:
    """The values of functions at the start."""

    def __init__(self, words: Vocabulary, faults: Faults) -> None:
        self.words, self.faults = words, faults
        self.values: dict[str, dict[tuple[str, ...], str]] = {}

    def note(self, nodes: Iterable[Group]) -> None:
        """Values such as `(= (f a b) 3)`; that of the total cost counts from 0."""
        formulas = Formulas(self.faults, self.words, scene=True)
        for node in nodes:
            self._note(node, formulas)
        tables = self.words.tables
        kinds = tables.objects.values()
        sizes = {t: sum(t in tables.above(k) for k in kinds) for t in ("object", *tables.parents)}
        for name, parameters in tables.functions.items():
            if len(self.values.get(name, ())) < prod(sizes[kind] for kind in parameters):
                self.words.partial.add(name)

    def _note(self, node: Group, formulas: Formulas) -> None:
        rest = node.rest
        term = rest[0] if rest else None
        value = rest[1] if len(rest) == 2 and isinstance(rest[1], Token) else None
        if isinstance(term, Token):
            term = Group(term.start, term.end, [term])
        if term is None or value is None or not NUMBER.fullmatch(value.text):
            self.faults.tell("E0019", node, "expected a value such as `(= (distance a b) 3)`")
        elif term.head not in self.words.tables.functions:
            self.faults.tell("E0022", term, f"unknown function `{term.head}`")
        elif term.head != COST:
            arguments = tuple(formulas.term(a)[0] for a in term.rest)
            if len(arguments) != len(self.words.tables.functions[term.head]):
                self.faults.tell("E0022", term, f"`{term.head}` takes other arguments")
            elif value.text.startswith("-"):
                self.faults.tell("E0020", value, "costs below 0 have no counterpart here")
            else:
                self.values.setdefault(term.head, {})[arguments] = number(value.text)

    def facts(self) -> Iterable[str]:
        """What functions are worth."""
        for name in self._asked():
            for arguments, value in self.values.get(name, {}).items():
                if arguments:
                    yield f"fact ({' '.join([self._predicate(name, value), *arguments])})"

    def predicates(self) -> Iterable[str]:
        """A predicate for each function and number."""
        for name in self._asked():
            parameters = self._parameters(name)
            for value in self._numbers(name) if parameters else ():
                yield f"predicate ({self._predicate(name, value)} {parameters}) static"

    def functions(self) -> Iterable[str]:
        """The functions themselves, and where there is a value of those that have none for some objects."""
        for name in self._asked():
            if name in self.words.partial:
                arguments = self._arguments(name)
                options = [f"({self._predicate(name, value)} {arguments})" for value in self._numbers(name)]
                known = " ".join([self.words.predicates[f"{name} known"], self._parameters(name)]).strip()
                yield f"derived ({known}) = {' or '.join(options) or '1 = 2'}"
            yield f"function {self.words.functions[name]}({self._parameters(name)}) = {self._value(name)}"

    def _asked(self) -> list[str]:
        return [name for name in self.words.tables.functions if name in self.words.priced]

    def _numbers(self, name: str) -> list[str]:
        return list(dict.fromkeys(self.values.get(name, {}).values()))

    def _value(self, name: str) -> str:
        numbers = self._numbers(name)
        arguments = self._arguments(name)
        if not arguments:
            return numbers[0] if numbers else "0"
        asked = [(f"({self._predicate(name, value)} {arguments})", value) for value in numbers]
        if len(asked) <= MOST_IN_A_ROW:
            return " ".join([*(f"if {literal} then {value} else" for literal, value in asked), "0"])
        return _sum([f"(if {literal} then {value} else 0)" for literal, value in asked])

    def _arguments(self, name: str) -> str:
        return " ".join(f"x{k}" for k, _ in enumerate(self.words.tables.functions[name], 1))

    def _parameters(self, name: str) -> str:
        kinds = self.words.tables.functions[name]
        return Formulas(self.faults, self.words).shown((f"x{k}", kind) for k, kind in enumerate(kinds, 1))

    def _predicate(self, name: str, value: str) -> str:
        return self.words.predicates[f"{plain_name(name)} {value.replace('.', '_')}"]


def _sum(parts: list[str]) -> str:
    """A sum in brackets that are nested as little as can be: of each pair of objects one part counts."""
    if len(parts) == 1:
        return parts[0]
    half = len(parts) // 2
    return f"({_sum(parts[:half])} + {_sum(parts[half:])})"
