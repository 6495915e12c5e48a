"""How fast anything may move between two instants, from the joints alone: what makes looking at instants a proof.

A frame that moves, as seen from another one, with angular velocity w and angular acceleration w', carries a point at
distance r from its origin with a velocity of at most v + |w| r and an acceleration of at most a + (|w'| + |w|²) r,
where v and a are those of its origin. A revolute joint adds its rate to |w|, and its acceleration and |w| times its
rate to |w'|; a prismatic one adds its rate to v, and its acceleration and 2 |w| times its rate to a. So bounds of the
joints' rates and accelerations, which of cubic splines are known exactly, give bounds for every frame, one step of the
tree after the other.

A point whose acceleration stays below a is never farther than a h² / 8 from the straight line between where it is at
both ends of a stretch of time h, at the same share of the way: the difference is zero at both ends, and its second
derivative at most a.
"""

from __future__ import annotations

import numpy as np

from ...compiler.ir import JointKind
from ...langs.frozen import dataclass
from .geometry import Array
from .sampler import Grid, Placement, Sampler

Node = tuple[str, int]
"""A thing and one of its joints, or -1 for the frame of the thing itself."""


@dataclass(frozen=True, slots=True)
class Rates:
    """Bounds on the motion of a frame as seen from another one, `(C,)` for stretches of time, or `(1,)` for all of
    them: its angular speed and acceleration, and speed and acceleration of its origin, SI."""

    turn: Array
    turning: Array
    speed: Array
    acceleration: Array

    @property
    def rest(self) -> bool:
        """Whether there is no motion at all."""
        return not (self.turn.any() or self.speed.any())

    def moved(self, distance: float | Array) -> Rates:
        """Those of a frame that is fixed to this one, with its origin at most so far from the origin of this one."""
        speed = self.speed + self.turn * distance
        return Rates(self.turn, self.turning, speed, self.acceleration + (self.turning + self.turn**2) * distance)

    def turned(self, rate: Array, change: Array) -> Rates:
        """Those behind a revolute joint whose axis goes through the origin."""
        return Rates(self.turn + rate, self.turning + change + self.turn * rate, self.speed, self.acceleration)

    def slid(self, rate: Array, change: Array) -> Rates:
        """Those behind a prismatic joint."""
        acceleration = self.acceleration + change + 2.0 * self.turn * rate
        return Rates(self.turn, self.turning, self.speed + rate, acceleration)


NONE = Rates(*(np.zeros(1) for _ in range(4)))


@dataclass(frozen=True, slots=True)
class StepBound:
    """From one frame to the next, which is `distance` metres away: over a joint (its module and index) or rigidly, or
    with a body on its course. `up`: against the direction in which the module counts its joints."""

    node: Node
    distance: float
    joint: tuple[str, int] | None = None
    up: bool = False
    course: bool = False


