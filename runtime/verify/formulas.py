"""Plain evaluation of the terms and formulas of rules on a set of ground facts."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field

from ...compiler import ir
from ...compiler.remembering import remembered
from ...langs.frozen import dataclass
from ...langs.source import Span
from .guards import Guards

Value = str | int | float | ir.Chain
Environment = Mapping[str, Value]
TOLERANCE = 1e-9


class ReplayError(Exception):
    """A rule's text cannot be evaluated on what the plan says; the message says why."""


@dataclass(frozen=True, slots=True)
class State:
    """The logic facts, symmetric ones in both orders; `guards` measures the scene."""

    problem: ir.Problem
    facts: frozenset[ir.Fact]
    guards: Guards
    chains: dict[tuple[str, str], tuple[ir.Chain, ...]] = field(default_factory=dict)
    by_predicate: dict[str, list[ir.Fact]] = field(default_factory=dict)

    def of(self, predicate: str) -> Sequence[ir.Fact]:
        """The facts of one predicate."""
        if not self.by_predicate:
            for fact in self.facts:
                self.by_predicate.setdefault(fact[0], []).append(fact)
        return self.by_predicate.get(predicate, ())


# --- variables ---------------------------------------------------------------------------------------------------


def values(state: State, kind: ir.Type, environment: Environment) -> Sequence[Value]:
    """What a variable of that type ranges over in this state."""
    if isinstance(kind, ir.ObjectType):
        return _of_type(state.problem, kind.name)
    if isinstance(kind, ir.RangeType):
        first, last = (number(state, t, environment) for t in (kind.first, kind.last))
        if not math.isfinite(first) or not math.isfinite(last):
            raise ReplayError(f"a range from {first} to {last} has no end")
        return range(math.ceil(first - TOLERANCE), math.floor(last + TOLERANCE) + 1)
    if isinstance(kind, ir.ChainType):
        return chains(state, kind)
    raise ReplayError(f"a variable cannot range over {kind.name}")


@remembered(8)
def _of_type(problem: ir.Problem, name: str) -> tuple[str, ...]:
    return problem.of_type(name)


def chains(state: State, kind: ir.ChainType) -> tuple[ir.Chain, ...]:
    """All maximal directed chains of modules of a type: from each effector that nothing is linked to, through linked
    modules, each at most once, to another such effector."""
    key = (kind.element, kind.predicate)
    if key not in state.chains:
        members = set(state.problem.of_type(kind.element))
        ends = {
            m.name: [f"{m.name}.{e.name}" for e in m.type.effectors]
            for m in state.problem.world.modules.values() if m.name in members
        }  # fmt: skip
        owner = {end: module for module, own in ends.items() for end in own}
        links: dict[str, list[str]] = {}
        for _, one, other in sorted(f for f in state.facts if f[0] == kind.predicate):
            if one in owner and other in owner:
                for here, there in ((one, other), (other, one)):
                    if there not in links.setdefault(here, []):
                        links[here].append(there)
        found = [line for entry in owner if entry not in links for line in _walk(entry, ends, owner, links, ())]
        state.chains[key] = tuple(map(ir.Chain, found))
    return state.chains[key]


Line = tuple[tuple[str, str, str], ...]


def _walk(
    entry: str, ends: Mapping[str, list[str]], owner: Mapping[str, str], links: Mapping[str, list[str]], before: Line
) -> Iterator[Line]:
    """The lines that go on from where a module is entered."""
    for leave in ends[owner[entry]]:
        if leave == entry:
            continue
        line = (*before, (owner[entry], entry, leave))
        if leave not in links:
            yield line
        for following in links.get(leave, ()):
            if all(owner[following] != module for module, _, _ in line):
                yield from _walk(following, ends, owner, links, line)


def bindings(
    state: State, variables: Sequence[ir.Variable], environment: Environment
) -> Iterator[dict[str, Value]]:
    """All extensions of the environment by values of the variables."""
    if not variables:
        yield dict(environment)
        return
    first, *rest = variables
    for value in values(state, first.type, environment):
        yield from bindings(state, rest, {**environment, first.name: value})


# --- terms -------------------------------------------------------------------------------------------------------


