"""The program of P_path: phases that follow each other over all their slices, and one solve of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .....compiler.ir import Fact, Problem
from .....compiler.motion.collision import Pair, PhaseContacts, contacts, taper
from ....budget import Budget
from ....geometry.attachments import followers, involved, next_mode, still_entries
from ....skeleton import Array, Bound, BoundResult, Breach, Configuration, PhasePath, Skeleton
from ..collision.clearance_rows import Clearances
from ..collision.pairs_in_phases import Collisions, Margins, refresh, rows
from ..keyframes.bearing_rows import bearing_groups
from ..keyframes.keyframe_program import run
from ..nlp.augmented_lagrangian import PATH, SolverOptions, SolverStatus, project
from ..nlp.features import Features, differences, homing, kept_limits, norms
from ..nlp.loaded_features import LoadedLiteral, loaded_groups, speaks
from ..nlp.program import Program
from ..nlp.row_groups import RowGroup
from ..nlp.unknowns import UnknownsLayout
from ..settings import MotionSettings
from ..time_scaling import shortest_duration
from .path_guesses import interpolate
from .settings import PATHS

RESUME = replace(PATH, damping=1e-3, iterations=60)
ACCURATE = 1e-6
STILL = 1e-9


class PathProgram:
    """Slices 1 … T of every phase after the start; slice (k + 1) T is the switch of the k-th of `phases`, which are
    all phases unless said otherwise. `switches` begin with the configuration before the first of them. With `bears`
    loads at rest keep within strengths at all slices."""

    def __init__(
        self, skeleton: Skeleton, settings: MotionSettings, switches: Sequence[Configuration], pinned: bool,
        phases: range | None = None, bears: bool = False,
    ) -> None:  # fmt: skip
        self.skeleton = skeleton
        self.problem: Problem = skeleton.problem
        self.settings = settings
        self.pinned, self.bears = pinned, bears
        self.strict = True
        """Whether margins are held to, and not only wished for."""
        self.phases = range(len(skeleton)) if phases is None else phases
        self.count = settings.slices
        given = {k * self.count: c for k, c in enumerate(switches) if k} if pinned else None
        self.layout = UnknownsLayout(self.problem.world, switches[0], given)
        self.moving: list[frozenset[str]] = []
        for k, phase in enumerate(self.phases):
            carried = followers(self.problem, skeleton.phases[phase].mode)
            active = involved(skeleton, phase) | displaced(switches[k], switches[k + 1]) | carried
            held = still_entries(self.problem, skeleton.phases[phase].mode)
            self.moving.append(active)
            for _ in range(self.count):
                self.layout.add_slice(active, held)
        self._features = Features(self.problem, self.layout)
        self._literals()
        self._groups = self._all_groups()
        self.clearances = self._collisions() if settings.collisions else []

    def _slices(self, k: int) -> range:
        """The slices of the k-th phase, the switch before included."""
        return range(k * self.count, (k + 1) * self.count + 1)

    def _literals(self) -> None:
        for k, number in enumerate(self.phases):
            slices, phase = self._slices(k), self.skeleton.phases[number]
            if not self.pinned:
                for literal in sorted(phase.added):
                    self._features.add(literal, "switch", (slices[-1],), number, PATHS.stiffness)
            for t in slices[1:]:
                if self.pinned and t == slices[-1]:
                    continue
                before = slices[0] if self.pinned else t - 1
                for literal in sorted(phase.mode):
                    self._features.add(literal, "keep", (before, t), number, PATHS.stiffness)
                    self._features.add(literal, "during", (t,), number)
            if not self.pinned:
                for literal in sorted(next_mode(self.skeleton, number)):
                    self._features.add(literal, "during", (slices[-1],), number)

    def _loaded(self) -> list[LoadedLiteral]:
        """What rows about loads bind where."""
        found: list[LoadedLiteral] = []
        for k, number in enumerate(self.phases):
            slices, phase = self._slices(k), self.skeleton.phases[number]
            after = next_mode(self.skeleton, number)
            for t in slices[1:-1] if self.pinned else slices[1:]:
                found += [(literal, "during", t, number, phase.mode) for literal in sorted(phase.mode)]
            if not self.pinned:
                found += [(literal, "switch", slices[-1], number, after) for literal in sorted(phase.added)]
                found += [(literal, "during", slices[-1], number, after) for literal in sorted(after)]
        return [w for w in found if speaks(self.problem, w[0])]

    def _bearing(self) -> list[RowGroup]:
        """Rows that keep loads within strengths, where they are asked for."""
        if not self.bears:
            return []
        found: list[tuple[int, int, frozenset[Fact]]] = []
        for k, number in enumerate(self.phases):
            slices, mode = self._slices(k), self.skeleton.phases[number].mode
            found += [(t, number, mode) for t in slices[1:-1]]
            if not self.pinned:
                found += [(slices[-1], number, m) for m in (mode, next_mode(self.skeleton, number))]
        return bearing_groups(self.problem, self.layout, found)

    def _all_groups(self) -> list[RowGroup]:
        step = 1.0 / self.count
        bending = PATHS.acceleration_weight * step**-1.5
        triples: list[tuple[int, ...]] = []
        phase_of = [self.phases[0]]
        for k, phase in enumerate(self.phases):
            slices = self._slices(k)
            inner = [slices[0], *slices, slices[-1]]
            triples += zip(inner, inner[1:], inner[2:], strict=False)
            phase_of += [phase] * self.count
        return [
            *self._features.groups(),
            *loaded_groups(self.problem, self.layout, self._loaded()),
            *self._bearing(),
            norms(self.layout),
            *kept_limits(self.problem, self.layout, self.settings.limit_margin / 3, phase_of, PATHS.least_inset),
            homing(self.problem, self.layout, PATHS.homing_weight * step**0.5),
            differences(self.layout, self.layout.modules, triples, (1.0, -2.0, 1.0), bending),
        ]

    def _collisions(self) -> list[Clearances]:
        collisions = Collisions(self.problem, self.layout)
        touching = contacts(self.skeleton)
        for k, phase in enumerate(self.phases):
            for u, t in enumerate(self._slices(k)):
                if u and not (self.pinned and u == self.count):
                    collisions.add_slice(t, phase, self._margins(touching[phase], u), before=t - 1)
        return collisions.clearances()

    def _margins(self, contact: PhaseContacts, u: int) -> Margins:
        special: dict[Pair, float | None] = dict.fromkeys(sorted(contact.during))
        for objects in sorted((contact.start | contact.end) - contact.during):
            share = taper(contact, objects, np.array([float(u)]), self.count)
            ahead = share is not None and share[0] > 0.0
            special[objects] = self.settings.margin * float(share[0]) if ahead and share is not None else None
        margin, apart = self.settings.margin, PATHS.least_clearance
        least = {p: m * apart / margin for p, m in special.items() if m and margin > apart}
        special.update(dict.fromkeys(sorted(contact.beside), 0.0))
        return Margins(self.settings.margin, special, least)

    def program(self) -> Program:
        """The program over the pairs that take part at present."""
        clearances = rows(self.clearances, None if self.strict else PATHS.wish_scale)
        return Program(self.layout.constants, self.layout.unknowns, [*self._groups, *clearances])

    def refresh(self, x: Array) -> bool:
        """Take in the pairs that are near at x; whether one that was left out is violated."""
        return refresh(self.clearances, np.concatenate([self.layout.constants, x]))

    def start(
        self, switches: Sequence[Configuration], bumps: Sequence[dict[str, Array] | None]
    ) -> list[Configuration]:
        """All slices, interpolated between the switch configurations."""
        slices = [switches[0]]
        for k, phase in enumerate(self.phases):
            mode = self.skeleton.phases[phase].mode
            slices += interpolate(
                self.problem, mode, self.moving[k], switches[k], switches[k + 1], self.count, bumps[k]
            )  # fmt: skip
        return slices

    def pack(self, slices: Sequence[Configuration]) -> Array:
        return self.layout.pack(dict(enumerate(slices)))

    def unpack(self, x: Array) -> list[Configuration]:
        return [self.layout.unpack(x, t) for t in range(len(self.layout.slices))]

    def paths(self, slices: Sequence[Configuration]) -> list[PhasePath]:
        """The motion of each phase."""
        found = []
        for k in range(len(self.phases)):
            part = [slices[t] for t in self._slices(k)]
            modules = {n: _continuous([c.modules[n] for c in part]) for n in self.layout.modules}
            bodies = {n: _continuous([c.bodies[n] for c in part]) for n in self.layout.bodies if n in self.moving[k]}
            found.append(PhasePath(modules, bodies, shortest_duration(self.problem.world, modules)))
        return found


def displaced(before: Configuration, after: Configuration) -> frozenset[str]:
    """The modules that two switches do not show in the same place."""
    return frozenset(n for n, slot in before.modules.items() if np.abs(slot - after.modules[n]).max() > STILL)


def _continuous(slots: Sequence[Array]) -> Array:
    """Stacked slots with quaternions of like sign."""
    track = np.array(slots)
    for i in range(1, len(track)):
        if track[i, 3:7] @ track[i - 1, 3:7] < 0:
            track[i, 3:7] *= -1
    return track


def attempt(
    path: PathProgram, x: Array, settings: MotionSettings, budget: Budget, options: SolverOptions,
    most: int | None = None,
) -> tuple[BoundResult, Array]:
    """One solve from x of `most` iterations that holds to the margins, which keeps the spline between slices clear too;
    where they cannot be had, one from there that wishes for them. Raises OutOfTime."""
    path.strict = True
    result, reached = _attempt(path, x, settings, budget, options, most)
    near = any(v.kind in (Breach.COLLISION, Breach.SELF_COLLISION) for v in result.violations)
    left = None if most is None else most - result.iterations
    if near and (left is None or left > 0):
        path.strict = False
        before = result.iterations
        result, reached = _attempt(path, reached, settings, budget, RESUME, left)
        result.iterations += before
    return result, reached


def _attempt(
    path: PathProgram, x: Array, settings: MotionSettings, budget: Budget, options: SolverOptions, most: int | None
) -> tuple[BoundResult, Array]:
    """One solve, resumed when pairs came near meanwhile, and projected when it is feasible."""
    iterations = 0
    path.refresh(x)
    for number in range(PATHS.refreshes):
        chosen = options if number == 0 else RESUME
        if most is not None:
            chosen = replace(chosen, iterations=min(chosen.iterations, most - iterations))
        outcome = run(path.program(), x, chosen, settings, budget)
        iterations += outcome.iterations
        x = outcome.x
        if not path.refresh(x) or outcome.status != SolverStatus.FEASIBLE or iterations == most:
            break
    program = path.program()
    if program.largest(x) <= settings.tolerance:
        x = project(program, x, ACCURATE, budget)
    feasible = program.largest(x) <= settings.tolerance
    violations = [] if feasible else program.violations(x, settings.tolerance)
    slices = path.unpack(x)
    configurations = slices[:: path.count]
    bound = Bound.SEQ_PATH if path.pinned else Bound.PATH
    paths = path.paths(slices) if feasible else []
    result = BoundResult(bound, feasible, program.cost(x), 0.0, iterations, configurations, paths, violations)
    return result, x
