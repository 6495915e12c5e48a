"""The actions of a plan by its rules: applicable, with the effects that the phases tell, and to the goal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from tamplang.compiler import ir

from .lengths import Lengths
from .motion import Recording
from .rules import Fact, NotAllowed, State, one_order

Wrong = tuple[str, str, float, float]


def replay(
    problem: ir.Problem, plan: dict[str, Any], recording: Recording, at: Callable[[int], Lengths]
) -> Iterator[Wrong]:
    """`at` gives the lengths of the scene at a sample."""
    state = State(problem, problem.init, problem.init_motion, at(0))
    for number, phase in enumerate(plan["phases"]):
        state = _left(problem, plan, state, phase["start"])
        held = {f for f in state.facts if not problem.predicates[f[0]].static}
        yield from _same(problem, f"literals of phase {number}", held, phase["literals"], False)
        yield from _same(problem, f"mode of phase {number}", state.motion, phase["mode"], True)
        if not phase.get("completed", True):
            if phase["added"]:
                yield "literals", f"phase {number} adds something though it was not completed", math.inf, 0.0
            continue
        try:
            state = _done(problem, plan, recording, at, state, number, phase)
        except NotAllowed as error:
            yield "action", f"{phase['action']}: {error}", math.inf, 0.0
            return
    if plan["phases"]:
        state = _left(problem, plan, state, plan["phases"][-1]["end"])
    yield from _same(problem, "final mode", state.motion, plan["final_mode"], True)
    if plan.get("complete", True) and not state.holds(problem.goal, {}):
        yield "goal", "the goal does not hold", math.inf, 0.0


def _done(
    problem: ir.Problem,
    plan: dict[str, Any],
    recording: Recording,
    at: Callable[[int], Lengths],
    state: State,
    number: int,
    phase: dict[str, Any],
) -> State:
    """The state after the action of a phase. Raises NotAllowed."""
    if phase["rule"] not in problem.rules:
        raise NotAllowed(f"there is no rule {phase['rule']}")
    rule = problem.rules[phase["rule"]]
    text = f"{phase['rule']}({', '.join(map(str, phase['args']))})"
    if phase["action"] != text:
        raise NotAllowed(f"it is {text}")
    binding = state.bound(rule, phase["args"])
    samples = [0]
    if plan["windows"]:
        first, last = recording.ranges[number]
        window = max((w["phase"] for w in plan["windows"] if w["phase"] <= number), default=0)
        samples += [recording.ranges[window][0], first, last]
    scenes = (State(problem, state.facts, state.motion, at(sample)) for sample in dict.fromkeys(samples))
    able = next((s for s in scenes if s.holds(rule.condition, binding)), None)
    if able is None:
        raise NotAllowed("its conditions do not hold")
    facts, motion, added = able.after(rule, binding)
    told, meant = _listed(phase["added"]), one_order(problem, added, True)
    told = one_order(problem, told, True)
    if not (told <= meant and meant - one_order(problem, state.motion, True) <= told):
        raise NotAllowed(f"it adds {sorted(meant)}, not {sorted(told)}")
    return State(problem, facts, motion, state.lengths)


def _same(
    problem: ir.Problem, where: str, held: set[Fact], told: list[dict[str, Any]], motion: bool
) -> Iterator[Wrong]:
    wanted, found = one_order(problem, held, motion), one_order(problem, _listed(told), motion)
    for fact in sorted(wanted ^ found)[:3]:
        what = "lacks" if fact in wanted else "has"
        yield "literals", f"{where} {what} {' '.join(fact)}", math.inf, 0.0


def _listed(literals: list[dict[str, Any]]) -> set[Fact]:
    return {(literal["predicate"], *map(str, literal["args"])) for literal in literals}


def _left(problem: ir.Problem, plan: dict[str, Any], state: State, time: float) -> State:
    """Without what holds of modules that have left the scene by then."""
    gone = {b["module"] for b in plan["breakdowns"] if b["kind"] == "gone" and b["time"] <= time + 1e-9}
    if not gone:
        return state
    return State(problem, _without(state.facts, gone), _without(state.motion, gone), state.lengths)


def _without(facts: set[Fact], modules: set[str]) -> set[Fact]:
    """Facts about a module that left the scene are void."""
    return {f for f in facts if not any(a in modules or a.rpartition(".")[0] in modules for a in f[1:])}
