"""tamplang's side of the common motion benchmark: the same cases as .tamp text, solved by the public bounds."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tamplang.compiler.ir import Action, Problem
from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.successors import Successors
from tamplang.runtime.budget import Budget, OutOfTime
from tamplang.runtime.plan import StatisticsRecord
from tamplang.runtime.planner.motion.keyframes.sequence import solve_sequence
from tamplang.runtime.planner.motion.path.whole_path import solve_path
from tamplang.runtime.planner.motion.phases import solve_sequence_path
from tamplang.runtime.planner.motion.settings import MotionSettings
from tamplang.runtime.planner.search.skeleton_replay import build_skeleton
from tamplang.runtime.seeds import Seed
from tamplang.runtime.skeleton import BoundResult, Configuration, PhasePath, Skeleton

from . import cases
from .cases import Case

Array = NDArray[np.float64]
LIMIT = 600.0
"""Wall seconds for one solve: many, so that a busy machine changes no result."""
ATTEMPTS = 5
"""P_seq is solved anew, from another seed, when no path connects its switches."""
FREE_STEP = """
## A step without a bound on its length, so that the motion layer has to say what is too far.
rule step(A B: effector, X Y: base) {
    pre   (support A), (linked A B), (free B), (on X A)
    post  not (support A), not (on X A), not [stable ANY A], not [stand A X],
          (support B), (on Y B), [stable Y B], [stand B Y]
}
"""


def _box(size: Sequence[float], at: Sequence[float]) -> str:
    sizes, place = (", ".join(f"{v} m" for v in values) for values in (size, at))
    return f"box({sizes}) at ({place})"


def climb_text(case: Case) -> str:
    """One crawler on stair 0, stairs 1 … K."""
    stairs = "\n".join(f"    base stair[{i}]: {_box(cases.STAIR, at)}" for i, at in enumerate(case.places))
    last = "B" if case.size % 2 else "A"
    head = "import std.crawler\nimport std.logic\nimport std.motion\n" + FREE_STEP
    goal = f"goal (on stair[{case.size}] c.{last})"
    return f"{head}\ntask climb() {{\n{stairs}\n    crawler c: A on stair[0]\n    {goal}\n}}\n"


def pick_text(case: Case) -> str:
    """One crawler on a base, items around it, a tray."""
    cube = (cases.ITEM,) * 3
    items = "\n".join(
        f"    object item[{i}]: {_box(cube, at)}\n    fact (grippable item[{i}])" for i, at in enumerate(case.places)
    )
    base, tray = _box(cases.BASE, (0.0, 0.0, cases.BASE[2] / 2)), _box(cases.TRAY, cases.TRAY_AT)
    goal = f"goal forall i in 0 .. {case.size - 1} {{ (on goal_tray item[i]) }}"
    return (
        "import std.crawler\nimport std.rules\n\ntask pick() {\n"
        f"    base pedestal: {base}\n    object goal_tray: {tray}\n    fact (tray goal_tray)\n{items}\n"
        f"    crawler c: A on pedestal\n    {goal}\n}}\n"
    )


def climb_together_text(case: Case, crawlers: int) -> str:
    """Crawlers side by side on the floor in front of stairs 1 … K."""
    stairs = "\n".join(f"    base stair[{i}]: {_box(cases.STAIR, at)}" for i, at in enumerate(case.places) if i)
    return (
        "import std.crawler\nimport std.rules\n\ntask together() {\n"
        f"    base ground: box(2 m, 2 m, 0.05 m) at (-0.9 m, 0 m, 0 m)\n{stairs}\n"
        f"    for k in 1 .. {crawlers} {{\n"
        f"        crawler c[k]: A on ground at (0.7 m, 0.35 m * (k - {(crawlers + 1) / 2})) heading 90 deg\n    }}\n"
        f"    goal exists f: gripper {{ (on stair[{case.size}] f) }}\n}}\n"
    )


@dataclass(frozen=True)
class Prepared:
    """A skeleton with the actions that were forced."""

    case: Case
    problem: Problem
    actions: list[Action]
    skeleton: Skeleton


def prepare(case: Case, text: str, wanted: Sequence[str]) -> Prepared:
    """Compile `text` and build the skeleton of the actions whose texts match the patterns `wanted`, the first match
    of each in the order of the successors. Raises ValueError when none can follow."""
    problem, _ = compile_text(text)
    successors = Successors(problem)
    state, actions = successors.initial, []
    for pattern in wanted:
        for following, number in successors.expand(state):
            action = successors.action(number)
            if re.fullmatch(pattern, str(action)):
                state = following
                actions.append(action)
                break
        else:
            raise ValueError(f"no action {pattern} can follow {actions[-1] if actions else 'the start'}")
    return Prepared(case, problem, actions, build_skeleton(problem, actions, successors))


def climb(case: Case) -> Prepared:
    """K steps, alternately with both feet."""
    wanted = []
    for k in range(case.size):
        feet = ("A", "B") if k % 2 == 0 else ("B", "A")
        wanted.append(rf"step\(c\.{feet[0]}, c\.{feet[1]}, stair\[{k}\], stair\[{k + 1}\]\)")
    return prepare(case, climb_text(case), wanted)


def pick(case: Case) -> Prepared:
    """Every item in turn to the tray."""
    wanted = []
    for i in range(case.size):
        wanted += [rf"grasp\(c\.B, item\[{i}\]\)", rf"place\(c\.B, item\[{i}\], goal_tray\)"]
    return prepare(case, pick_text(case), wanted)


def climb_together(case: Case, crawlers: int) -> Prepared:
    """Crawlers connect to one chain, which then takes every stair."""
    stairs = ["ground", *(f"stair[{i}]" for i in range(1, case.size + 1))]
    steps = [rf"stepTogether\(.*, {re.escape(x)}, {re.escape(y)}\)" for x, y in pairwise(stairs)]
    docks = [rf"connect\(.*c\[{k}\].*, \[c\[{k + 1}\].*\)" for k in range(1, crawlers)]
    return prepare(case, climb_together_text(case, crawlers), [*docks, *steps])


BUILDERS: dict[str, Callable[[Case], Prepared]] = {"climb": climb, "pick": pick}


def settings(collisions: bool) -> MotionSettings:
    return MotionSettings(slices=cases.SLICES, collisions=collisions)


def solve(prepared: Prepared, bound: str, seed: int) -> dict[str, Any]:
    """CPU seconds, feasibility and motion of one bound: "seq", "path" (after P_seq, which is timed apart), or "path
    with collisions" (P_seq, then phase by phase, P_seq included in the time)."""
    skeleton, budget = prepared.skeleton, Budget(LIMIT)
    chosen = settings(bound == "path with collisions")
    started = time.process_time()
    sequence_cpu = 0.0
    result: BoundResult | None = None
    sequence = None
    try:
        if bound == "path with collisions":
            result, sequence_cpu = _with_collisions(skeleton, chosen, seed, budget)
        else:
            sequence = solve_sequence(skeleton, chosen, Seed(seed), budget)
            sequence_cpu = time.process_time() - started
            if bound == "path" and sequence.feasible:
                started = time.process_time()
                result = solve_path(skeleton, chosen, Seed(seed), budget, sequence)
    except OutOfTime:
        result = None
    cpu = time.process_time() - started
    best = result if bound != "seq" else sequence
    answer: dict[str, Any] = {
        "cpu": cpu, "sequence_cpu": sequence_cpu, "feasible": best is not None and best.feasible,
        "slices": 1 if bound == "seq" else cases.SLICES,
    }  # fmt: skip
    if best is not None and best.feasible:
        answer["iterations"] = best.iterations
        answer["paths"] = best.paths if bound != "seq" else _as_paths(prepared, best.configurations)
    elif best is not None and best.violations:
        answer["why"] = str(best.violations[0])
    return answer


