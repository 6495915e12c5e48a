"""The rows of motion predicates, as values over many instants at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tamplang.compiler import ir

from .frames import inverse
from .shapes import Solid, distance

Matrix = NDArray[np.float64]
LENGTHS = {"position", "gap", "top", "bottom", "inside", "norm", "centre", "radius"}


@dataclass(frozen=True, slots=True)
class View:
    """What rows look at: frames (T, 4, 4) and shape of an object, mass and centre of mass of it or its module."""

    frame: Callable[[str], Matrix]
    solid: Callable[[str], Solid | None]
    weight: Callable[[str], tuple[float, Matrix]]


def excess(row: ir.Row, binding: dict[str, Any], view: View) -> Matrix:
    """How far an `at switch` or `during` row is from being met, at every instant."""
    assert row.right is not None
    apart: Matrix = value(row.left, binding, view) - value(row.right, binding, view)
    if row.operator == "=":
        apart = np.abs(apart)
    elif row.operator == ">=":
        apart = -apart
    return np.asarray(apart.max(axis=1))


def is_length(row: ir.Row) -> bool:
    """Whether a row speaks of metres; else of directions or plain numbers."""
    return any(name in LENGTHS for side in (row.left, row.right) if side is not None for name in functions(side))


def functions(term: ir.Term) -> Iterator[str]:
    """The functions in a term."""
    if isinstance(term, ir.Function):
        yield term.name
    for part in _parts(term):
        yield from functions(part)


def _parts(term: Any) -> tuple[Any, ...]:
    match term:
        case ir.Function():
            return tuple(a for a in term.args if not isinstance(a, ir.Letter))
        case ir.Arith():
            return term.operands
        case ir.Vector():
            return term.items
    return ()


def value(term: ir.Term, binding: dict[str, Any], view: View) -> Any:
    """The name of an object, or an array of one row, or one per instant: 1 column for scalars, 3 for vectors, 4 for the
    sides of `inside`."""
    match term:
        case ir.Number():
            return np.array([[term.value]])
        case ir.Object():
            return term.name
        case ir.Var():
            found = binding[term.name]
            return found if isinstance(found, str) else np.array([[float(found)]])
        case ir.Vector():
            return np.concatenate(np.broadcast_arrays(*(value(i, binding, view) for i in term.items)), axis=1)
        case ir.Arith():
            operands = [value(o, binding, view) for o in term.operands]
            if term.operator == "neg":
                return -operands[0]
            return {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}[term.operator](*operands)
        case ir.Function():
            return _function(term, binding, view)
    raise ValueError(f"no term of a row: {term}")


def _function(term: ir.Function, binding: dict[str, Any], view: View) -> Any:
    if term.name == "axis":
        frame = view.frame(value(term.args[0], binding, view))
        letter = term.args[1]
        assert isinstance(letter, ir.Letter)
        return frame[:, :3, "xyz".index(letter.letter)]
    args = [value(a, binding, view) for a in term.args]
    match term.name:
        case "position":
            return view.frame(args[0])[:, :3, 3]
        case "top" | "bottom":
            frame, solid = view.frame(args[0]), view.solid(args[0])
            beyond = 0.0 if solid is None else solid.rise(frame) if term.name == "top" else -solid.fall(frame)
            return (frame[:, 2, 3] + beyond)[:, None]
        case "radius":
            solid = view.solid(args[0])
            return np.array([[0.0 if solid is None else solid.around]])
        case "inside":
            return _inside(view, args[0], args[1])
        case "gap":
            return _gap(view, args[0], args[1])
        case "mass":
            return np.array([[view.weight(args[0])[0]]])
        case "centre":
            return view.weight(args[0])[1]
        case "dot":
            return (args[0] * args[1]).sum(axis=1, keepdims=True)
        case "cross":
            first, second = np.broadcast_arrays(args[0], args[1])
            return np.cross(first.astype(float), second.astype(float))
        case "norm":
            return np.linalg.norm(args[0], axis=1, keepdims=True)
        case "least":
            return np.minimum(args[0], args[1])
        case "abs" | "sqrt" | "sin" | "cos":
            return getattr(np, term.name)(args[0])
        case "pose":
            return inverse(view.frame(args[1])) @ view.frame(args[0])
    raise ValueError(f"no function of a row: {term.name}")


def _inside(view: View, one: str, other: str) -> Matrix:
    """To the four sides of the face of `other` that is its top."""
    frame, solid = view.frame(other), view.solid(other)
    assert solid is not None
    at = np.einsum("tji,tj->ti", frame[:, :3, :3], view.frame(one)[:, :3, 3] - frame[:, :3, 3])
    up = int(np.argmax(np.abs(frame[:, 2, :3]).mean(axis=0)))
    sides = []
    for k in (k for k in range(3) if k != up):
        half = solid.sides[k] / 2
        sides += [half - at[:, k], half + at[:, k]]
    return np.stack(sides, axis=-1)


def _gap(view: View, one: str, other: str) -> Matrix:
    first, second = view.solid(one), view.solid(other)
    if first is None or second is None:
        raise ValueError(f"{one} or {other} has no shape")
    frames = zip(view.frame(one), view.frame(other), strict=True)
    return np.array([[distance((first, a), (second, b))] for a, b in frames])


def volume(solid: Solid) -> float:
    match solid.kind:
        case "box":
            return math.prod(solid.size)
        case "sphere":
            return 4 / 3 * math.pi * solid.size[0] ** 3
        case "cylinder":
            return math.pi * solid.size[0] ** 2 * solid.size[1]
        case "capsule":
            return math.pi * solid.size[0] ** 2 * (solid.size[1] + 4 / 3 * solid.size[0])
    from scipy.spatial import ConvexHull

    return float(ConvexHull(solid.points).volume)
