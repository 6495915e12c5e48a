"""The search with clocks against all schedules of small tasks, by the verifier's plain interpreter and with nothing of
the planner's."""

from __future__ import annotations

import random

from tamplang.compiler.ir import Action, Fact, Problem
from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.schedule.clocked_search import ClockedSearch, Pace
from tamplang.runtime.planner.search.best_first import SkeletonSearch
from tamplang.runtime.verify.replay import Interpreter

Facts = frozenset[Fact]
TASKS = 200
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
rule ring() { pre not (rung), exists A: hand, S: spot { (at A S) and not (full A) } post (rung) }
"""
NAMES = "go", "take", "put", "hand_over", "tie", "haul"


def drawn(seed: int) -> tuple[Problem, dict[str, float]]:
    """A task of two or three modules, with things to carry, and seconds by rule."""
    chance = random.Random(seed)
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
    rules = RULES if ties else RULES[: RULES.index("rule tie")] + RULES[RULES.index("rule ring") :]
    goals = [g for g in goals if ties or "tied" not in g]
    goal = ", ".join(chance.sample(goals, chance.randint(1, 2)))
    text = "\n".join([rules, "task t() {", *lines, f"    goal {goal}", "}"])
    seconds = {r: float(chance.randint(1, 2 if modules == 2 else 1)) for r in NAMES} | {"ring": 0.0}
    return compile_text(text)[0], seconds


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


class Schedules:
    """All schedules of a task, by the plain interpreter."""

    def __init__(self, problem: Problem, seconds: dict[str, float]) -> None:
        self.problem, self.seconds, self.plain = problem, seconds, Interpreter(problem)
        self.modules = tuple(problem.world.modules)
        self.known: dict[tuple[Facts, Facts], list[tuple[Action, Facts, Facts, set[str], set[str]]]] = {}

    def steps(self, facts: Facts, motion: Facts) -> list[tuple[Action, Facts, Facts, set[str], set[str]]]:
        """What can be done: what it leaves, the modules that move, and those that are bound."""
        if (facts, motion) not in self.known:
            found = []
            for rule in self.problem.rules.values():
                for action in self.plain.applicable(facts, rule):
                    step = self.plain.apply(facts, motion, action)
                    named = {own(name) for fact in step.added_motion for name in fact[1:]} & set(self.modules)
                    moves = named or set(self.modules)
                    binds = bound(self.problem, motion, step.added_motion, step.motion) | moves
                    found.append((action, step.facts, step.motion, moves, binds))
            self.known[facts, motion] = found
        return self.known[facts, motion]

    def after(self, last: float, clocks: Clocks, rule: str, moves: set[str], binds: set[str]) -> tuple[float, Clocks]:
        begin = max(c for m, c in zip(self.modules, clocks, strict=True) if m in moves)
        end = max(last, begin + self.seconds[rule])
        return end, tuple(end if m in binds else c for m, c in zip(self.modules, clocks, strict=True))

    def some_end_before(self, most: float) -> bool:
        """Whether some schedule reaches the goal before `most`; all are tried, each state and clocks once."""
        start = 0.0, self.problem.init, self.problem.init_motion, (0.0,) * len(self.modules)
        waiting, seen = [start], {start}
        while waiting:
            last, facts, motion, clocks = waiting.pop()
            if last < most and self.plain.holds(facts, self.problem.goal):
                return True
            for action, following, moved, moves, binds in self.steps(facts, motion):
                end, then = self.after(last, clocks, action.rule, moves, binds)
                node = end, following, moved, then
                if end < most and node not in seen:
                    seen.add(node)
                    waiting.append(node)
        return False

    def makespan(self, actions: tuple[Action, ...]) -> float:
        """That of one sequence of actions, which must reach the goal."""
        last, facts, motion, clocks = 0.0, self.problem.init, self.problem.init_motion, (0.0,) * len(self.modules)
        for action in actions:
            _, facts, motion, moves, binds = next(s for s in self.steps(facts, motion) if s[0] == action)
            last, clocks = self.after(last, clocks, action.rule, moves, binds)
        assert self.plain.holds(facts, self.problem.goal)
        return last


def test_the_least_makespan_is_that_of_all_schedules() -> None:
    found = []
    for seed in range(TASKS):
        problem, seconds = drawn(seed)
        search = SkeletonSearch(problem, Successors(problem), "astar", Budget(None))
        clocked = ClockedSearch(search, Pace(seconds, {}, 1.0, 0.0)).best(most=20_000)
        assert clocked.candidate is not None and clocked.value == clocked.bound, seed
        schedules = Schedules(problem, seconds)
        assert schedules.makespan(clocked.candidate.actions) == clocked.value, seed
        assert not schedules.some_end_before(clocked.value), seed
        found.append((clocked.value, sum(seconds[a.rule] for a in clocked.candidate.actions)))
    assert sum(value < total for value, total in found) > TASKS // 20
    assert max(value for value, _ in found) >= 5.0
