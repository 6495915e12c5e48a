"""Plans in the words of the PDDL export: which of its actions each action of a plan is, found by replaying it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ...langs.diagnostics import UsageError
from ..ir import Problem
from .pddl import PddlWriter
from .strips import Schema

Atom = tuple[str, ...]


def plan_lines(problem: Problem, actions: Sequence[tuple[str, Sequence[str]]]) -> list[str]:
    """One line `(action object …)` for each action, given as its rule and the values of its variables. Raises
    UsageError for what PDDL cannot say."""
    writer = PddlWriter(problem)
    state = {_atom(fact) for fact in writer.facts()}
    numbers: dict[str, list[tuple[int, Schema]]] = {}
    for number, schema in enumerate(writer.schemas):
        numbers.setdefault(schema.rule, []).append((number, schema))
    lines = []
    for rule, args in actions:
        names = [v.name for v in problem.rules[rule].variables]
        found = _step(writer, numbers.get(rule, []), dict(zip(names, args, strict=True)), state)
        if found is None:
            raise UsageError(f"PDDL has no action for {rule}({', '.join(args)})")
        state, line = found
        lines.append(line)
    if not writer.single:
        reached = _step(writer, list(enumerate(writer.goals)), {}, state)
        if reached is None:
            raise UsageError("the plan does not reach the goal")
        lines.append(reached[1])
    return lines


def _step(
    writer: PddlWriter, schemas: Sequence[tuple[int, Schema]], values: Mapping[str, str], state: set[Atom]
) -> tuple[set[Atom], str] | None:
    """The state after an action, and its line; None where none of the schemas fits."""
    for number, schema in schemas:
        bound = writer.bound(schema, values)
        if bound is None:
            continue
        binding = next(_bindings([_atom(c) for c in writer.conditions(schema)], bound, state), None)
        if binding is not None:
            deleted, added = ({_put(_atom(e), binding) for e in part} for part in writer.effects(schema))
            names = [writer.action_name(schema, number), *(binding[p] for p in writer.shown(schema))]
            return (state - deleted) | added, f"({' '.join(names)})"
    return None


def _bindings(atoms: Sequence[Atom], bound: dict[str, str], state: set[Atom]) -> Iterator[dict[str, str]]:
    """The ways to put things for what is not bound yet, so that all atoms hold: those with the fewest open first."""
    if not atoms:
        yield bound
        return
    atom = min(atoms, key=lambda a: sum(word.startswith("?") and word not in bound for word in a))
    rest = [a for a in atoms if a is not atom]
    placed = _put(atom, bound)
    if not any(word.startswith("?") for word in placed):
        if placed in state:
            yield from _bindings(rest, bound, state)
        return
    for fact in sorted(f for f in state if f[0] == atom[0] and len(f) == len(atom)):
        more = dict(bound)
        if all(more.setdefault(p, v) == v if p.startswith("?") else p == v for p, v in zip(placed, fact, strict=True)):
            yield from _bindings(rest, more, state)


def _put(atom: Atom, bound: Mapping[str, str]) -> Atom:
    return tuple(bound.get(word, word) for word in atom)


def _atom(text: str) -> Atom:
    return tuple(text.strip("()").split())
