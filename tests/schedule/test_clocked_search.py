"""The search with clocks against all schedules of small tasks, by the verifier's plain interpreter and with nothing of
the planner's."""

from __future__ import annotations

import random
from dataclasses import dataclass

from tamplang.compiler.ir import Action, Fact, Problem
from tamplang.compiler.pipeline import compile_sources
from tamplang.compiler.symbolic.successors import Successors
from tamplang.langs.source import Source
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.schedule.clocked_search import ClockedSearch, Pace
from tamplang.runtime.planner.schedule.distinct_plans import DistinctPlans, PlanForms
from tamplang.runtime.planner.search.best_first import Candidate, SkeletonSearch
from tamplang.runtime.verify.replay import Interpreter

Facts = frozenset[Fact]
TASKS = 200
LONGEST = 6
"""Of plans that are counted, actions."""
PACES = 5
"""How many tasks share a scene and goal, with other seconds for their actions."""
RULES = """type thing < object
type spot < object
type hand < effector
module walker() {
    effector A: hand sphere(5 cm)
    joint j: revolute(z) in -1 rad .. 1 rad
    link 30 cm: capsule(2 cm)
    effector B: effector sphere(5 cm)
}
motion [near X Y: object] { at switch gap(X, Y) <= 100 m }
motion [held X Y: object] { keep pose(Y, X) }
predicate (at A: hand, S: spot) functional in A
predicate (road S T: spot) static
predicate (lies X: thing, S: spot) functional in X
predicate (has A: hand, X: thing) functional in X
predicate (full A: hand)
predicate (tied A B: hand) symmetric
predicate (rung)
predicate (clean X: thing)
predicate (dry X: thing)
rule go(A: hand, S T: spot) {
    pre (at A S), (road S T), not exists B: hand { (tied A B) }
    post not (at A S), (at A T), [near A T]
}
rule take(A: hand, X: thing, S: spot) {
    pre (at A S), (lies X S), not (full A)
    post not (lies X S), (has A X), (full A), [held A X]
}
rule put(A: hand, X: thing, S: spot) {
    pre (at A S), (has A X)
    post not (has A X), not (full A), (lies X S), not [held A X], [near X S]
}
rule hand_over(A B: hand, X: thing, S: spot) {
    pre A != B, (at A S), (at B S), (has A X), not (full B)
    post not (has A X), (has B X), not (full A), (full B), not [held A X], [held B X]
}
rule tie(A B: hand, S: spot) {
    pre A != B, (at A S), (at B S), not exists C: hand { (tied A C) or (tied B C) }
    post (tied A B), [held A B]
}
rule haul(A B: hand, S T: spot) {
    pre (at A S), (at B S), (tied A B), (road S T)
    post not (at A S), (at A T), not (at B S), (at B T), [near A T]
}
rule wipe(A: hand, X: thing, S: spot) {
    pre (at A S), (lies X S), not (clean X)
    post (clean X), [near A X]
}
rule blow(A: hand, X: thing, S: spot) {
    pre (at A S), (lies X S), not (dry X)
    post (dry X), [near A X]
}
rule ring() { pre not (rung), exists A: hand, S: spot { (at A S) and not (full A) } post (rung) }
"""
NAMES = "go", "take", "put", "hand_over", "tie", "haul", "wipe", "blow"


def drawn(seed: int) -> Problem:
    """A task of two or three modules, with things to carry, or, every other time, to work at: who did that only clocks
    tell."""
    chance = random.Random(seed)
    works = seed % 2 == 1
    modules, spots, things = chance.choice([(2, 2, 1), (2, 2, 1), (2, 2, 1), (3, 2, 1)])
    lines = [f"    spot s[{k}]: sphere(5 cm) at ({k} m, 0, 0)" for k in range(1, spots + 1)]
    lines += [f"    thing x[{k}]: sphere(5 cm) at ({k} m, 1 m, 0)" for k in range(1, things + 1)]
    lines += [f"    walker m[{k}]: at ({k} m, 3 m, 0)" for k in range(1, modules + 1)]
    for k in range(1, spots):
        lines += [f"    fact (road s[{k}] s[{k + 1}])", f"    fact (road s[{k + 1}] s[{k}])"]
    lines += [f"    fact (at m[{k}].A s[{chance.randint(1, spots)}])" for k in range(1, modules + 1)]
    lines += [f"    fact (lies x[{k}] s[{chance.randint(1, spots)}])" for k in range(1, things + 1)]
    goals = [f"(lies x[{k}] s[{chance.randint(1, spots)}])" for k in range(1, things + 1)]
    target = chance.randint(1, spots)
    goals += [f"(at m[{k}].A s[{target}])" for k in range(1, modules + 1)]
    goals += [chance.choice(["(rung)", "(tied m[1].A m[2].A)"])]
    ties = modules == 2 and seed % 3 == 0
    left_out = ("wipe", "ring") if not works else ("take", "wipe")
    rules = RULES[: RULES.index(f"rule {left_out[0]}")] + RULES[RULES.index(f"rule {left_out[1]}") :]
    rules = rules if ties or works else rules[: rules.index("rule tie")] + rules[rules.index("rule ring") :]
    goals = [g for g in goals if (ties and not works) or "tied" not in g]
    goal = ", ".join(chance.sample(goals, chance.choice((1, 2, 2))))
    if works:
        goal = ", ".join(["(clean x[1])", "(dry x[1])", *chance.sample(goals[1:-1], 1 + (modules > 2))])
    text = "\n".join(['import "rules.tamp"', "task t() {", *lines, f"    goal {goal}", "}"])
    return compile_sources([Source("task.tamp", text), Source("rules.tamp", rules)])[0]