def term(state: State, node: ir.Term, environment: Environment) -> Value:
    """The object, number or chain that a term denotes."""
    match node:
        case ir.Number():
            return node.value
        case ir.Object():
            return node.name
        case ir.Var():
            if node.name not in environment:
                raise ReplayError(f"`{node.name}` has no value")
            return environment[node.name]
        case ir.ChainEnd():
            chain = _chain(environment, node.chain)
            return chain.last if node.last else chain.first
        case ir.ChainModule():
            return _chain_module(state, node, environment)
        case ir.Function():
            return _function(state, node, environment)
        case ir.Arith():
            return _arithmetic(node.operator, [number(state, t, environment) for t in node.operands])
        case ir.Conditional():
            branch = node.then if holds(state, node.condition, environment) else node.otherwise
            return term(state, branch, environment)
        case ir.Aggregate():
            found = [number(state, node.body, e) for e in bindings(state, node.variables, environment)]
            if node.operator == "sum":
                return math.fsum(found)
            return (min if node.operator == "min" else max)(found, default=math.inf)
        case ir.Prune():
            return math.inf
        case _:
            raise ReplayError(f"{type(node).__name__} has no value in a rule")


def number(state: State, node: ir.Term, environment: Environment) -> float:
    """The number that a term denotes."""
    value = term(state, node, environment)
    if isinstance(value, int | float):
        return float(value)
    raise ReplayError(f"{value} is no number")


def _chain(environment: Environment, name: str) -> ir.Chain:
    value = environment.get(name)
    if not isinstance(value, ir.Chain):
        raise ReplayError(f"`{name}` is no chain")
    return value


def _chain_module(state: State, node: ir.ChainModule, environment: Environment) -> str:
    chain = _chain(environment, node.chain)
    index = round(number(state, node.index, environment))
    if not 1 <= index <= len(chain.modules):
        raise ReplayError(f"{chain} has no module {index}")
    module, entry, leave = chain.modules[index - 1]
    return {"": module, "in": entry, "out": leave}[node.side]


_NUMERIC: dict[str, Callable[[float], float]] = {
    "sqrt": math.sqrt, "abs": abs, "sin": math.sin, "cos": math.cos, "floor": math.floor,
}  # fmt: skip


def _function(state: State, node: ir.Function, environment: Environment) -> Value:
    if node.name in _NUMERIC:
        try:
            return _NUMERIC[node.name](number(state, node.args[0], environment))
        except (ValueError, OverflowError) as error:
            raise ReplayError(f"{node.name} has no value here") from error
    if node.name == "torque" and isinstance(node.args[1], ir.Letter):
        return state.guards.torque(str(term(state, node.args[0], environment)), node.args[1].letter)
    arguments = [term(state, a, environment) for a in node.args]
    match node.name, arguments:
        case "length", [ir.Chain() as chain]:
            return len(chain.modules)
        case "load", [ir.Chain() | str() as thing]:
            return state.guards.load(thing)
        case "reach", [ir.Chain() as chain]:
            return state.guards.chain_reach(chain)
        case "reach", [str(first), str(second)]:
            return state.guards.reach(first, second)
        case "radius", [str(name)]:
            return state.guards.radius(name)
        case "distance", [str(first), str(second)]:
            return state.guards.distance(first, second)
        case "stride", [str(first), str(second), int() | float() as inset]:
            return state.guards.stride(first, second, float(inset))
        case _:
            raise ReplayError(f"{node.name} cannot be evaluated in a rule")


def _arithmetic(operator: str, operands: list[float]) -> float:
    match operator, operands:
        case "neg", [only]:
            return -only
        case "+", [left, right]:
            return left + right
        case "-", [left, right]:
            return left - right
        case "*", [left, right]:
            return left * right
        case "/", [left, right]:
            return left / right if right else math.inf
        case _:
            raise ReplayError(f"unknown operator {operator}")


# --- formulas ----------------------------------------------------------------------------------------------------


def holds(state: State, formula: ir.Formula, environment: Environment) -> bool:
    """Whether the formula is true of the state."""
    match formula:
        case ir.Literal():
            return _literal(state, formula, environment)
        case ir.Not():
            return not holds(state, formula.operand, environment)
        case ir.And():
            return all(holds(state, f, environment) for f in formula.operands)
        case ir.Or():
            return any(holds(state, f, environment) for f in formula.operands)
        case ir.Exists():
            return _exists(state, formula.variables, formula.body, environment)
        case ir.Forall():
            return all(holds(state, formula.body, e) for e in bindings(state, formula.variables, environment))
        case ir.Compare():
            return _compare(state, formula, environment)
        case ir.Previous():
            raise ReplayError("`previous is` stands only in heuristics")