class Bounds:
    """The bounds for the stretches of a grid in one phase; `placement` is where things are at its instants."""

    def __init__(self, sampler: Sampler, phase: int, grid: Grid, placement: Placement) -> None:
        self.lengths = grid.lengths
        self.placement = placement
        self._sampler, self._phase, self._times = sampler, phase, grid.times
        self._lines: dict[Node, tuple[StepBound, ...]] = {}
        self._rates: dict[tuple[Node | None, Node], Rates] = {}
        self._joints: dict[str, tuple[Array, Array, Array]] = {}

    def between(self, base: Node, node: Node) -> tuple[Rates, Rates]:
        """The motion of two frames as seen from the last one that both hang on."""
        first, second = self._line(base), self._line(node)
        common = 0
        for a, b in zip(first, second, strict=False):
            if a.node != b.node:
                break
            common += 1
        return self._along(first, common), self._along(second, common)

    def of(self, node: Node) -> Rates:
        """The motion of a frame in the world."""
        return self._along(self._line(node), 0)

    def bend(self, node: Node, reach: float) -> Array:
        """How far from a straight line a point may get that is fixed to a frame, `reach` metres from its origin."""
        rates = self.of(node)
        return self.strayed(rates.moved(reach).acceleration)

    def strayed(self, acceleration: Array) -> Array:
        """How far a point gets from a straight line within each stretch, at most."""
        return np.asarray(acceleration * self.lengths**2 / 8.0)

    def relative(self, base: Node, offset: float, node: Node, reach: float, apart: Array) -> tuple[Rates, Rates]:
        """The motion of a frame fixed to `base`, `offset` metres from its origin, as seen from the last frame that
        both nodes hang on; and that of any point that is fixed to `node`, `reach` metres from its origin, as seen from
        that frame. `apart` `(T,)`: how far such points are from that frame's origin at the instants."""
        one, other = self.between(base, node)
        if one.rest:
            return NONE, other.moved(reach)
        seat, point = one.moved(offset), other.moved(reach)
        speeds = seat.speed + point.speed
        far = np.maximum(apart[1:], apart[:-1]) + 0.5 * speeds * self.lengths
        seen = speeds + seat.turn * far
        acceleration = seat.acceleration + point.acceleration + (seat.turning + seat.turn**2) * far
        acceleration = acceleration + 2.0 * seat.turn * seen
        turning = seat.turning + point.turning + seat.turn * point.turn
        return seat, Rates(seat.turn + point.turn, turning, seen, acceleration)

    def _along(self, line: tuple[StepBound, ...], common: int) -> Rates:
        base, rates = line[common - 1].node if common else None, NONE
        for step in line[common:]:
            key = base, step.node
            if key not in self._rates:
                self._rates[key] = self._stepped(rates, step)
            rates = self._rates[key]
        return rates

    def _stepped(self, before: Rates, step: StepBound) -> Rates:
        if step.course:
            centre = self.placement.thing(step.node[0])[-1].position
            with np.errstate(divide="ignore", invalid="ignore"):
                speed = np.linalg.norm(np.diff(centre, axis=0), axis=1) / self.lengths
            return Rates(NONE.turn, NONE.turn, speed, NONE.turn)
        if step.joint is None:
            return before if before is NONE else before.moved(step.distance)
        name, index = step.joint
        if self._sampler.curve(name, self._phase) is None:
            return before if before is NONE else before.moved(step.distance)
        rates, changes, values = self._rates_of(name)
        rate, change = rates[:, index], changes[:, index]
        if self._sampler.kinematics[name].module.joints[index].kind == JointKind.PRISMATIC:
            return before.moved(step.distance + values[:, index]).slid(rate, change)
        if step.up:
            return before.turned(rate, change).moved(step.distance)
        return before.moved(step.distance).turned(rate, change)

    def _rates_of(self, module: str) -> tuple[Array, Array, Array]:
        """The greatest rates, accelerations and values of the joints of a module in each stretch `(C, n)`. A rate is a
        parabola: above its ends it rises by an eighth of its second derivative times the square of the length, at
        most."""
        if module not in self._joints:
            curve = self._sampler.curves[module, self._phase]
            rates, changes = np.abs(curve(self._times, 1)), np.abs(curve(self._times, 2))
            rate = np.maximum(rates[1:], rates[:-1])
            values = np.abs(curve(self._times))
            bent = 0.75 * np.abs(curve.cubic[curve.piece(0.5 * (self._times[1:] + self._times[:-1]))])
            rate = rate + bent * self.lengths[:, None] ** 2
            value = np.maximum(values[1:], values[:-1]) + 0.5 * rate * self.lengths[:, None]
            self._joints[module] = rate, np.maximum(changes[1:], changes[:-1]), value
        return self._joints[module]

    # --- the tree ------------------------------------------------------------------------------------------------

    def _line(self, node: Node) -> tuple[StepBound, ...]:
        """The steps from the world to a frame."""
        if node not in self._lines:
            steps, before = [], [node]
            while before and before[0] not in self._lines:
                step, before = self._last(before[0])
                steps.append(step)
            known = self._lines[before[0]] if before else ()
            self._lines[node] = known + tuple(steps[::-1])
        return self._lines[node]

    def _last(self, node: Node) -> tuple[StepBound, list[Node]]:
        """The last step to a frame, and the frame from which it starts; none where that is the world."""
        name, joint = node
        hold = self._sampler.links[self._phase].hold(name)
        if hold is None:
            return StepBound((name, -1), 0.0, course=True), []
        thing, entry, _ = self._sampler.mount(hold.own)
        if joint == entry:
            base = self._sampler.mount(hold.base)[:2] if hold.base else None
            return (StepBound(node, 0.0), []) if base is None else (StepBound(node, self._distance(base, node)), [base])
        joints = self._sampler.kinematics[thing].module.joints
        above = _above([j.parent for j in joints], entry)
        if joint in above:
            below = above[above.index(joint) - 1]
            return StepBound(node, _length(joints[below].placement), (name, below), up=True), [(name, below)]
        return StepBound(node, _length(joints[joint].placement), (name, joint)), [(name, joints[joint].parent)]

    def _distance(self, first: Node, second: Node) -> float:
        """How far the origins of two frames are apart whose relative pose is constant."""
        a, b = (self.placement.thing(name)[joint].position[0] for name, joint in (first, second))
        return float(np.linalg.norm(a - b))


def _length(placement: list[float]) -> float:
    return float(np.linalg.norm(placement[:3]))


def _above(parents: list[int], joint: int) -> list[int]:
    """A joint and all that carry it, up to -1."""
    line = [joint]
    while line[-1] >= 0:
        line.append(parents[line[-1]])
    return line
