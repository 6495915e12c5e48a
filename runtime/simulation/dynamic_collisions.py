"""What moves by itself goes right through a robot that cannot get out of its way: the run ends before that."""

from __future__ import annotations

import numpy as np

from ...compiler import ir
from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ..skeleton import Phase, PhasePath
from .braking import at_times, braked
from .predicted_clearance import nearest
from .settings import SIMULATION
from .world import SimulatedWorld


@dataclass(frozen=True, slots=True)
class Hit:
    """`body` gets into `thing`, a module or what it holds, `seconds` after the begin of a motion."""

    body: str
    thing: str
    seconds: float


class Struck(Exception):
    """A run cannot go on, as something goes right through a robot; `diagnostic` says so."""

    def __init__(self, problem: ir.Problem, hit: Hit, time: float) -> None:
        message = f"`{hit.body}` moves right through `{hit.thing}`, which is in its way from {time:.2f} s on"
        spans = [c.span for c in problem.world.courses if c.body == hit.body]
        self.diagnostic = Diagnostic("S0009", message, spans[0] if spans else None)
        super().__init__(message)


def first_hit(problem: ir.Problem, world: SimulatedWorld, phase: Phase, path: PhasePath) -> Hit | None:
    """What goes right through a robot while a motion is carried out, as things truly move; None when nothing does."""
    whole = _deepest(problem, world, phase, path, path.duration) if world.on_course else None
    if whole is None or whole[0] < SIMULATION.through:
        return None
    clear, hit = 0.0, path.duration
    for _ in range(SIMULATION.halvings):
        middle = 0.5 * (clear + hit)
        found = _deepest(problem, world, phase, path, middle)
        if found is not None and found[0] > SIMULATION.touching:
            hit = middle
        else:
            clear = middle
    return Hit(whole[2], whole[1], clear)


def before_hit(problem: ir.Problem, path: PhasePath, hit: Hit) -> PhasePath | None:
    """As much of a motion as robots can carry out, and come to rest, before they are hit."""
    for since in np.arange(hit.seconds - SIMULATION.sensing_period, 0.0, -SIMULATION.sensing_period):
        slowed = braked(problem.world, path, float(since))
        if slowed is not path and slowed.duration <= hit.seconds:
            return slowed
    return None


def _deepest(
    problem: ir.Problem, world: SimulatedWorld, phase: Phase, path: PhasePath, end: float
) -> tuple[float, str, str] | None:
    """How deep something that moves by itself gets into a thing, metres, up to `end` seconds; the thing, the body."""
    inner = np.linspace(0.0, end, SIMULATION.phase_looks)
    own = {body: world.body_poses(body, world.time + inner) for body in sorted(world.on_course)}
    found = nearest(problem, world.reached.configuration, phase, at_times(path, inner, end), own)
    depths = [(-distance, thing, body) for (thing, body), distance in found.items() if body in own]
    return max(depths, default=None)
