"""Whether robots bear themselves: at switch configurations, along paths, and how slowly they must move to do so.

With `physics` on, every load times `safety` stays within what is stated. Load and strength come from
`compiler/physics`; what is exceeded becomes a `Violation` that names the joint or pair and the line of its strength.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ....compiler.ir import Chain, Fact, Problem
from ....compiler.physics.frames import GRAVITY, STILL, node_weights, poses
from ....compiler.physics.masses import body_mass
from ....compiler.physics.records import CONTACTS
from ....compiler.physics.safety import safety_of
from ....compiler.physics.statics import Load, loads
from ....compiler.physics.structure import Edge, Node, Structure, stated_at, structure
from ....langs.frozen import dataclass
from ...geometry.attachments import next_mode
from ...geometry.splines import spline_weights
from ...skeleton import Array, BoundResult, Breach, Configuration, Phase, PhasePath, Skeleton, Violation
from .least_moments import far_out
from .lone_holds import lone_holders
from .nearness import joined_pairs
from .settings import STATICS

BREACHES = {"torque": Breach.TORQUE, "bearing": Breach.BEARING, "dock": Breach.DOCK, "foot": Breach.FOOT,
            "slip": Breach.SLIP, "tip": Breach.TIP}


def asked(problem: Problem) -> bool:
    """Whether the task wants robots to bear themselves."""
    return problem.options.physics in ("statics", "dynamics")


def kept_at_rest(problem: Problem) -> float:
    """What is used of a strength at rest."""
    return STATICS.kept_moving if problem.options.physics == "dynamics" else STATICS.kept


def _violations(
    problem: Problem, found: Sequence[Load], phase: int, moments: Sequence[str], kept: float
) -> list[Violation]:
    """What is loaded by more than is `kept` of its strength; `moments` tells when each sample is."""
    told = []
    for load in found:
        worst = int(np.argmax(load.ratio))
        if load.ratio[worst] > kept:
            safety = safety_of(problem.options)
            excess = float(safety * load.amount[worst] - kept * load.strength)
            names, span = load.edge.names, stated_at(problem, load.edge)
            borne = float(load.amount[worst]), safety, load.strength
            told.append(
                Violation(phase, BREACHES[load.kind], names, excess, load.unit or "1", span, load=borne,
                          when=moments[worst])
            )  # fmt: skip
    return sorted(told, key=lambda v: (-v.amount, v.names, v.kind))


def exceeded(
    problem: Problem, mode: frozenset[Fact], modules: Mapping[str, Array], bodies: Mapping[str, Array], phase: int,
    moments: Sequence[str], moved: frozenset[Node] = frozenset(),
) -> list[Violation]:  # fmt: skip
    """What is too heavily loaded at rest in these samples, largest excess first. `moments` tells when each is, `moved`
    which joints move besides those that do so in these samples: their brakes bear nothing."""
    at = poses(problem, modules, bodies)
    at = replace(at, moved=at.moved | moved)
    found = loads(problem, mode, at, safety_of(problem.options))
    return _violations(problem, found, phase, moments, kept_at_rest(problem))


def exceeded_at(
    problem: Problem, mode: frozenset[Fact], at: Configuration, phase: int, moment: str,
    moved: frozenset[Node] = frozenset(),
) -> list[Violation]:  # fmt: skip
    """What is too heavily loaded in one configuration, in which `moved` joints begin or end to move."""
    modules = {name: row[None] for name, row in at.modules.items()}
    bodies = {name: row[None] for name, row in at.bodies.items()}
    return exceeded(problem, mode, modules, bodies, phase, [moment], moved)


def _moved(before: Configuration, after: Configuration) -> frozenset[Node]:
    """The joints that move from one configuration to another."""
    return frozenset(
        (name, int(k)) for name, row in after.modules.items()
        for k in np.flatnonzero(np.abs(row[7:] - before.modules[name][7:]) > STILL)
    )  # fmt: skip


def exceeded_switches(skeleton: Skeleton, first: int, slices: Sequence[Configuration], free: bool) -> list[Violation]:
    """What is too heavily loaded at the switches of phases from `first` on, before and after each; `slices` begins with
    the state before, which counts where it is `free`."""
    problem = skeleton.problem
    if not asked(problem):
        return []
    moves = [_moved(before, after) for before, after in pairwise(slices)] + [frozenset[Node]()]
    mode = skeleton.phases[first].mode
    found = exceeded_at(problem, mode, slices[0], first, "at the start", moves[0]) if free else []
    for k, switch in enumerate(slices[1:]):
        phase, now, then = first + k, moves[k], moves[k + 1]
        found += exceeded_at(problem, skeleton.phases[phase].mode, switch, phase, "at the switch", now)
        found += exceeded_at(problem, next_mode(skeleton, phase), switch, phase, "right after the switch", then)
    return sorted(found, key=lambda v: -v.amount)


def exceeded_on(skeleton: Skeleton, phase: int, path: PhasePath, before: Configuration) -> list[Violation]:
    """What is too heavily loaded on the way through a phase."""
    shares = np.linspace(0.0, 1.0, STATICS.looked_at)
    modules, bodies = _sampled(path, before, shares)
    mode = skeleton.phases[phase].mode
    return exceeded(skeleton.problem, mode, modules, bodies, phase, _moments(shares * path.duration))


def borne(skeleton: Skeleton, result: BoundResult) -> BoundResult:
    """A feasible result of paths, refused where something is too heavily loaded on the way."""
    if not result.feasible or not asked(skeleton.problem):
        return result
    found: list[Violation] = []
    now = result.configurations[0]
    for phase, path in enumerate(result.paths):
        found += exceeded_on(skeleton, phase, path, now)
        now = result.configurations[phase + 1]
    if not found:
        return result
    return replace(result, feasible=False, violations=sorted(found, key=lambda v: -v.amount))


def _sampled(path: PhasePath, before: Configuration, share: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Everything at shares of the phase's time. Module poses between samples are those of splines through them: at most
    micrometres off what the joints give."""
    last = path.samples - 1
    weights = spline_weights(last, share * last) if last > 1 else np.stack([1.0 - share, share], axis=1)
    modules = {name: weights @ rows for name, rows in path.modules.items()}
    bodies = {name: np.repeat(pose[None], len(share), axis=0) for name, pose in before.bodies.items()}
    bodies |= {name: weights @ rows for name, rows in path.bodies.items()}
    return modules, bodies


