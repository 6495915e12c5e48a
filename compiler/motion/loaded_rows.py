"""Rows of motion predicates that speak of loads: what they compare depends on all that is joined in a mode."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache

import casadi as ca

from ...langs.frozen import dataclass
from .. import ir
from ..physics.safety import safety_of
from ..physics.stages import LoadGraph, SymbolicLoads, graph_of
from ..physics.structure import Edge, node_of, structure
from ..remembering import remembered
from .constraints import BodyKind, EffectorKind, Kind, RestKind, RowScope, arguments, parameter_sizes, residual, solid
from .stages import Stage

LOADS = frozenset({"load", "torque", "wrench"})
LEAST = 1.0
"""What bounds are at least taken for, where a row is measured by its own bound."""

Meaning = tuple[ir.Function, tuple[tuple[int, float], ...]]
"""A function of a row, and the bonds that it asks about, each with its sign."""


@dataclass(frozen=True, slots=True)
class LoadedRow:
    """The stage of a ground row. Its variables are the slots of `slots`, in order; `constants` of its arguments are
    those of `objects`."""

    stage: Stage
    slots: tuple[str, ...]
    objects: tuple[str, ...]
    kinds: tuple[Kind, ...]


def functions(term: ir.Term | None) -> Iterator[ir.Function]:
    """All functions in a term, outer ones first."""
    match term:
        case ir.Function(_, inner) | ir.Arith(_, inner) | ir.Vector(inner):
            if isinstance(term, ir.Function):
                yield term
            for item in inner:
                yield from functions(item)


@remembered(256)
def speaks_of_loads(row: ir.Row) -> bool:
    """Whether a row speaks of loads."""
    return any(f.name in LOADS for side in (row.left, row.right) for f in functions(side))


def share_of(row: ir.Row) -> float:
    """What a row about loads is measured by: its bound, where that is a number above 1."""
    bounds = [abs(s.value) for s in (row.left, row.right) if isinstance(s, ir.Number)]
    return max([LEAST, *bounds])


def loaded_row(
    problem: ir.Problem, mode: frozenset[ir.Fact], row: ir.Row, variables: tuple[ir.Variable, ...],
    names: Mapping[str, str],
) -> LoadedRow | None:  # fmt: skip
    """A row of a ground literal, whose variables are `names`, in a mode. None where loops leave loads open."""
    found = graph_of(problem, mode, safety_of(problem.options))
    if found is None:
        return None
    graph, slots = found
    declared = arguments(row, variables)
    objects = tuple(names.get(name, name) for name in declared)
    every, kinds = list(slots), list[Kind]()
    for name in objects:
        kinds.append(_kind(problem, name, every))
    edges = structure(problem, mode).edges
    asked = [f for side in (row.left, row.right) for f in functions(side) if f.name in LOADS]
    meanings = tuple((f, _bonds(problem, edges, f, names)) for f in asked)
    extra = tuple(7 + len(problem.world.modules[n].type.joints) if n in problem.world.modules else 7
                  for n in every[len(slots):])  # fmt: skip
    return LoadedRow(_stage(row, declared, tuple(kinds), graph, extra, meanings), tuple(every), objects, tuple(kinds))


def _kind(problem: ir.Problem, name: str, slots: list[str]) -> Kind:
    world = problem.world
    found = world.effector(name)
    owner = found[0].name if found is not None else name
    body = world.bodies.get(owner)
    shape: ir.ShapeKind | ir.Shape = ir.ShapeKind.SPHERE
    if body is not None:
        shape = body.shape if body.shape.kind == ir.ShapeKind.CONVEX else body.shape.kind
    if body is not None and not body.movable:
        return RestKind(shape, body.mass)
    if owner not in slots:
        slots.append(owner)
    if body is not None:
        return BodyKind(shape, slots.index(owner), body.mass)
    return EffectorKind(world.modules[owner].type, "" if found is None else found[1].name, slots.index(owner))


def _bonds(
    problem: ir.Problem, edges: tuple[Edge, ...], function: ir.Function, names: Mapping[str, str]
) -> tuple[tuple[int, float], ...]:
    """The bonds that a function asks about."""

    def named(term: ir.Term) -> str:
        return names.get(term.name, term.name) if isinstance(term, ir.Var | ir.Object) else ""

    first = named(function.args[0])
    owner = problem.world.owner(first)
    if function.name == "load":
        own = [k for k, e in enumerate(edges) if owner in (e.parent[0], e.child[0])]
        return tuple((k, 1.0) for k in own)
    if function.name == "torque":
        joint = function.args[1].letter if isinstance(function.args[1], ir.Letter) else ""
        return tuple((k, 1.0) for k, e in enumerate(edges) if e.is_joint and e.names == (owner, joint))
    pair = first, named(function.args[1])
    found = []
    for k, edge in enumerate(edges):
        if not edge.is_joint and set(edge.names) == set(pair):
            found.append((k, 1.0 if edge.child == node_of(problem, pair[0]) else -1.0))
    return tuple(found)


@cache
def _stage(
    row: ir.Row, names: tuple[str, ...], kinds: tuple[Kind, ...], graph: LoadGraph, extra: tuple[int, ...],
    meanings: tuple[Meaning, ...],
) -> Stage:  # fmt: skip
    sizes = [*graph.sizes, *extra]
    counts = parameter_sizes(kinds)
    variables, constants = ca.SX.sym("x", sum(sizes)), ca.SX.sym("p", sum(counts))
    slots, start = [], 0
    for size in sizes:
        slots.append(variables[start : start + size])
        start += size
    loads, known = SymbolicLoads(graph, variables[: sum(graph.sizes)]), {}
    for function, bonds in meanings:
        numbers = [number for number, _ in bonds]
        if function.name == "load":
            known[function] = loads.ratio(numbers)
        elif function.name == "torque":
            known[function] = loads.drive(numbers[0]) if numbers else ca.SX(0.0)
        else:
            known[function] = bonds[0][1] * loads.wrench(numbers[0]) if numbers else ca.SX.zeros(6)
    scope, used = RowScope(known), 0
    for name, kind, count in zip(names, kinds, counts, strict=True):
        scope[name] = solid(kind, slots, constants[used : used + count])
        used += count
    return Stage(row.when, variables, constants, residual(row, scope) / share_of(row))
