"""Values of the terms of motion predicates at some instants of a plan, with their units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from ...compiler import ir
from ...langs.frozen import dataclass
from .geometry import Array, Frames, HeldFrames, Indices, frames
from .inertia import body_mass, centre_of, mass_of
from .shapes import Ruler, geometry, heights, inside_top, round_radius, transform

LETTERS = {"x": 0, "y": 1, "z": 2}
LENGTHS = frozenset({"position", "centre", "gap", "top", "bottom", "inside", "radius"})


class MeaninglessRow(Exception):
    """A row of a motion predicate cannot be evaluated; the message says why."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """Values `(T, rows)` and their unit: "m" or ""."""

    values: Array
    unit: str


class Posed(Protocol):
    """Where everything is at some instants."""

    def frame(self, name: str) -> Frames | HeldFrames:
        """The frames `(T,)` of an object."""
        ...

    def parts(self, name: str) -> Mapping[int, Frames] | None:
        """The frames `(T,)` of a module by joint; None of what is no module."""
        ...


class Loaded(Protocol):
    """What is known of loads."""

    def value(self, function: ir.Function, names: Mapping[str, str], posed: Posed, at: Indices) -> Quantity:
        """The value of a function about loads."""
        ...


class Evaluator:
    """Evaluates terms with the variables of one ground literal, at some instants."""

    def __init__(
        self, shapes: Mapping[str, ir.Shape | None], motion: Posed, world: ir.World | None = None,
        loads: Loaded | None = None,
    ) -> None:  # fmt: skip
        self._loads = loads
        self._world = world
        self._shapes = shapes
        self._motion = motion
        self._ruler = Ruler()

    def value(self, node: ir.Term, names: Mapping[str, str], at: Indices) -> Quantity:
        """The term's value at samples `at`. Raises MeaninglessRow."""
        match node:
            case ir.Number():
                return Quantity(np.full((len(at), 1), float(node.value)), "")
            case ir.Vector():
                parts = [self.value(t, names, at) for t in node.items]
                return Quantity(np.hstack([p.values for p in parts]), _shared([p.unit for p in parts]))
            case ir.Arith():
                return _arithmetic(node.operator, [self.value(t, names, at) for t in node.operands])
            case ir.Function():
                return self._function(node, names, at)
            case _:
                raise MeaninglessRow(f"{type(node).__name__} has no value on a motion")

    def frame(self, node: ir.Term, names: Mapping[str, str], index: Indices) -> Frames:
        """The frames of the object that a term names."""
        return self._motion.frame(name_of(node, names))[index]

    def _function(self, node: ir.Function, names: Mapping[str, str], index: Indices) -> Quantity:
        unit = "m" if node.name in LENGTHS else ""
        match node.name, node.args:
            case "position", (subject,):
                return Quantity(self.frame(subject, names, index).position, unit)
            case "axis", (subject, ir.Letter() as letter):
                return Quantity(self.frame(subject, names, index).rotation[:, :, LETTERS[letter.letter]], unit)
            case ("mass" | "centre"), (subject,):
                mass, centre = self._balance(name_of(subject, names), index)
                return Quantity(centre, unit) if node.name == "centre" else Quantity(np.full((len(index), 1), mass), "")
            case ("top" | "bottom"), (subject,):
                sign = 1.0 if node.name == "top" else -1.0
                frame = self.frame(subject, names, index)
                reach = self._heights(name_of(subject, names), frame, node.name == "top")
                return Quantity((frame.position[:, 2] + sign * reach)[:, None], unit)
            case "radius", (subject,):
                shape = self._shapes[name_of(subject, names)]
                radius = 0.0 if shape is None else round_radius(shape.kind, shape.size)
                return Quantity(np.full((len(index), 1), radius), unit)
            case ("load" | "torque" | "wrench"), _:
                if self._loads is None:
                    raise MeaninglessRow(f"{node.name} has no value here")
                return self._loads.value(node, names, self._motion, index)
            case "gap", (first, second):
                return Quantity(self._gap(first, second, names, index), unit)
            case "inside", (first, second):
                return Quantity(self._inside(first, second, names, index), unit)
            case _:
                return _numeric(node.name, [self.value(a, names, index) for a in node.args])

    def _balance(self, name: str, index: Indices) -> tuple[float, Array]:
        """Mass and centre of mass of a body, or of the module that an object is part of."""
        module = name if self._motion.parts(name) is not None else name.rpartition(".")[0]
        parts = self._motion.parts(module)
        if self._world is not None and parts is not None:
            return centre_of(self._world.modules[module].type, parts, index)
        shape = self._shapes[name]
        body = None if self._world is None else self._world.bodies.get(name)
        mass = body_mass(body) if body is not None else 0.0 if shape is None else mass_of(shape)
        return mass, self._motion.frame(name)[index].position

    def _heights(self, name: str, frame: Frames, up: bool) -> Array:
        shape = self._shapes[name]
        if shape is None:
            return np.zeros(len(frame))
        if not (up and shape.parts):
            return heights(shape.kind, shape.size, frame.rotation, up)
        bearer = shape.parts[0]
        return heights(bearer.shape.kind, bearer.shape.size, frame.rotation) + frame.rotation[:, 2] @ bearer.at

    def _gap(self, first: ir.Term, second: ir.Term, names: Mapping[str, str], index: Indices) -> Array:
        sides = []
        for node in (first, second):
            shape, frame = self._shapes[name_of(node, names)], self.frame(node, names, index)
            solids = (shape or ir.Shape(ir.ShapeKind.SPHERE, (1e-9,))).solids
            sides.append([(geometry(p.shape.kind, p.shape.size), frame.compose(frames(p.placement))) for p in solids])
        return np.array([
            [min(
                self._ruler.distance(
                    a, transform(at_a.position[t], at_a.rotation[t]), b, transform(at_b.position[t], at_b.rotation[t])
                )
                for a, at_a in sides[0] for b, at_b in sides[1]
            )]
            for t in range(len(index))
        ])  # fmt: skip

    def _inside(self, first: ir.Term, second: ir.Term, names: Mapping[str, str], index: Indices) -> Array:
        shape = self._shapes[name_of(second, names)]
        local = self.frame(first, names, index).relative_to(self.frame(second, names, index)).position
        if shape is None:
            raise MeaninglessRow(f"{name_of(second, names)} has no shape to be inside of")
        bearer = shape.solids[0]
        shape, local = bearer.shape, local - np.array(bearer.at)
        if shape.kind == ir.ShapeKind.CONVEX:
            return np.repeat(inside_top(shape.size, local[:, :2])[:, None], 4, axis=1)
        if shape.kind != ir.ShapeKind.BOX:
            return np.repeat(shape.size[0] - np.hypot(local[:, 0], local[:, 1])[:, None], 4, axis=1)
        x, y = 0.5 * shape.size[0], 0.5 * shape.size[1]
        return np.column_stack([x - local[:, 0], x + local[:, 0], y - local[:, 1], y + local[:, 1]])