@dataclass(frozen=True, slots=True)
class Unbearable:
    """What no posture bears at or after the switch of a phase, whatever comes before it; where `from_start`, as long as
    just what comes before it does."""

    phase: int
    told: tuple[Violation, ...]
    from_start: bool


def unbearable(skeleton: Skeleton) -> Unbearable | None:
    """The first that no posture could bear: at a switch, joints and pairs that hold less than the least moment of what
    must reach so far; after it, pairs that hold less than what hangs on them weighs, however it hangs. Of the latter an
    action that names whole chains tells all, another one not who else holds the thing."""
    problem = skeleton.problem
    if not asked(problem):
        return None
    joined = joined_pairs(problem, skeleton.phases)
    for phase, now in enumerate(skeleton.phases):
        far = far_out(problem, now.mode, now.added, joined[phase], phase)
        after = next_mode(skeleton, phase)
        told = far or _too_heavy(problem, after, phase)
        if told:
            chains = any(isinstance(a, Chain) for a in now.action.args)
            return Unbearable(phase, tuple(told), bool(far) or not (chains or _always(problem, now, after, told)))
    return None


def _always(problem: Problem, now: Phase, after: frozenset[Fact], told: Sequence[Violation]) -> bool:
    """Whether what is told of a thing is so whatever came before: what alone holds it then bears less than it weighs.
    """
    for name in sorted({n for violation in told for n in violation.names} & problem.world.bodies.keys()):
        holders = lone_holders(problem, now, name)
        pairs = [frozenset((holder, name)) for holder in holders]
        edges = [e for e in structure(problem, after).all if frozenset(e.names) in pairs and e.manner not in CONTACTS]
        weight = safety_of(problem.options) * GRAVITY * body_mass(problem.world.bodies[name])
        if holders and len(edges) == len(holders) and weight > sum(_most(e) for e in edges):
            return True
    return False