def paces(seed: int) -> list[dict[str, float]]:
    """Seconds by rule, some times."""
    chance = random.Random(-1 - seed)
    return [{r: float(chance.randint(1, 2)) for r in NAMES} | {"ring": 0.0} for _ in range(PACES)]


def components(problem: Problem, motion: Facts) -> list[set[str]]:
    """Modules and things that kept literals hold together."""
    found: list[set[str]] = [{name} for name in problem.world.modules]
    found += [{name} for name, body in problem.world.bodies.items() if body.movable]
    for fact in motion:
        if fact[0] == "held":
            joined = [group for group in found if group & {own(name) for name in fact[1:]}]
            found = [group for group in found if group not in joined] + [set().union(*joined)]
    return found


def own(name: str) -> str:
    return name.rpartition(".")[0] or name


def bound(problem: Problem, before: Facts, added: Facts, after: Facts) -> set[str]:
    named = {own(name) for fact in (before ^ after) | added for name in fact[1:]}
    groups = [*components(problem, before), *components(problem, after)]
    return named | {name for group in groups if group & named for name in group}


Clocks = tuple[float, ...]


@dataclass(frozen=True)
class Step:
    """What an action leads to, by number, the modules that move, those that are bound, and all things that are."""

    action: Action
    to: int
    moves: frozenset[int]
    binds: frozenset[int]
    touches: frozenset[str]


