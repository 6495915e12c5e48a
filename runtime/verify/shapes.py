"""Shapes as coal geometries, their sizes, and their vertical extent. Sizes in metres; see `ir.Shape`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..native import load_coal
from .geometry import Array

SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2}


def geometry(kind: str, size: Sequence[float]) -> Any:
    """The coal geometry of a shape. Raises MissingLibrary."""
    coal = load_coal()
    match kind:
        case "box":
            return coal.Box(*size)
        case "sphere":
            return coal.Sphere(*size)
        case "capsule":
            return coal.Capsule(*size)
        case "cylinder":
            return coal.Cylinder(*size)
        case _:
            raise ValueError(f"unknown shape {kind}")


def transform(position: Array, rotation: Array) -> Any:
    """A coal transform from a position `(3,)` and a rotation matrix `(3, 3)`."""
    return load_coal().Transform3s(rotation, position)


class Ruler:
    """Signed distances by coal; negative when two shapes overlap."""

    def __init__(self) -> None:
        coal = load_coal()
        self._request = coal.DistanceRequest()
        self._request.enable_signed_distance = True
        self._distance = coal.distance
        self._result = coal.DistanceResult

    def distance(self, first: Any, at_first: Any, second: Any, at_second: Any) -> float:
        """Metres between two coal geometries at two coal transforms."""
        return float(self._distance(first, at_first, second, at_second, self._request, self._result()))


def bounding_radius(kind: str, size: Sequence[float]) -> float:
    """Radius of the smallest sphere around the shape's centre that holds it."""
    match kind:
        case "box":
            return 0.5 * math.hypot(*size)
        case "capsule":
            return size[0] + 0.5 * size[1]
        case "cylinder":
            return math.hypot(size[0], 0.5 * size[1])
        case _:
            return size[0]


def round_radius(kind: str, size: Sequence[float]) -> float:
    """What `radius(X)` means: the radius of a round shape, or of the sphere around another one."""
    return bounding_radius(kind, size) if kind == "box" else size[0]


def half_heights(kind: str, size: Sequence[float], rotation: Array) -> Array:
    """Half the vertical extent `(T,)` of a shape turned by `rotation` `(T, 3, 3)`."""
    upright = np.abs(rotation[:, 2, 2])
    match kind:
        case "box":
            return np.asarray(np.abs(rotation[:, 2, :]) @ (0.5 * np.asarray(size)))
        case "capsule":
            return np.asarray(size[0] + 0.5 * size[1] * upright)
        case "cylinder":
            return np.asarray(0.5 * size[1] * upright + size[0] * np.sqrt(np.clip(1 - upright**2, 0, None)))
        case _:
            return np.full(len(rotation), size[0])