def _too_heavy(problem: Problem, mode: frozenset[Fact], phase: int) -> list[Violation]:
    built = structure(problem, mode)
    if built.loops:
        return _hangs_on_too_little(problem, built, phase)
    masses = {node: weight.mass for node, weight in node_weights(problem, [e.child for e in built.edges]).items()}
    found = []
    for edge in reversed(built.edges):
        mass = masses.get(edge.child, 0.0)
        masses[edge.parent] = masses.get(edge.parent, 0.0) + mass
        if edge.hold is None or edge.manner in CONTACTS:
            continue
        told = _overloaded(problem, edge, mass, _most(edge), phase)
        found += [told] if told is not None else []
    return sorted(found, key=lambda v: (-v.amount, v.names))


def _hangs_on_too_little(problem: Problem, built: Structure, phase: int) -> list[Violation]:
    """Things in closed loops that weigh more than all pairs that hold them bear together, however they hang."""
    found = []
    for name, body in problem.world.bodies.items():
        edges = [e for e in built.all if (name, -1) in (e.parent, e.child)]
        if not body.movable or not edges or any(e.hold is None or e.manner in CONTACTS for e in edges):
            continue
        told = _overloaded(problem, edges[0], body_mass(body), sum(_most(e) for e in edges), phase)
        found += [told] if told is not None else []
    return found


def _overloaded(problem: Problem, edge: Edge, mass: float, most: float, phase: int) -> Violation | None:
    """That a pair, or it with others, bears `most`, N, and not so many kilograms."""
    safety, weight = safety_of(problem.options), mass * GRAVITY
    if safety * weight <= most:
        return None
    excess, span, load = safety * weight - most, stated_at(problem, edge), (weight, safety, most)
    return Violation(phase, Breach.DOCK, edge.names, excess, "N", span, load=load, when="after the action")


def _most(edge: Edge) -> float:
    """The greatest force that a pair bears in any direction, N."""
    hold = edge.hold
    if hold is None:
        return math.inf
    shear = min(hold.shear, hold.friction * hold.force) if edge.manner == "grip" else hold.shear
    return math.hypot(hold.force, shear)


def slowed(
    skeleton: Skeleton, paths: Sequence[PhasePath], before: Configuration
) -> tuple[list[PhasePath], list[Violation]]:
    """The paths, each as slow as its drives and docks need for the inertia of what they carry; and where no slowness
    helps the first of them, what is too heavily loaded there. With `physics = statics` they stay as they are."""
    problem = skeleton.problem
    if problem.options.physics != "dynamics":
        return list(paths), []
    made: list[PhasePath] = []
    now = before
    for phase, path in enumerate(paths):
        count = max(2, STATICS.fine * (path.samples - 1))
        modules, bodies = _sampled(path, now, np.linspace(0.0, 1.0, count + 1))
        stretch = _stretch(problem, skeleton.phases[phase].mode, modules, bodies, path.duration, count)
        if stretch is None:
            mode, times = skeleton.phases[phase].mode, np.linspace(0.0, path.duration * STATICS.slowest, count + 1)
            found = loads(problem, mode, poses(problem, modules, bodies, times), safety_of(problem.options))
            return list(paths), _violations(problem, found, phase, _moments(times / STATICS.slowest), STATICS.kept)
        made.append(replace(path, duration=math.ceil(path.duration * stretch * 100.0) / 100.0))
        now = Configuration({n: rows[-1] for n, rows in modules.items()}, {n: rows[-1] for n, rows in bodies.items()})
    return made, []


def _moments(times: Array) -> list[str]:
    return [f"{time:.3g} s into the motion" for time in times]


def _stretch(
    problem: Problem, mode: frozenset[Fact], modules: Mapping[str, Array], bodies: Mapping[str, Array],
    duration: float, count: int,
) -> float | None:  # fmt: skip
    """The least factor of the duration with which all loads keep their strengths, by halving: inertia falls with its
    square."""

    def fits(factor: float) -> bool:
        times = np.linspace(0.0, duration * factor, count + 1)
        found = loads(problem, mode, poses(problem, modules, bodies, times), safety_of(problem.options))
        return all(float(load.ratio.max()) <= STATICS.kept for load in found)

    if fits(1.0):
        return 1.0
    low, high = 1.0, 2.0
    while not fits(high):
        low, high = high, 2.0 * high
        if high > STATICS.slowest:
            return None
    while high / low > 1.01:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high
