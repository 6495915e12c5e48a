"""Ways of one phase around what is in the way, where rows bind all along: trees of states that are projected onto the
rows (CBiRRT, Berenson et al. 2009), grown from both ends.

A state is known by the values of the joints that move: poses follow from the kept relations, and the projection closes
what these leave open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .....compiler.motion.collision import PhaseContacts
from ....budget import Budget
from ....geometry.transforms import coupled
from ....skeleton import Array, Configuration, Skeleton
from ..collision.pairs_in_phases import Margins
from ..nlp.unknowns import Indices
from ..phases.rrt_connect import connect, resample, shorten
from ..phases.settings import PHASES
from ..settings import MotionSettings
from .path_guesses import Carried
from .path_program import PathProgram
from .settings import PATHS


class _States(PathProgram):
    """States of a phase that are nothing to each other, one for each slice between its two switches."""

    def _margins(self, contact: PhaseContacts, u: int) -> Margins:
        """What meets or parts in the phase may touch all along."""
        meeting = sorted((contact.start | contact.end) - contact.during)
        special: dict[tuple[str, str], float | None] = dict.fromkeys([*meeting, *sorted(contact.beside)], 0.0)
        special.update(dict.fromkeys(sorted(contact.during)))
        return Margins(0.0, special, dict.fromkeys(meeting, -PHASES.contact_tolerance))


class _Space:
    """The states of one phase by their joint values `(joints,)`, and edges along what its rows leave free."""

    def __init__(
        self, skeleton: Skeleton, phase: int, before: Configuration, after: Configuration, settings: MotionSettings,
        budget: Budget,
    ) -> None:  # fmt: skip
        alike = replace(settings, slices=PHASES.edges + 1)
        self._states = _States(skeleton, alike, [before, after], True, range(phase, phase + 1))
        self._program, self._layout = self._states.program(), self._states.layout
        self._before, self._after, self._budget = before, after, budget
        self._types = {m.name: m.type for m in skeleton.problem.world.modules.values()}
        self._carried = Carried(skeleton.problem, skeleton.phases[phase].mode, before)
        self._entries = [(name, entry) for name in self._layout.modules for entry in self._free(name)]
        slices = range(1, PHASES.edges + 1)
        self._columns = np.array([[self._layout.slot(t, n)[e] for n, e in self._entries] for t in slices], dtype=int)
        groups = [group for kind in ("equality", "inequality") for group in self._program.groups[kind]]
        self._rows = [(group, self._state_of(group.span())) for group in groups]
        self._parts = self._part_states()
        self.start, self.end = self._values(before), self._values(after)
        joints = [self._types[name].joints[entry - 7] for name, entry in self._entries]
        inset = PHASES.limit_inset
        self.lower = np.minimum([j.lower + inset for j in joints], np.minimum(self.start, self.end))
        self.upper = np.maximum([j.upper - inset for j in joints], np.maximum(self.start, self.end))

    def _free(self, name: str) -> list[int]:
        """The entries of a module's slot that are unknown values of joints which follow no other."""
        slot = self._layout.slot(1, name)
        return [int(entry) for entry in self._layout.joints(name) if slot[entry] >= self._layout.first_unknown]

    def _state_of(self, places: Indices) -> Indices:
        """Which state rows `(n, columns)` are about; −1 for those about none. All states have as many unknowns."""
        each = self._layout.unknowns // PHASES.edges
        return np.asarray((places.max(axis=1) - self._layout.first_unknown) // each)

    def _part_states(self) -> Indices:
        """The state in which each part is; −1 for what rests."""
        if not self._states.clearances:
            return np.zeros(0, dtype=int)
        cloud, world = self._states.clearances[0].cloud, self._states.problem.world
        solid = world.modules.keys() | {body.name for body in world.solids}
        found = np.full(cloud.count, -1)
        for name in sorted(self._states.moving[0] & solid):
            for t in range(1, PHASES.edges + 1):
                if self._layout.is_unknown(t, name):
                    first = cloud.first(t, name)
                    found[first : first + len(cloud.parts(name))] = t - 1
        return found

    def _values(self, state: Configuration) -> Array:
        return np.array([state.modules[name][entry] for name, entry in self._entries])

    def state(self, values: Array) -> Configuration:
        """Joint values `(joints,)` with the poses that kept relations give."""
        state = self._before.copy()
        for (name, entry), value in zip(self._entries, values, strict=True):
            state.modules[name][entry] = value
        for name in dict.fromkeys(name for name, _ in self._entries):
            slot = state.modules[name]
            slot[7:] = coupled(self._types[name].joints, slot[7:])
        self._carried.settle(state, self._states.moving[0])
        return state

    def near(self, goals: Array) -> Array:
        """Goals `(m, joints)` put onto the rows, as far as they come."""
        z = self._onto(goals, PATHS.goal_projections, PATHS.goal_stride)
        return np.asarray(np.clip(z[self._columns][: len(goals)], self.lower, self.upper))

    def _onto(self, values: Array, steps: int, stride: float) -> Array:
        """z of states `(m, joints)`, at most as many as edges grow at a time, put onto the rows."""
        left = PHASES.edges - len(values)
        states = [*map(self.state, values), *[self._before] * left]
        x = self._states.pack([self._before, *states, self._after])
        for _ in range(steps):
            self._budget.check()
            step, _ = self._program.violated(x, self._program.residuals(x)).step(PATHS.tree_damping)
            x = x + np.clip(step, -stride, stride)
            if np.abs(step).max(initial=0.0) < PATHS.tree_accuracy:
                break
        return self._program.full(x)

    def _projected(self, values: Array) -> tuple[Array, NDArray[np.bool_]]:
        """States put onto the rows, and whether they are free there."""
        z = self._onto(values, PATHS.tree_projections, PATHS.tree_stride)
        return z[self._columns][: len(values)], (self._kept(z) & self._clear(z))[: len(values)]

    def _kept(self, z: Array) -> NDArray[np.bool_]:
        """The states whose rows hold."""
        worst = np.zeros(PHASES.edges)
        for group, states in self._rows:
            residuals = group.residuals(z) / group.scale
            missed = (np.abs(residuals) if group.kind == "equality" else residuals).max(axis=1)
            about = states >= 0
            np.maximum.at(worst, states[about], missed[about])
        return worst <= PATHS.tree_accuracy

    def _clear(self, z: Array) -> NDArray[np.bool_]:
        """The states in which nothing overlaps."""
        clear = np.ones(PHASES.edges, dtype=bool)
        for clearances in self._states.clearances:
            pairs, distance = clearances.near(z)
            first = self._parts[pairs.first]
            state = np.maximum(first, self._parts[pairs.second]) if clearances.among else first
            clear[state[distance < pairs.least - PHASES.touching]] = False
        return clear

    def ways(self, root: Array) -> Sequence[Array]:
        """No ways are known from a state but those that are searched."""
        return ()

    def advance(self, starts: Array, goals: Array) -> tuple[Array, NDArray[np.bool_]]:
        """How far edges `(m, joints)` lead along the rows: their last states `(m, joints)`, and whether these are the
        goals `(m,)`. An edge ends where it is blocked, gets no nearer or jumps."""
        lots = range(0, len(starts), PHASES.edges)
        found = [self._advance(starts[k : k + PHASES.edges], goals[k : k + PHASES.edges]) for k in lots]
        return np.concatenate([reached for reached, _ in found]), np.concatenate([met for _, met in found])

    def _advance(self, starts: Array, goals: Array) -> tuple[Array, NDArray[np.bool_]]:
        reached, stride = starts.copy(), PATHS.tree_stride
        far = np.linalg.norm(goals - starts, axis=1)
        going = far > PATHS.tree_met
        met = ~going
        while going.any():
            rows = np.flatnonzero(going)
            way = goals[rows] - reached[rows]
            ahead = reached[rows] + way * np.minimum(1.0, stride / np.abs(way).max(axis=1))[:, None]
            states, good = self._projected(ahead)
            left = np.linalg.norm(goals[rows] - states, axis=1)
            good &= (np.abs(states - reached[rows]).max(axis=1) <= 2.0 * stride) & (left < far[rows])
            reached[rows[good]], far[rows[good]] = states[good], left[good]
            arrived = good & (left <= PATHS.tree_met)
            met[rows[arrived]] = True
            going[rows[~good | arrived]] = False
        return reached, met


def sampled_way(
    skeleton: Skeleton, phase: int, before: Configuration, after: Configuration, settings: MotionSettings,
    random: np.random.Generator, budget: Budget,
) -> list[Configuration] | None:  # fmt: skip
    """A free way from one switch of a phase to the other, in its slices and both ends; None where none was found.
    Raises OutOfTime."""
    space = _Space(skeleton, phase, before, after, settings, budget)
    line = connect(space, space.start, space.end, random, budget, PATHS.tree_rounds)
    if line is None:
        return None
    for _ in range(PATHS.tree_cuts):
        (line,) = shorten(space, [line], random)
    return [before, *map(space.state, resample(line, settings.slices)), after]