def _exists(
    state: State, variables: Sequence[ir.Variable], body: ir.Formula, environment: Environment
) -> bool:  # fmt: skip
    """Whether some values of the variables make the body true. Those that no fact allows are not tried: of thousands
    of objects, a handful are on something."""
    if not variables:
        return holds(state, body, environment)
    first, *rest = variables
    allowed = None
    if isinstance(first.type, ir.ObjectType):
        known = {name: value for name, value in environment.items() if all(name != v.name for v in variables)}
        allowed = _allowed(state, first.name, body, known)
    return any(
        _exists(state, rest, body, {**environment, first.name: value})
        for value in values(state, first.type, environment) if allowed is None or value in allowed
    )  # fmt: skip


def _allowed(state: State, name: str, body: ir.Formula, known: Environment) -> frozenset[str] | None:
    """The objects among which a variable must be, as a fact that the body asks for names it; None where there is no
    such fact."""
    for part in body.operands if isinstance(body, ir.And) else (body,):
        if not isinstance(part, ir.Literal) or part.predicate in state.problem.derived:
            continue
        at = [k for k, argument in enumerate(part.args) if isinstance(argument, ir.Var) and argument.name == name]
        given = {k: str(known[a.name]) for k, a in enumerate(part.args) if isinstance(a, ir.Var) and a.name in known}
        given |= {k: a.name for k, a in enumerate(part.args) if isinstance(a, ir.Object)}
        if at:
            found = (f for f in state.of(part.predicate) if all(f[k + 1] == value for k, value in given.items()))
            return frozenset(fact[at[0] + 1] for fact in found)
    return None


def pattern(state: State, terms: Sequence[ir.Term], environment: Environment) -> tuple[str | None, ...]:
    """Names of the objects that terms denote; None for `ANY`."""
    return tuple(None if isinstance(t, ir.Any_) else str(term(state, t, environment)) for t in terms)


def matches(pattern: Sequence[str | None], names: Sequence[str]) -> bool:
    """Whether names fit a pattern in which None fits everything."""
    return len(pattern) == len(names) and all(p is None or p == n for p, n in zip(pattern, names, strict=True))


def _literal(state: State, literal: ir.Literal, environment: Environment) -> bool:
    derived = state.problem.derived.get(literal.predicate)
    wanted = pattern(state, literal.args, environment)
    if derived is None:
        if None not in wanted:
            return (literal.predicate, *wanted) in state.facts
        return any(matches(wanted, f[1:]) for f in state.of(literal.predicate))
    names = [v.name for v in derived.variables]
    choices = [
        [w] if w is not None else list(values(state, v.type, {}))
        for w, v in zip(wanted, derived.variables, strict=True)
    ]
    return any(
        holds(state, derived.body, dict(zip(names, choice, strict=True))) for choice in itertools.product(*choices)
    )


def _compare(state: State, formula: ir.Compare, environment: Environment) -> bool:
    left, right = term(state, formula.left, environment), term(state, formula.right, environment)
    if not (isinstance(left, int | float) and isinstance(right, int | float)):
        if formula.operator not in ("=", "!="):
            raise ReplayError(f"{left} and {right} cannot be ordered")
        return (left == right) == (formula.operator == "=")
    difference = left - right if left != right else 0.0
    return {
        "=": abs(difference) <= TOLERANCE,
        "!=": abs(difference) > TOLERANCE,
        "<": difference < -TOLERANCE,
        "<=": difference <= TOLERANCE,
        ">": difference > TOLERANCE,
        ">=": difference >= -TOLERANCE,
    }[formula.operator]


# --- what is measured --------------------------------------------------------------------------------------------

MEASURED = ("distance", "stride")
"""Functions whose value follows what moves."""


def unmeasured(problem: ir.Problem, condition: ir.Formula) -> ir.Formula:
    """The parts of a conjunction that measure nothing which moves."""
    if isinstance(condition, ir.And):
        kept = tuple(unmeasured(problem, part) for part in condition.operands if not _measures(problem, part))
        return ir.And(kept)
    return ir.And(()) if _measures(problem, condition) else condition


def _measures(problem: ir.Problem, node: object) -> bool:
    if isinstance(node, ir.Function) and node.name in MEASURED:
        return True
    if isinstance(node, ir.Literal) and node.predicate in problem.derived:
        return _measures(problem, problem.derived[node.predicate].body)
    if isinstance(node, tuple):
        return any(_measures(problem, part) for part in node)
    if dataclasses.is_dataclass(node) and not isinstance(node, type | Span):
        return any(_measures(problem, getattr(node, f.name)) for f in dataclasses.fields(node))
    return False