class Schedules:
    """All schedules of a task, by the plain interpreter; states by number, the first is the start."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.plain = problem, Interpreter(problem)
        self.seconds: dict[str, float] = {}
        self.modules = tuple(problem.world.modules)
        self.things = {*self.modules, *(name for name, body in problem.world.bodies.items() if body.movable)}
        self.numbers: dict[tuple[Facts, Facts], int] = {}
        self.states: list[tuple[Facts, Facts]] = []
        self.done: list[bool] = []
        self.known: dict[int, list[Step]] = {}
        self.numbered(problem.init, problem.init_motion)

    def numbered(self, facts: Facts, motion: Facts) -> int:
        if (facts, motion) not in self.numbers:
            self.numbers[facts, motion] = len(self.states)
            self.states.append((facts, motion))
            self.done.append(self.plain.holds(facts, self.problem.goal))
        return self.numbers[facts, motion]

    def steps(self, state: int) -> list[Step]:
        """What can be done in a state."""
        if state not in self.known:
            facts, motion = self.states[state]
            found = []
            for rule in self.problem.rules.values():
                for action in self.plain.applicable(facts, rule):
                    step = self.plain.apply(facts, motion, action)
                    named = {own(name) for fact in step.added_motion for name in fact[1:]} & set(self.modules)
                    moves = named or set(self.modules)
                    touches = bound(self.problem, motion, step.added_motion, step.motion)
                    to = self.numbered(step.facts, step.motion)
                    places = [frozenset(k for k, m in enumerate(self.modules) if m in some)
                              for some in (moves, touches | moves)]  # fmt: skip
                    found.append(Step(action, to, *places, frozenset(touches & self.things)))
            self.known[state] = found
        return self.known[state]

    def after(self, last: float, clocks: Clocks, step: Step) -> tuple[float, Clocks]:
        end = max(last, max(clocks[k] for k in step.moves) + self.seconds[step.action.rule])
        return end, tuple(end if k in step.binds else c for k, c in enumerate(clocks))

    def some_end_before(self, most: float) -> bool:
        """Whether some schedule reaches the goal before `most`; all are tried, each state and clocks once."""
        start = 0.0, 0, (0.0,) * len(self.modules)
        waiting, seen = [start], {start}
        while waiting:
            last, state, clocks = waiting.pop()
            if last < most and self.done[state]:
                return True
            for step in self.steps(state):
                end, then = self.after(last, clocks, step)
                node = end, step.to, then
                if end < most and node not in seen:
                    seen.add(node)
                    waiting.append(node)
        return False

    def makespan(self, actions: tuple[Action, ...]) -> float:
        """That of one sequence of actions, which must reach the goal."""
        last, state, clocks = 0.0, 0, (0.0,) * len(self.modules)
        for action in actions:
            step = next(s for s in self.steps(state) if s.action == action)
            last, clocks = self.after(last, clocks, step)
            state = step.to
        assert self.done[state]
        return last

    def plans(self, length: int) -> list[tuple[Action, ...]]:
        """All sequences of so many actions that reach the goal."""
        rows: list[tuple[int, tuple[Action, ...]]] = [(0, ())]
        for _ in range(length):
            rows = [(s.to, (*actions, s.action)) for state, actions in rows for s in self.steps(state)]
        return [actions for state, actions in rows if self.done[state]]

    def classes(self, plans: list[tuple[Action, ...]]) -> list[set[tuple[Action, ...]]]:
        """Plans that become each other when actions change places that follow each other, bind nothing in common, can
        be done either way, and lead to the same."""
        waiting, found = set(plans), []
        while waiting:
            group = set()
            near = {waiting.pop()}
            while near:
                plan = near.pop()
                group.add(plan)
                near |= {other for other in self.swapped(plan) if other not in group}
            waiting -= group
            found.append(group)
        return found

    def swapped(self, plan: tuple[Action, ...]) -> list[tuple[Action, ...]]:
        state, found = 0, []
        for k, action in enumerate(plan[:-1]):
            ways = {s.action: s for s in self.steps(state)}
            one, other = ways[action], ways.get(plan[k + 1])
            second = next(s for s in self.steps(one.to) if s.action == plan[k + 1])
            first = None if other is None else next((s for s in self.steps(other.to) if s.action == action), None)
            if first is not None and first.to == second.to and not one.touches & second.touches:
                found.append((*plan[:k], plan[k + 1], action, *plan[k + 2 :]))
            state = one.to
        return found


def test_the_least_makespan_is_that_of_all_schedules_and_plans_differ() -> None:
    """By scene: the least makespan for some paces; and of the cheapest plans, one of each class of orders of actions
    that commute."""
    found, classes = [], []
    for seed in range(TASKS // PACES):
        problem = drawn(seed)
        successors = Successors(problem)
        search = SkeletonSearch(problem, successors, "astar", Budget(None))
        schedules = Schedules(problem)
        for seconds in paces(seed):
            clocked = ClockedSearch(search, Pace(seconds, {}, 1.0, 0.0)).best(most=20_000)
            assert clocked.candidate is not None and clocked.value == clocked.bound, seed
            schedules.seconds = seconds
            assert schedules.makespan(clocked.candidate.actions) == clocked.value, seed
            assert not schedules.some_end_before(clocked.value), seed
            found.append((clocked.value, sum(seconds[a.rule] for a in clocked.candidate.actions)))
        first = search.next()
        if first is not None and len(first.actions) <= LONGEST:
            classes.append(differing(search, schedules, first))
    assert sum(value < total for value, total in found) > TASKS // 20
    assert max(value for value, _ in found) >= 5.0
    assert sum(more > 1 for more, _ in classes) > 5 and sum(plans > more for more, plans in classes) > 5


def test_who_gives_something_away_goes_on_behind_that() -> None:
    """One brings a thing along roads that lead one way, gives it to the other one, who takes long to get there, and
    goes on."""
    lines = [f"    spot s[{k}]: sphere(5 cm) at ({k} m, 0, 0)" for k in (1, 2, 3)]
    lines += ["    thing x: sphere(5 cm) at (1 m, 1 m, 0)", "    fact (lies x s[1])"]
    lines += [f"    walker m[{k}]: at ({k} m, 3 m, 0)\n    fact (at m[{k}].A s[{k}])" for k in (1, 2)]
    lines += [f"    fact (road s[{k}] s[{k + 1}])" for k in (1, 2)]
    lines += ["    goal (has m[2].A x), (at m[2].A s[2]), (at m[1].A s[3])"]
    text = "\n".join(['import "rules.tamp"', "task t() {", *lines, "}"])
    problem = compile_sources([Source("task.tamp", text), Source("rules.tamp", RULES)])[0]
    schedules, search = Schedules(problem), SkeletonSearch(problem, Successors(problem), "astar", Budget(None))
    for seconds in (pace | {"hand_over": 5.0} for pace in paces(0)):
        clocked = ClockedSearch(search, Pace(seconds, {}, 1.0, 0.0)).best(most=20_000)
        schedules.seconds = seconds
        assert clocked.candidate is not None and schedules.makespan(clocked.candidate.actions) == clocked.value
        assert not schedules.some_end_before(clocked.value)


def differing(search: SkeletonSearch, schedules: Schedules, first: Candidate) -> tuple[int, int]:
    """How many classes of cheapest plans a search proposes, which are all, and how many such plans there are."""
    plans = schedules.plans(len(first.actions))
    classes = schedules.classes(plans)
    distinct, forms = DistinctPlans(search), PlanForms(search.problem, search.successors)
    proposed: list[Candidate] = []
    candidate: Candidate | None = first
    while candidate is not None and candidate.cost == first.cost:
        proposed.append(candidate)
        distinct.found(candidate)
        candidate = search.next()
    groups = [next(k for k, group in enumerate(classes) if c.actions in group) for c in proposed]
    assert sorted(groups) == list(range(len(classes)))
    assert len({forms.of(c.numbers).normal for c in proposed}) == len(classes)
    return len(classes), len(plans)
