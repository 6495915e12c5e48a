"""Search for actions by what an objective makes of them, with a clock for each module.

An action lasts as long as its rule's motion takes at least. Its motion begins when the modules that it moves are done
with the last switch that bound them; its own switch comes behind that motion and behind the switch before it, and binds
whatever hangs together with what it changes. What is between two switches of a module is one motion's time only: this
is what bounds the makespan from below, along with the work that is left.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field

import numpy as np

from ....compiler.ir import Fact, Problem
from ....compiler.symbolic.estimate import Estimate
from ....langs.frozen import dataclass
from ...geometry.attachments import carrier
from ...skeleton import Array, PhasePath, Skeleton
from ..conflicts.forbidden_sequences import EMPTY
from ..search.best_first import EQUAL, NOTHING, Candidate, Past, SkeletonSearch
from ..search.skeleton_replay import has_plain_effects, motion_changes
from ..search.stepper import left
from .dependencies import bound_between, bound_by
from .least_times import least_time
from .settings import SCHEDULE

Clocks = tuple[float, ...]
"""By module, the last switch that bound it; then the last switch of all; then what was added up."""
Mode = frozenset[Fact]


@dataclass(frozen=True, slots=True)
class Pace:
    """What an action of a rule is worth at least: its `seconds` of motion, which makespan counts `makespan` times, and
    `more`, what the objective adds up over actions, beside `cost` times the action's own cost. With `ways`, actions
    whose postures are known take as long as the way between them, as many times `slower` as those of their rule were,
    others the `usual` seconds of their rule: no bound any more, but what to expect."""

    seconds: Mapping[str, float]
    more: Mapping[str, float]
    makespan: float
    cost: float
    ways: Ways | None = None
    usual: Mapping[str, float] = field(default_factory=dict)
    slower: Mapping[str, float] = field(default_factory=dict)


class Ways:
    """Seconds from posture to posture. `ends` are the joints of all modules behind actions, by number; behind -1 those
    at the start."""

    def __init__(self, problem: Problem, ends: Mapping[int, Mapping[str, Array]]) -> None:
        self._problem, self._ends = problem, ends
        self._known: dict[tuple[str, int, int], float | None] = {}

    def seconds(self, module: str, before: int, action: int) -> float | None:
        """Those of a module from its posture behind one action to that behind another; None where one is not known."""
        key = module, before, action
        if key not in self._known:
            here, there = self._ends.get(before), self._ends.get(action)
            self._known[key] = None if here is None or there is None else self._least(module, here, there)
        return self._known[key]

    def _least(self, module: str, here: Mapping[str, Array], there: Mapping[str, Array]) -> float:
        joints = self._problem.world.modules[module].type.joints
        away = np.abs(there[module] - here[module])
        return max((least_time(j, float(a)) for j, a in zip(joints, away, strict=True)), default=0.0)


@dataclass(frozen=True, slots=True)
class Clocked:
    """What a search came to: the best candidate, with its value (None: none was found), and a value that no sequence
    of actions falls below, those that motion refused included; `cut`: its nodes were spent."""

    candidate: Candidate | None
    value: float
    bound: float
    cut: bool = False


@dataclass(frozen=True, slots=True)
class _Step:
    """One action in one state and mode: seconds, the modules that its motion waits for and those that its switch binds,
    by number, and the mode behind it."""

    seconds: float
    waits: tuple[int, ...]
    binds: tuple[int, ...]
    mode: Mode


@dataclass(frozen=True, slots=True)
class _ClockedNode:
    """`met` is what counts as the same, and its clocks: those of a state, up to names of modules."""

    state: int
    mode: Mode
    clocks: Clocks
    past: Past
    met: tuple[object, Clocks]
    before: _ClockedNode | None
    number: int
    last: tuple[int, ...] = ()
    """By module, the action that gave it its posture, where ways count."""


class ClockedSearch:
    """Best-first over states, modes and clocks; of two ways to a state one that is nowhere later and costs no more is
    enough. The no-goods and the budget of `search` are kept."""

    def __init__(self, search: SkeletonSearch, pace: Pace) -> None:
        self._search, self._pace = search, pace
        self._problem, self._successors = search.problem, search.successors
        self._modules = tuple(self._problem.world.modules)
        self._number = {name: k for k, name in enumerate(self._modules)}
        self._steps: dict[tuple[int, Mode, int], _Step] = {}
        rules = self._problem.rules
        least = search.estimate.costs
        added = {r: pace.more.get(r, 0.0) + pace.cost * least.get(r, 0.0) for r in rules}
        self._work = Estimate(self._successors, {r: pace.seconds.get(r, 0.0) for r in rules}) if pace.makespan else None
        self._adds = Estimate(self._successors, added) if any(added.values()) else None
        self._rest: dict[int, tuple[float, float]] = {}
        self._renamed: dict[int, tuple[int, dict[str, str]]] = {}
        self._plain: dict[int, tuple[Sequence[Fact], Mode]] = {}

    def best(
        self, below: float = math.inf, most: int = SCHEDULE.clocked_nodes, clocks: Clocks | None = None
    ) -> Clocked:
        """The best candidate of a value `below`, after at most so many nodes (those of more children than usual count
        for more), from these `clocks` on. Raises OutOfTime."""
        search = self._search
        start = clocks or (0.0,) * (len(self._modules) + 2)
        begun = EMPTY, search.no_goods.root, None
        initial, mode = self._successors.initial, self._problem.init_motion
        last = () if self._pace.ways is None else (-1,) * len(self._modules)
        root = _ClockedNode(initial, mode, start, begun, self._met(initial, mode, start, begun, last), None, -1, last)
        queue: list[tuple[float, float, int, _ClockedNode]] = []
        known: dict[object, list[Clocks]] = {}
        refused = below
        age = spent = fresh = 0
        heapq.heappush(queue, (self._value(root.state, start), 0.0, age, root))
        while queue:
            value, _, _, node = heapq.heappop(queue)
            key, clocks = node.met
            if node.before is not None and clocks not in known[key]:  # a better way to the same was found meanwhile
                continue
            if value >= below - EQUAL:
                return Clocked(None, math.inf, min(refused, below))
            if self._successors.is_goal(node.state):
                return Clocked(self._candidate(node, value), value, min(value, refused))
            if max(fresh / SCHEDULE.fresh_states, spent / most) >= SCHEDULE.usual_children or search.budget.full:
                return Clocked(None, math.inf, min(value, refused), cut=not search.budget.full)
            search.budget.check()
            is_fresh = self._successors.is_fresh(node.state)
            children = self._successors.expand(node.state)
            counted = max(len(children), SCHEDULE.usual_children)
            spent += counted
            fresh += counted if is_fresh else 0
            search.budget.grown += len(children)
            for following, number in children:
                step = self._step(node.state, node.mode, number)
                clocks, last = self._after(node.clocks, step, number, node.last)
                child_value = max(value, self._value(following, clocks))
                if child_value == math.inf or child_value >= below - EQUAL:
                    continue
                past = self._past(node, number)
                if past is None:
                    refused = min(refused, child_value)
                    continue
                met = self._met(following, step.mode, clocks, past, last)
                if not _is_new(known, *met):
                    continue
                child = _ClockedNode(following, step.mode, clocks, past, met, node, number, last)
                age += 1
                heapq.heappush(queue, (child_value, sum(self._left(following)), age, child))
        return Clocked(None, math.inf, refused)

    # --- time ------------------------------------------------------------------------------------------------------

    def _value(self, state: int, clocks: Clocks) -> float:
        """What the objective comes to at least."""
        *modules, last, added = clocks
        work, adds = self._left(state)
        busy = (work + sum(modules)) / len(modules) if modules else work + last
        return self._pace.makespan * max(last, busy) + added + adds

    def _left(self, state: int) -> tuple[float, float]:
        known = self._rest.get(state)
        if known is None:
            if self._search.value(state) == math.inf:
                known = math.inf, math.inf
            else:
                known = (0.0 if self._work is None else self._work.value(state),
                         0.0 if self._adds is None else self._adds.value(state))  # fmt: skip
            self._rest[state] = known
        return known

    def _after(
        self, clocks: Clocks, step: _Step, number: int, last: tuple[int, ...]
    ) -> tuple[Clocks, tuple[int, ...]]:
        """The clocks behind an action, and the actions that gave modules their postures."""
        seconds = step.seconds if self._pace.ways is None else self._on_the_way(self._pace.ways, step, number, last)
        *modules, latest, added = _behind(clocks, step.waits, step.binds, seconds)
        then = tuple(number if k in step.waits else before for k, before in enumerate(last))
        return (*modules, latest, added + self._added(number)), then

    def _on_the_way(self, ways: Ways, step: _Step, number: int, last: tuple[int, ...]) -> float:
        found = [ways.seconds(self._modules[k], last[k], number) for k in step.waits]
        known = [seconds for seconds in found if seconds is not None]
        rule = self._successors.action(number).rule
        if len(known) < len(found):
            return self._pace.usual.get(rule, step.seconds)
        return max(known, default=0.0) * self._pace.slower.get(rule, 1.0)

    def _added(self, number: int) -> float:
        rule = self._successors.action(number).rule
        return self._pace.more.get(rule, 0.0) + self._pace.cost * self._successors.cost(number)

    def _step(self, state: int, mode: Mode, number: int) -> _Step:
        key = state, mode, number
        found = self._steps.get(key)
        if found is None:
            found = self._steps[key] = self._made(state, mode, number)
        return found

    def _made(self, state: int, mode: Mode, number: int) -> _Step:
        problem, action = self._problem, self._successors.action(number)
        deleted, added = self._changes(state, number)
        after = left(problem.motions, mode, deleted) | added
        binds = {self._number[n] for n in bound_between(problem, mode, added, after) if n in self._number}
        waits = _waiting(problem, self._number, added)
        return _Step(self._pace.seconds.get(action.rule, 0.0), tuple(sorted(waits)), tuple(sorted(binds | waits)),
                     after)  # fmt: skip

    def _changes(self, state: int, number: int) -> tuple[Sequence[Fact], Mode]:
        """Patterns of the motion literals that an action deletes, and those that it adds; both are the same in all
        states where no effect of its rule has a condition or a quantifier."""
        known = self._plain.get(number)
        if known is None:
            action = self._successors.action(number)
            deleted, added = motion_changes(self._problem, self._successors, state, action)
            known = deleted, frozenset(added)
            if has_plain_effects(self._problem, action):
                self._plain[number] = known
        return known

    # --- what was met ------------------------------------------------------------------------------------------------

    def _met(
        self, state: int, mode: Mode, clocks: Clocks, past: Past, last: tuple[int, ...]
    ) -> tuple[object, Clocks]:
        """The state, up to names of modules that stand for each other, and the clocks in the order of these names."""
        renaming = self._search.renaming
        if past != NOTHING or last:
            return (state, mode, past, last), clocks
        if renaming is None:
            return (state, mode), clocks
        known = self._renamed.get(state)
        if known is None:
            known = self._renamed[state] = renaming.renamed(state)
        canonical, names = known
        renamed = frozenset((f[0], *(names.get(o, o) for o in f[1:])) for f in mode)
        ordered = list(clocks)
        for old, k in self._number.items():
            ordered[self._number[names.get(old, old)]] = clocks[k]
        return (canonical, renamed), tuple(ordered)

    def _past(self, node: _ClockedNode, number: int) -> Past | None:
        """What no-goods remember after one more action; None when one forbids it."""
        no_goods = self._search.no_goods
        if no_goods.active and not no_goods.allows(node.state, number):
            return None
        then = no_goods.advance(node.past[0], node.past[1], node.state, number)
        return None if then is None else (*then, None)

    def _candidate(self, node: _ClockedNode, value: float) -> Candidate:
        numbers = []
        at: _ClockedNode | None = node
        while at is not None and at.before is not None:
            numbers.append(at.number)
            at = at.before
        numbers.reverse()
        actions = tuple(self._successors.action(n) for n in numbers)
        cost = sum(self._successors.cost(n) for n in numbers)
        return Candidate(tuple(numbers), actions, cost, False, min(cost, self._search.value(self._successors.initial)))

    def valued(self, numbers: tuple[int, ...]) -> float:
        """What the objective comes to at least for these actions."""
        state, mode = self._successors.initial, self._problem.init_motion
        clocks: Clocks = (0.0,) * (len(self._modules) + 2)
        last = () if self._pace.ways is None else (-1,) * len(self._modules)
        for number in numbers:
            step = self._step(state, mode, number)
            clocks, last = self._after(clocks, step, number, last)
            state, mode = self._successors.after(state, number), step.mode
        return self._pace.makespan * clocks[-2] + clocks[-1]


def clocks_along(skeleton: Skeleton, paths: Sequence[PhasePath], clocks: Clocks) -> Clocks:
    """The clocks behind the motions of the first phases of a skeleton; empty ones stand for the start."""
    problem = skeleton.problem
    numbers = {name: k for k, name in enumerate(problem.world.modules)}
    clocks = clocks or (0.0,) * (len(numbers) + 2)
    for k, path in enumerate(paths):
        waits = _waiting(problem, numbers, skeleton.phases[k].added)
        binds = {numbers[n] for n in bound_by(skeleton, k) if n in numbers}
        clocks = _behind(clocks, waits, binds | waits, path.duration)
    return clocks


def _waiting(problem: Problem, numbers: Mapping[str, int], added: Mode) -> set[int]:
    """The modules for which the motion to a switch that adds these literals waits: those that they name, else all."""
    named = {carrier(problem, a) for literal in added for a in literal[1:]}
    return {numbers[n] for n in named if n in numbers} or set(numbers.values())


def _behind(clocks: Clocks, waits: Iterable[int], binds: Iterable[int], seconds: float) -> Clocks:
    """The clocks behind a motion of so many seconds that waits for some modules, and its switch, which binds some."""
    *modules, last, added = clocks
    last = max(last, max((modules[k] for k in waits), default=last) + seconds)
    for k in binds:
        modules[k] = last
    return *modules, last, added


def _is_new(known: dict[object, list[Clocks]], key: object, clocks: Clocks) -> bool:
    """Whether no way that is known leads there at least as early, and at no higher cost; it is known from now on."""
    before = known.setdefault(key, [])
    if any(all(a <= b + EQUAL for a, b in zip(other, clocks, strict=True)) for other in before):
        return False
    before[:] = [o for o in before if not all(a <= b + EQUAL for a, b in zip(clocks, o, strict=True))]
    before.append(clocks)
    return True