def name_of(node: ir.Term, names: Mapping[str, str]) -> str:
    """The object that a term names. Raises MeaninglessRow."""
    if isinstance(node, ir.Var) and node.name in names:
        return names[node.name]
    if isinstance(node, ir.Object):
        return node.name
    raise MeaninglessRow(f"{node} names no object")


def _shared(units: Sequence[str]) -> str:
    return next((u for u in units if u), "")


def _numeric(name: str, arguments: list[Quantity]) -> Quantity:
    first = arguments[0]
    match name, arguments:
        case "dot", [a, b]:
            return Quantity(np.sum(a.values * b.values, axis=1, keepdims=True), _shared([a.unit, b.unit]))
        case "cross", [a, b]:
            return Quantity(np.cross(a.values, b.values), _shared([a.unit, b.unit]))
        case "norm", [a]:
            return Quantity(np.linalg.norm(a.values, axis=1, keepdims=True), a.unit)
        case "least", [a, b]:
            return Quantity(np.minimum(a.values, b.values), _shared([a.unit, b.unit]))
        case "abs", [a]:
            return Quantity(np.abs(a.values), a.unit)
        case "sqrt", [a]:
            return Quantity(np.sqrt(np.clip(a.values, 0.0, None)), "")
        case ("sin" | "cos"), [a]:
            return Quantity((np.sin if name == "sin" else np.cos)(a.values), "")
        case _:
            raise MeaninglessRow(f"{name} of {len(arguments)} values, {first.unit or 'plain'}, means nothing here")


def _arithmetic(operator: str, operands: list[Quantity]) -> Quantity:
    first, second = operands[0], operands[-1]
    unit = _shared([o.unit for o in operands])
    match operator, len(operands):
        case "neg", 1:
            return Quantity(-first.values, unit)
        case "+", 2:
            return Quantity(first.values + second.values, unit)
        case "-", 2:
            return Quantity(first.values - second.values, unit)
        case "*", 2:
            return Quantity(first.values * second.values, unit)
        case "/", 2:
            with np.errstate(divide="ignore", invalid="ignore"):
                quotient = np.nan_to_num(first.values / second.values, nan=math.inf)
            return Quantity(quotient, unit if first.unit and not second.unit else "")
        case _:
            raise MeaninglessRow(f"unknown operator {operator}")
