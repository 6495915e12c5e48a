"""What a run in a simulated world is asked for, and what it tells."""

from __future__ import annotations

from dataclasses import field

from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ..budget import Status
from ..engine.actor import Simulated
from ..plan import Plan
from ..planner.lgp import SolveOptions
from ..skeleton import Array
from .actuators import EXACT, Noise
from .settings import SIMULATION


@dataclass(frozen=True, slots=True)
class RunOptions:
    """`horizon` actions get their motion in one window (None: as many as seem wise), whose planning takes `latency`
    simulated seconds."""

    solve: SolveOptions
    horizon: int | None = SIMULATION.horizon
    noise: Noise = EXACT
    seed: int = 0
    latency: float = SIMULATION.latency
    engine: str | None = None
    """Of the world: "mujoco", or None where drives miss what they are told by noise alone."""


@dataclass(frozen=True, slots=True)
class RunProgress:
    """Where a run stands: simulated seconds, actions done, actions left on the way that is known."""

    message: str
    time: float
    done: int
    left: int
    elapsed: float


@dataclass(slots=True)
class RunOutcome:
    """`plan` holds what was carried out,
    verified where there was time for it; it is not `complete` unless the goal is reached. `commanded` and `driven`
    joint values `(T, n)` are those at its time stamps."""

    status: Status
    plan: Plan
    explanation: list[Diagnostic] = field(default_factory=list)
    commanded: dict[str, Array] = field(default_factory=dict)
    driven: dict[str, Array] = field(default_factory=dict)
    carried: Simulated | None = None
    """What a physics engine found."""
