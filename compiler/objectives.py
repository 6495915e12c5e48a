"""What a plan is to be best at: measures of a plan, and weighted sums of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from ..langs.diagnostics import UsageError
from ..langs.frozen import dataclass
from ..langs.source import Span

MEASURES: Mapping[str, str] = {
    "actions": "", "duration": "s", "makespan": "s", "travel": "rad", "energy": "J",
}  # fmt: skip
"""Each with its unit. What the actions cost, by the rules; seconds of motion, those of all robots added up; seconds
until the last action is done; how far joints move, the lengths of the curves of all modules added up (a metre of a
joint that slides counts as a radian); the work of all joints, without recovery."""
TIMED = frozenset(("duration", "makespan"))
EXAMPLE = "minimise = makespan + 0.1 * travel"


@dataclass(frozen=True, slots=True)
class Objective:
    """The sum of some measures, each times its positive weight per unit (second, radian, joule, cost of actions), in
    the order of `MEASURES`."""

    weights: tuple[tuple[str, float], ...]
    span: Span | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return " + ".join(name if weight == 1.0 else f"{weight:g} * {name}" for name, weight in self.weights)

    @property
    def unit(self) -> str:
        """That of the only measure; weighted sums have none."""
        (name, weight), *more = self.weights
        return MEASURES[name] if not more and weight == 1.0 else ""

    @property
    def timed(self) -> bool:
        """Whether it gains from motions that are short, and take place at once."""
        return any(name in TIMED for name, _ in self.weights)

    def value(self, measures: Mapping[str, float]) -> float:
        """What it is for a plan of these measures, of which those with a weight are needed."""
        return sum(weight * measures[name] for name, weight in self.weights)


ACTIONS = Objective((("actions", 1.0),))


def check_energy(objective: Objective, physics: str | None) -> None:
    """Raises UsageError where energy is asked for and nothing tells the torques."""
    if physics in (None, "none") and any(name == "energy" for name, _ in objective.weights):
        told, help = NO_ENERGY
        raise UsageError(told, "E0524", objective.span, help)


NO_ENERGY = (
    "energy is minimised, but no torque is known without physics", "set `physics = statics` or `physics = dynamics`"
)  # fmt: skip
