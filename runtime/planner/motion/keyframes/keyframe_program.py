"""The program of P_seq: one slice per phase, which is its switch (thesis section 3.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from .....compiler.ir import Arith, Fact, Function, Problem, Row, Term, Var, Vector
from .....compiler.kept_pairs import kept_pairs
from .....compiler.motion.bolted import bolted
from .....compiler.motion.collision import Pair, contacts
from .....compiler.motion.permanent import permanent
from ....budget import Budget
from ....geometry.attachments import POSE, carrier, followers, involved, next_mode, still_entries
from ....geometry.drives import ringed
from ....geometry.start_contacts import pressed_in
from ....skeleton import Array, Breach, Configuration, Skeleton, Violation
from ..collision.clearance_rows import Clearances
from ..collision.pairs_in_phases import Collisions, Margins, refresh, rows
from ..nlp.augmented_lagrangian import SolverOptions, SolverResult, SolverStatus, project, solve
from ..nlp.features import Features, differences, homing, kept_limits, norms
from ..nlp.loaded_features import LoadedLiteral, loaded_groups, speaks
from ..nlp.program import Program
from ..nlp.row_groups import LinearGroup, RowGroup
from ..nlp.settings import SOLVER
from ..nlp.unknowns import ORIGIN, UnknownsLayout
from ..settings import MotionSettings
from .bearing_rows import bearing_rows
from .placement_samples import places
from .settings import KEYFRAMES

VERTICAL = frozenset({"top", "bottom", "inside"})
"""Functions that know where up is."""
CLEARANCES = (Breach.COLLISION, Breach.SELF_COLLISION)
POLISH = SolverOptions(mu=1e4, damping=1e-3, iterations=60)


class SwitchProgram:
    """P_seq of phases `first` … `last` of a skeleton, from `start`, the state before `first`, to `end` where that is
    given: what a phase is the last to move comes to rest as it is there.

    With `free` the state before is unknown too, but for what never moved before: it satisfies the relations of its
    mode. With `frozen`, robots that a switch does not concern stay where they are, with `still` also the joints that
    lie on closed rings.
    """

    def __init__(
        self, skeleton: Skeleton, first: int, last: int, start: Configuration, settings: MotionSettings,
        free: bool = False, frozen: bool = True, end: Configuration | None = None, still: bool = False,
    ) -> None:  # fmt: skip
        self.skeleton = skeleton
        self.problem: Problem = skeleton.problem
        self.phases = range(first, last + 1)
        self.settings = settings
        moving = [self._moving(phase, frozen) for phase in self.phases]
        self.layout = UnknownsLayout(self.problem.world, start, _settled(moving, end) if end else None)
        if free:
            self.layout.free_start(self._moved_before(first), dict.fromkeys(self._bolted_until(first), POSE))
        for phase, names in zip(self.phases, moving, strict=True):
            self.layout.add_slice(names, self._held(phase, still))
        self._features = Features(self.problem, self.layout)
        if free:
            self._standing()
        self._literals()
        self._rows = self._all_rows()
        self._costs = self._usual_costs()
        self._tidied = self._tidy()
        self._free = free
        self._loads: list[RowGroup] = []

    def _moving(self, phase: int, frozen: bool) -> frozenset[str]:
        """What has a slot of its own at the switch that ends a phase."""
        modules = involved(self.skeleton, phase) if frozen else frozenset(self.problem.world.modules)
        return modules | followers(self.problem, self.skeleton.phases[phase].mode)

    def _held(self, phase: int, still: bool) -> Mapping[str, frozenset[int]]:
        """The entries of slots that keep their values in a phase."""
        mode = self.skeleton.phases[phase].mode
        held = still_entries(self.problem, mode)
        if not still:
            return held
        rings = {name: frozenset(7 + i for i in joints) for name, joints in ringed(self.problem, mode).items()}
        return {name: held.get(name, frozenset()) | rings.get(name, frozenset()) for name in held.keys() | rings.keys()}

    def _moved_before(self, first: int) -> frozenset[str]:
        moved = set(self.problem.world.modules)
        for phase in self.skeleton.phases[:first]:
            moved |= followers(self.problem, phase.mode)
        return frozenset(moved)

    def _bolted_until(self, phase: int) -> frozenset[str]:
        """The modules that have stayed where the scene puts them."""
        modes = [p.mode for p in self.skeleton.phases[: phase + 1]]
        return frozenset(self.problem.world.modules).intersection(*(bolted(self.problem, mode) for mode in modes))

    def _standing(self) -> None:
        """At a free start the rows that held when a literal of the mode was added still hold where a kept pose has
        carried them on: in the world where one of the two rests, else those that compare the two alone. What no
        action can undo is kept since the start."""
        first = self.phases[0]
        mode = self.skeleton.phases[first].mode
        moving = followers(self.problem, mode) | self.problem.world.modules.keys()
        kept = {frozenset(pair): pair for pair in kept_pairs(self.problem, mode)}
        for literal in sorted(mode):
            pair = kept.get(frozenset(literal[1:]))
            if pair is None:
                continue
            anchored = carrier(self.problem, pair[0]) not in moving
            if anchored or not any(_absolute(row) for row in self.problem.motions[literal[0]].rows):
                self._features.add(literal, "switch", (0,), first)
        for literal in sorted(permanent(self.problem)):
            self._features.add(literal, "keep", (ORIGIN, 0), first)

    def _literals(self) -> None:
        for slice_, phase in enumerate(self.phases, start=1):
            for literal in sorted(self.skeleton.phases[phase].added):
                self._features.add(literal, "switch", (slice_,), phase, self._weight(phase))
            mode = self.skeleton.phases[phase].mode
            for literal in sorted(mode - self._excused(phase)):
                self._features.add(literal, "keep", (slice_ - 1, slice_), phase)
            for literal in sorted((mode | next_mode(self.skeleton, phase)) - self._excused(phase)):
                self._features.add(literal, "during", (slice_,), phase)

    def _excused(self, phase: int) -> frozenset[Fact]:
        """The literals that ask nothing of a phase while they last."""
        return frozenset()

    def _weight(self, phase: int) -> float:
        """The scale of the rows of what a phase adds."""
        return 1.0

    def _loaded(self) -> list[LoadedLiteral]:
        """What rows about loads bind where, before and after each switch."""
        found: list[LoadedLiteral] = []
        for slice_, phase in enumerate(self.phases, start=1):
            after = next_mode(self.skeleton, phase)
            for literal in sorted(self.skeleton.phases[phase].added):
                found.append((literal, "switch", slice_, phase, after))
            for mode in (self.skeleton.phases[phase].mode, after):
                found += [(literal, "during", slice_, phase, mode) for literal in sorted(mode)]
        return [w for w in found if speaks(self.problem, w[0])]

    def _all_rows(self) -> list[RowGroup]:
        return [
            *self._features.groups(),
            *loaded_groups(self.problem, self.layout, self._loaded()),
            norms(self.layout),
            *self._limits([self.phases[0], *self.phases]),
        ]

    def _usual_costs(self) -> list[LinearGroup]:
        steps = [(t - 1, t) for t in range(1, len(self.layout.slices))]
        velocity = KEYFRAMES.homeward_velocity if self.settings.homeward else KEYFRAMES.velocity_weight
        return [
            homing(self.problem, self.layout, KEYFRAMES.homing_weight),
            differences(self.layout, self.layout.modules, steps, (-1.0, 1.0), velocity),
        ]

    def pull(self, costs: Sequence[LinearGroup]) -> None:
        """From now on these costs stand in for those of joints away from home and of their ways."""
        self._costs = list(costs)

    @property
    def _groups(self) -> list[RowGroup]:
        return [*self._rows, *self._costs, *self._tidied]

    def _limits(self, phase_of: list[int]) -> list[LinearGroup]:
        return kept_limits(self.problem, self.layout, self.settings.limit_margin, phase_of)

    def _tidy(self) -> list[LinearGroup]:
        """½ place_weight² Σ (xy − place)² + ½ turn_weight² Σ (q − q at the start)² over the things that are
        put down where many are laid out, where things must not collide."""
        planned = places(self.skeleton) if self.settings.collisions else {}
        spots: list[tuple[int, float]] = []
        turns: list[tuple[int, float]] = []
        for (phase, name), place in planned.items():
            slice_ = phase - self.phases[0] + 1
            if phase in self.phases and self.layout.is_unknown(slice_, name):
                slot, pose = self.layout.slot(slice_, name), self.problem.world.bodies[name].pose
                spots += zip(slot[:2], place, strict=True)
                turns += zip(slot[3:6], pose[3:6], strict=True)
        return [self._pull(spots, KEYFRAMES.place_weight), self._pull(turns, KEYFRAMES.turn_weight)]

    @staticmethod
    def _pull(targets: Sequence[tuple[int, float]], scale: float) -> LinearGroup:
        """½ scale² Σ (z − target)² over places in z."""
        columns = np.array([at for at, _ in targets], dtype=np.int64).reshape(-1, 1)
        return LinearGroup("cost", columns, np.ones((1, 1)), np.array([t for _, t in targets]), [], scale)

    @cached_property
    def _clearance(self) -> list[Clearances]:
        """The collision rows; made when first asked for, as many spans are refused without them."""
        if not self.settings.collisions:
            return []
        collisions = Collisions(self.problem, self.layout)
        touching = contacts(self.skeleton)
        if self._free:
            contact = touching[self.phases[0]]
            margins = self._margins(contact.during, contact.start, contact.beside)
            collisions.add_slice(0, self.phases[0], margins)
        for slice_, phase in enumerate(self.phases, start=1):
            contact = touching[phase]
            margins = self._margins(contact.during, contact.end, contact.beside)
            collisions.add_slice(slice_, phase, margins, before=slice_ - 1)
        return collisions.clearances()

    def _margins(self, during: frozenset[Pair], meeting: frozenset[Pair], beside: frozenset[Pair]) -> Margins:
        """Contacts are free, but for those of what has several parts, as rows bring only one or two of them together;
        these and what may touch need only not overlap."""
        several = frozenset(pair for pair in meeting if any(name in self._of_parts for name in pair)) - during
        free = (during | meeting) - several
        special: dict[Pair, float | None] = dict.fromkeys(sorted(beside | several), 0.0)
        special.update(dict.fromkeys(sorted(free)))
        least = dict.fromkeys(sorted(several), -KEYFRAMES.met)
        least |= dict.fromkeys(sorted(beside - free), -KEYFRAMES.pressed)
        for pair, depth in pressed_in(self.problem.world).items():
            special.setdefault(pair, 0.0)
            least[pair] = min(least.get(pair, 0.0), -depth)
        return Margins(self.settings.switch_margin, special, least, during | meeting | beside)

    @cached_property
    def _of_parts(self) -> frozenset[str]:
        """The bodies and effectors that are made of several parts."""
        world = self.problem.world
        bodies = frozenset(b.name for b in world.bodies.values() if b.shape.parts)
        ends = ((name, e) for name, module in world.modules.items() for e in module.type.effectors)
        return bodies | {f"{name}.{e.name}" for name, e in ends if e.shape is not None and e.shape.parts}

    def program(self) -> Program:
        """The program over the pairs that take part at present."""
        clearances = rows(self._clearance, KEYFRAMES.wish_scale)
        return Program(self.layout.constants, self.layout.unknowns, [*self._groups, *self._loads, *clearances])

    def bear(self, loops: bool | None) -> int:
        """From now on rows keep loads within strengths, with `loops` also those in closed loops; with None, none do any
        longer. How many groups of them there are."""
        self._loads = []
        if loops is not None:
            self._loads = bearing_rows(self.skeleton, self.layout, self.phases, self._free, loops)
        return len(self._loads)

    @cached_property
    def loose(self) -> Program:
        """The program without collisions."""
        return Program(self.layout.constants, self.layout.unknowns, self._groups)

    def pack(self, configurations: Sequence[Configuration]) -> Array:
        """Unknowns from the configurations of all slices, the state before included."""
        return self.layout.pack(dict(enumerate(configurations)))

    def unpack(self, unknowns: Array) -> list[Configuration]:
        """The configurations of all slices, the state before included."""
        return [self.layout.unpack(unknowns, t) for t in range(len(self.layout.slices))]

    def _refresh(self, x: Array) -> bool:
        return refresh(self._clearance, np.concatenate([self.layout.constants, x]))

    def prepare(self, x: Array) -> None:
        """Take in the pairs that are near at x."""
        self._refresh(x)

    def overlaps(self, x: Array) -> list[Violation]:
        """What is nearer at x than it may be, the worst first."""
        self.prepare(x)
        return [v for v in self.program().violations(x, 0.0) if v.kind in CLEARANCES]

    def solve(self, x: Array, options: SolverOptions, budget: Budget) -> tuple[Program, SolverResult]:
        """Solve from x; pairs that came near meanwhile are taken in and the solve resumes. Raises OutOfTime."""
        self._refresh(x)
        iterations = 0
        for attempt in range(KEYFRAMES.refreshes):
            program = self.program()
            outcome = run(program, x, options if attempt == 0 else POLISH, self.settings, budget)
            iterations += outcome.iterations
            x = outcome.x
            if not self._refresh(x) or outcome.status != SolverStatus.FEASIBLE:
                break
        return self.program(), SolverResult(x, iterations, outcome.status)

    def project(self, x: Array, tolerance: float, budget: Budget) -> tuple[Program, Array]:
        """Project x onto all rows within `tolerance`."""
        program = self.program()
        x = project(program, x, tolerance, budget)
        if self._refresh(x):
            program = self.program()
            x = project(program, x, tolerance, budget)
        return program, x


def _settled(moving: Sequence[frozenset[str]], end: Configuration) -> dict[int, Configuration]:
    """By slice, 1 for the first of the phases: what its phase is the last to move, where it is in the end."""
    found = {}
    later: frozenset[str] = frozenset()
    for slice_, names in reversed(list(enumerate(moving, start=1))):
        modules = {name: slot for name, slot in end.modules.items() if name in names - later}
        found[slice_] = Configuration(modules, {n: pose for n, pose in end.bodies.items() if n in names - later})
        later |= names
    return found


def run(program: Program, x: Array, options: SolverOptions, settings: MotionSettings, budget: Budget) -> SolverResult:
    """The solver that the settings name. Where joints come to the ends of their ranges a run may creep along curved
    rows until it stalls close to feasible; what is left then is projected away."""
    if settings.solver == "ipopt":
        from ..nlp.ipopt import solve_ipopt

        return solve_ipopt(program, x, options, budget)
    outcome = solve(program, x, options, budget)
    if outcome.status == SolverStatus.FEASIBLE or not options.tolerance < program.largest(outcome.x) < SOLVER.nearly:
        return outcome
    nearest = project(program, outcome.x, options.tolerance, budget)
    if program.largest(nearest) > options.tolerance:
        return outcome
    return SolverResult(nearest, outcome.iterations, SolverStatus.FEASIBLE)


def _absolute(row: Row) -> bool:
    """Whether a switch row refers to the vertical or to the world, not to the two objects alone."""
    if row.when != "switch":
        return False
    variables, functions = _mentions(row)
    return bool(functions & VERTICAL) or len(variables) < 2


def _mentions(row: Row) -> tuple[frozenset[str], frozenset[str]]:
    """The names of the variables and of the functions in a row."""
    variables, functions = set[str](), set[str]()
    waiting: list[Term | None] = [row.left, row.right]
    while waiting:
        match waiting.pop():
            case Var(name=name):
                variables.add(name)
            case Function(name=name, args=arguments):
                functions.add(name)
                waiting += arguments
            case Arith(operands=operands):
                waiting += operands
            case Vector(items=items):
                waiting += items
    return frozenset(variables), frozenset(functions)
