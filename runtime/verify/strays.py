"""How far terms of motion predicates may stray between two instants from their values there.

The stray of a term in a stretch of time bounds how far its value anywhere in the stretch is from that at the nearer of
both ends. Of a position it is half the length of the stretch times the speed; terms made of others follow by the rules
for sums, products and quotients of numbers that are known but for an error. Of loads it is only estimated, as what they
change by within the stretch."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from .bounds import Bounds, Node, Rates
from .geometry import Array
from .rows import Evaluator, MeaninglessRow, name_of
from .sampler import Sampler
from .shapes import bounding_radius


class Strays:
    """The strays of terms with the variables of one ground literal, in the stretches of a grid."""

    def __init__(
        self, sampler: Sampler, bounds: Bounds, shapes: Mapping[str, ir.Shape | None], evaluate: Evaluator,
        names: Mapping[str, str], world: ir.World,
    ) -> None:  # fmt: skip
        self._sampler, self._bounds, self._shapes = sampler, bounds, shapes
        self._evaluate, self._names, self._world = evaluate, names, world
        self._at = np.arange(len(bounds.lengths) + 1)
        self._half = 0.5 * bounds.lengths[:, None]

    def of(self, node: ir.Term) -> Array:
        """The strays `(C, rows)` of a term. Raises MeaninglessRow."""
        match node:
            case ir.Number():
                return np.zeros((len(self._half), 1))
            case ir.Vector():
                return np.hstack([self.of(t) for t in node.items])
            case ir.Arith():
                return self._arithmetic(node)
            case ir.Function():
                return self._function(node)
            case _:
                raise MeaninglessRow(f"{type(node).__name__} has no value on a motion")

    def _largest(self, node: ir.Term) -> Array:
        """The greatest absolute values `(C, rows)` of a term at the ends of each stretch."""
        values = np.abs(self._values(node))
        return np.maximum(values[1:], values[:-1])

    def _least(self, node: ir.Term) -> Array:
        values = np.abs(self._values(node))
        return np.minimum(values[1:], values[:-1])

    def _values(self, node: ir.Term) -> Array:
        return self._evaluate.value(node, self._names, self._at).values

    def _arithmetic(self, node: ir.Arith) -> Array:
        strays = [self.of(t) for t in node.operands]
        if node.operator in ("+", "-", "neg"):
            return np.asarray(sum(strays[1:], strays[0]))
        (a, b), (one, other) = (self._largest(t) for t in node.operands), strays
        if node.operator == "*":
            return np.asarray(a * other + b * one + one * other)
        least = self._least(node.operands[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            found = (one + a / least * other) / (least - other)
        return np.where(least > other, found, np.inf)

    def _function(self, node: ir.Function) -> Array:
        match node.name, node.args:
            case "position", (subject,):
                return np.repeat(self._half * self._rates(subject).speed[:, None], 3, axis=1)
            case "axis", (subject, _):
                return np.repeat(self._half * self._rates(subject).turn[:, None], 3, axis=1)
            case ("load" | "torque" | "wrench"), _:
                return np.abs(np.diff(self._values(node), axis=0))
            case ("mass" | "radius"), _:
                return np.zeros((len(self._half), 1))
            case "centre", (subject,):
                return np.repeat(self._half * self._centre(name_of(subject, self._names))[:, None], 3, axis=1)
            case ("top" | "bottom"), (subject,):
                return self._half * self._surface(subject)[:, None]
            case "gap", (first, second):
                return self._half * (self._surface(first) + self._surface(second))[:, None]
            case "inside", (first, second):
                one, other = self._rates(first), self._rates(second)
                apart = np.linalg.norm(self._position(first) - self._position(second), axis=1)
                far = np.maximum(apart[1:], apart[:-1])
                stray = self._half * (one.speed + other.speed + other.turn * far)[:, None]
                return np.repeat(stray + self._half**2 * (other.turn * (one.speed + other.speed))[:, None], 4, axis=1)
            case _:
                return self._numeric(node)

    def _numeric(self, node: ir.Function) -> Array:
        strays = [self.of(t) for t in node.args]
        match node.name, strays:
            case "dot", [one, other]:
                return np.asarray(self._products(node, one, other).sum(axis=1, keepdims=True))
            case "cross", [one, other]:
                a, b = (self._largest(t) + s for t, s in zip(node.args, strays, strict=True))
                stray = np.linalg.norm(a, axis=1) * np.linalg.norm(other, axis=1)
                stray = stray + np.linalg.norm(b, axis=1) * np.linalg.norm(one, axis=1)
                return np.repeat(stray[:, None], 3, axis=1)
            case "norm", [one]:
                return np.asarray(np.linalg.norm(one, axis=1, keepdims=True))
            case "least", [one, other]:
                return np.maximum(one, other)
            case "sqrt", [one]:
                least = np.maximum(self._least(node.args[0]), np.finfo(float).tiny)
                return np.minimum(np.sqrt(one), one / np.sqrt(least))
            case ("abs" | "sin" | "cos"), [one]:
                return one
            case _:
                raise MeaninglessRow(f"{node.name} of {len(strays)} values means nothing here")

    def _products(self, node: ir.Function, one: Array, other: Array) -> Array:
        a, b = (self._largest(t) for t in node.args)
        return np.asarray(a * other + b * one + one * other)

    # --- things ----------------------------------------------------------------------------------------------------

    def _rates(self, subject: ir.Term) -> Rates:
        """Bounds on the motion of an object's frame in the world, in every stretch."""
        return self._moved(name_of(subject, self._names))

    def _moved(self, name: str) -> Rates:
        thing, joint, placement = self._sampler.mount(name)
        offset = 0.0 if placement is None else float(np.linalg.norm(placement.position[0]))
        return self._spread((thing, joint), offset)

    def _spread(self, node: Node, offset: float) -> Rates:
        rates = self._bounds.of(node).moved(offset)
        count = (len(self._half),)
        return Rates(*(np.broadcast_to(a, count) for a in (
            rates.turn, rates.turning, rates.speed, rates.acceleration
        )))  # fmt: skip

    def _surface(self, subject: ir.Term) -> Array:
        """The greatest speed of any point of an object's shape."""
        name = name_of(subject, self._names)
        shape, rates = self._shapes[name], self._moved(name)
        radius = 0.0 if shape is None else bounding_radius(shape.kind, shape.size)
        return np.asarray(rates.speed + rates.turn * radius)

    def _centre(self, name: str) -> Array:
        """The greatest speed of the centre of mass of a body, or of the module that an object is part of."""
        module = self._world.modules.get(name) or self._world.modules.get(name.rpartition(".")[0])
        if module is None:
            return self._moved(name).speed
        parts = [(e.joint, e.placement) for e in module.type.effectors if e.shape is not None]
        parts += [(k.joint, k.placement) for k in module.type.links]
        speeds = [
            self._spread((module.name, joint), float(np.linalg.norm(at[:3]))).speed for joint, at in parts
        ] or [self._spread((module.name, -1), 0.0).speed]  # fmt: skip
        return np.asarray(np.max(speeds, axis=0))

    def _position(self, subject: ir.Term) -> Array:
        return self._evaluate.frame(subject, self._names, self._at).position