def _with_collisions(
    skeleton: Skeleton, chosen: MotionSettings, seed: int, budget: Budget
) -> tuple[BoundResult | None, float]:
    spent, result = 0.0, None
    for attempt in range(ATTEMPTS):
        started = time.process_time()
        sequence = solve_sequence(skeleton, chosen, Seed(seed).child("attempt", attempt), budget)
        spent += time.process_time() - started
        if not sequence.feasible:
            result = sequence
            continue
        result = solve_sequence_path(skeleton, sequence.configurations, chosen, Seed(seed), budget)
        if result.feasible:
            break
    return result, spent


def _as_paths(prepared: Prepared, states: Sequence[Configuration]) -> list[PhasePath]:
    moving = [b.name for b in prepared.problem.world.bodies.values() if b.movable]
    return [
        PhasePath(
            {m: np.stack([a.modules[m], b.modules[m]]) for m in a.modules},
            {m: np.stack([a.bodies[m], b.bodies[m]]) for m in moving},
            1.0,
        )
        for a, b in pairwise(states)
    ]


def motion(prepared: Prepared, paths: Sequence[PhasePath]) -> tuple[Array, Array]:
    """The rows of the one crawler (T + 1, 14) and the items' poses (T + 1, n, 7), as the judge reads them."""
    crawler = np.concatenate([p.modules["c"][1 if k else 0 :] for k, p in enumerate(paths)])
    tracks = []
    for i in range(prepared.case.size if prepared.case.kind == "pick" else 0):
        name = f"item[{i}]"
        pose, rows = np.array(prepared.problem.world.bodies[name].pose), []
        for k, path in enumerate(paths):
            track = path.bodies.get(name)
            if track is None:
                track = np.tile(pose, (len(path.modules["c"]), 1))
            pose = track[-1]
            rows.append(track[1 if k else 0 :])
        tracks.append(np.concatenate(rows))
    return crawler, np.stack(tracks, axis=1) if tracks else np.zeros((len(crawler), 0, 7))


def verified(prepared: Prepared, paths: Sequence[PhasePath]) -> bool:
    """The verdict of tamplang's verifier on the plan."""
    from tamplang.runtime.planner.plan_assembly import assemble
    from tamplang.runtime.verify.check import check

    plan = assemble(prepared.problem, prepared.actions, prepared.skeleton, paths, StatisticsRecord())
    return check(plan, prepared.problem).verified
