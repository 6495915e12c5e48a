"""Functions of motion predicates and rules about loads: load, torque, wrench, at rest."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...compiler import ir
from ...compiler.options import OPTIONS
from .geometry import Indices, crossed
from .kept_poses import kept
from .rows import MeaninglessRow, Posed, Quantity, name_of
from .statics import Wrenches, node_frames, node_loads, wrenches_of
from .strengths import joined, judge, meeting_place

LOADS = frozenset({"load", "torque", "wrench"})
RATIOS = ("torque_ratio", "bearing_ratio", "dock_ratio", "foot_ratio")


class Gauge:
    """Loads while a mode holds."""

    def __init__(self, problem: ir.Problem, mode: frozenset[ir.Fact]) -> None:
        self._problem = problem
        self._edges = joined(problem, mode, kept(problem, mode))
        given = problem.options.safety
        self.safety = float(OPTIONS["safety"].default if given is None else given)
        self._last: tuple[Posed, bytes, Wrenches] | None = None

    def value(self, function: ir.Function, names: Mapping[str, str], posed: Posed, at: Indices) -> Quantity:
        """The function's value at instants `at`. Raises MeaninglessRow."""
        first = name_of(function.args[0], names)
        owner = self._problem.world.owner(first)
        nodes = node_frames(self._problem, posed, at)
        found = self._wrenches(posed, at)
        if function.name == "load":
            worst = np.zeros(len(at))
            for edge in [e for e in self._edges if owner in (e.near[0], e.far[0]) and e in found]:
                for figure in judge(self._problem, edge, nodes, *found[edge], self.safety, resting=True):
                    if figure.kind in RATIOS:
                        worst = np.maximum(worst, figure.amounts)
            return Quantity(worst[:, None], "")
        if function.name == "torque":
            joint = function.args[1].letter if isinstance(function.args[1], ir.Letter) else ""
            drive = next((e for e in self._edges if e.joint_of == owner and e.names[1] == joint), None)
            if drive is None or drive not in found:
                return Quantity(np.zeros((len(at), 1)), "")
            kind = next(j for j in self._problem.world.modules[owner].type.joints if j.name == joint)
            frame, (force, moment) = nodes[owner, drive.far[1]], found[drive]
            axis = frame.rotation @ (np.asarray(kind.axis) / np.linalg.norm(kind.axis))
            acting = moment - crossed(frame.position, force) if kind.kind == ir.JointKind.REVOLUTE else force
            return Quantity(-(acting * axis).sum(axis=1, keepdims=True), "")
        return self._pair(function, names, posed, at)

    def _pair(self, function: ir.Function, names: Mapping[str, str], posed: Posed, at: Indices) -> Quantity:
        pair = [name_of(a, names) for a in function.args]
        edge = next((e for e in self._edges if not e.joint_of and set(e.names) == set(pair)), None)
        found = self._wrenches(posed, at)
        if edge is None or edge not in found:
            return Quantity(np.zeros((len(at), 6)), "")
        force, moment = found[edge]
        place, axes, _ = meeting_place(self._problem, edge, node_frames(self._problem, posed, at))
        sign = 1.0 if edge.names[1] == pair[0] else -1.0
        push = np.einsum("tij,ti->tj", axes, force)
        turn = np.einsum("tij,ti->tj", axes, moment - crossed(place, force))
        return Quantity(sign * np.hstack([push, turn]), "")

    def _wrenches(self, posed: Posed, at: Indices) -> Wrenches:
        key = np.asarray(at).tobytes()
        if self._last is None or self._last[0] is not posed or self._last[1] != key:
            nodes = node_frames(self._problem, posed, at)
            loads = node_loads(self._problem, nodes, None)
            found = wrenches_of(self._problem, self._edges, nodes, loads, self.safety)
            if any(not np.isfinite(f).all() for w in found.values() for f in w):
                raise MeaninglessRow("nothing balances the loads")
            self._last = posed, key, found
        return self._last[2]
