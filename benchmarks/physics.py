"""Physics: statics against Pinocchio and against MuJoCo, torques predicted against simulated, plans at their limits.

    python benchmarks/physics.py [--assemblies N] [--loops N] [--plans N] [--limits N] [--first N]

Random assemblies are chains of one to three docked arms of random lengths, weights and postures; closed loops are rings
of two or three of them, held still in the engine. Predicted peaks are the verifier's, of plans with inertia; simulated
ones those of `tamplang simulate`. Plans at their limit are of an arm that takes a thing, whose drives, foot or gripper
are as strong as 1 / 1.05 and 1 / 0.9 of what the plan needs.
"""

from __future__ import annotations

import argparse
import math
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from _physics_limits import BEYOND, STRENGTHS, WITHIN, Limited, limited, task
from _physics_loops import RESTS, Held, held_still

from tamplang.compiler import ir
from tamplang.compiler.physics.frames import poses
from tamplang.compiler.physics.statics import drives, loads
from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.runtime.engine import carry_out
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.verify.inertia import weights

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
GRAVITY = 9.81
SAFETY = 1.5


def assembly(random: np.random.Generator, arms: int) -> ir.Problem:
    """Arms of random parts side by side."""
    kinds, placed = [], []
    for number in range(arms):
        joints = "".join(
            f"joint j{k}: revolute({random.choice(list('xyz'))}) in -3 rad .. 3 rad torque 50 N m "
            f"mass {random.uniform(0.1, 2):.4f} kg\n"
            f"link {random.uniform(0.05, 0.4):.4f} m: capsule(0.03 m) mass {random.uniform(0.1, 2):.4f} kg\n"
            for k in range(random.integers(2, 8))
        )
        kinds.append(
            f"module arm{number} {{ effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 200 g\n{joints}"
            "effector B: gripper sphere(0.05 m) mass 300 g\nfact (linked A B) }\n"
        )
        placed.append(f"arm{number} c{number}: A on ground at (0, {3 * number - 3} m)\n")
    text = "import std.rules\n" + "".join(kinds) + "task t() { base ground: box(20 m, 20 m, 5 cm) at (0, 0, 0)\n"
    return compile_text(text + "".join(placed) + "goal (on ground c0.B) }")[0]


def posture(problem: ir.Problem, random: np.random.Generator) -> dict[str, np.ndarray]:
    found = {}
    for name, module in problem.world.modules.items():
        turn = random.normal(size=4)
        values = random.uniform(-2.0, 2.0, len(module.joints))
        found[name] = np.concatenate([random.uniform(-1, 1, 3), turn / np.linalg.norm(turn), values])[None]
    return found


def chained(problem: ir.Problem) -> frozenset[ir.Fact]:
    """The first arm on the ground, each further one docked by its A to the B of the one before."""
    names = list(problem.world.modules)
    docks = {("stable", f"{a}.B", f"{b}.A") for a, b in pairwise(names)}
    return frozenset({("stable", "ground", f"{names[0]}.A"), *docks})


def by_pinocchio(problem: ir.Problem, rows: dict[str, np.ndarray]) -> dict[tuple[str, int], float]:
    """Torques of the whole chain as one tree."""
    import pinocchio as pin

    bodies = {n: np.array([b.pose]) for n, b in problem.world.bodies.items()}
    at = poses(problem, rows, bodies)
    model = pin.Model()
    model.gravity = pin.Motion(np.array([0.0, 0.0, -GRAVITY]), np.zeros(3))
    names, values, ids = [], [], {}
    parent, base = 0, pin.SE3.Identity()
    for name, module in problem.world.modules.items():
        here = pin.SE3(at.turns[name, -1][0], at.places[name, -1][0])
        ids[name, -1] = parent, base.actInv(here)
        for index, joint in enumerate(module.type.joints):
            before, offset = ids[name, joint.parent]
            place = offset * pin.XYZQUATToSE3(np.asarray(joint.placement))
            kind = pin.JointModelRevoluteUnaligned(np.asarray(joint.axis))
            made = model.addJoint(before, kind, place, f"{name}.{index}")
            ids[name, index] = made, pin.SE3.Identity()
            names.append((name, index))
            values.append(float(rows[name][0, 7 + index]))
        for carrier, pose, mass, inertia in weights(module.type):
            owner, offset = ids[name, carrier]
            model.appendBodyToJoint(
                owner, pin.Inertia(mass, np.zeros(3), inertia), offset * pin.XYZQUATToSE3(np.asarray(pose))
            )
        parent = ids[name, len(module.joints) - 1][0]
        base = pin.SE3(at.turns[name, len(module.joints) - 1][0], at.places[name, len(module.joints) - 1][0])
    data = model.createData()
    rest = np.zeros(model.nv)
    torques = pin.rnea(model, data, np.array(values), rest, rest)
    return {key: float(t) for key, t in zip(names, torques, strict=True)}


def statics(count: int) -> None:
    random, worst, seconds = np.random.default_rng(0), 0.0, 0.0
    for _ in range(count):
        problem = assembly(random, int(random.integers(1, 4)))
        rows, mode = posture(problem, random), chained(problem)
        bodies = {n: np.array([b.pose]) for n, b in problem.world.bodies.items()}
        begun = time.process_time()
        mine = drives(problem, mode, poses(problem, rows, bodies))
        seconds += time.process_time() - begun
        theirs = by_pinocchio(problem, rows)
        worst = max(worst, *(abs(float(mine[key][0]) - theirs[key]) for key in theirs))
    apart = f"at most {worst:.1e} N m apart, {1e3 * seconds / count:.1f} ms each"
    print(f"statics against Pinocchio: {count} assemblies, {apart}")
    many = {n: np.repeat(r, 1000, axis=0) for n, r in rows.items()}
    begun = time.process_time()
    loads(problem, mode, poses(problem, many, {n: np.repeat(b, 1000, axis=0) for n, b in bodies.items()}))
    joints = sum(len(m.joints) for m in problem.world.modules.values())
    print(f"  in batches of 1000: {1e3 * (time.process_time() - begun):.0f} µs each, {joints} joints")


PLANS = (
    ("real_climb", {"n": "1", "crawlers": "1"}), ("real_climb", {"n": "2", "crawlers": "1"}),
    ("real_climb", {"n": "3", "crawlers": "1"}), ("tow", {"load": "5 kg"}), ("tow", {"load": "10 kg"}),
    ("payload", {"load": "1 kg"}), ("payload", {"load": "3 kg"}), ("real_bridge", {}),
    ("real_climb", {"n": "4", "crawlers": "1"}), ("tow", {"load": "7 kg"}),
)  # fmt: skip


def peaks(count: int) -> None:
    """Greatest torque ratio of plans with inertia, predicted and simulated."""
    worst, base = 0.0, 0.0
    for number in range(count):
        name, given = PLANS[number % len(PLANS)]
        seed = number // len(PLANS)
        problem, _ = compile_problem(EXAMPLES / f"{name}.tamp", None, given, seed)
        outcome = solve(problem, SolveOptions(time=120.0, seed=seed))
        print(f"  {name} {' '.join(given.values())} seed {seed}: ", end="")
        if not outcome.plans:
            print(outcome.status, flush=True)
            continue
        plan = outcome.plans[0]
        begun = time.process_time()
        carried = carry_out(problem, plan)
        spent = (time.process_time() - begun) / max(carried.seconds, 1e-9)
        simulated = max(peak / most for peak, most in carried.peaks.values() if math.isfinite(most))
        predicted = plan.verdict.worst["torque_ratio"] / SAFETY if plan.verdict is not None else float("nan")
        off = 100 * (simulated / predicted - 1)
        worst, base = max(worst, abs(off)), max(base, carried.base)
        print(
            f"torque {predicted:.3f} predicted, {simulated:.3f} simulated ({off:+.1f} %), "
            f"base {1e3 * carried.base:.2f} mm, {'reached' if carried.reached else 'not reached'}, "
            f"{spent:.2f} s per second",
            flush=True,
        )
    print(f"peaks: {count} plans, at most {worst:.1f} % apart, robots within {1e3 * base:.2f} mm", flush=True)


def loops(count: int) -> None:
    random, found = np.random.default_rng(1), list[Held]()
    while len(found) < count:
        problem = assembly(random, int(random.integers(2, 4)))
        held = held_still(problem, posture(problem, random))
        if held.speed <= RESTS:
            found.append(held)
    balance, share = (np.array([getattr(h, n) for h in found]) for n in ("balance", "share"))
    print(
        f"loops against MuJoCo held still: {count} assemblies, torques at most {100 * balance.max():.2g} % of the "
        f"greatest from what the engine's loads ask for (median {100 * np.median(balance):.2g} %), and from those told "
        f"ahead {100 * np.median(share):.2g} % in the median, {100 * share.max():.2g} % at most",
        flush=True,
    )


def limits(count: int, first: int) -> None:
    found, without = list[Limited](), 0
    for number in range(first, first + count):
        text = task(np.random.default_rng(number))
        result = limited(text, list(STRENGTHS)[number % len(STRENGTHS)], number)
        without += result is None
        if result is not None:
            found.append(result)
            told = f"at {BEYOND}: refused {result.refused}, failed {result.failed}"
            print(f"  {number} {result.strength}: {told}; at {WITHIN}: verified {result.verified}, broken "
                  f"{result.broken}, reached {result.reached}", flush=True)  # fmt: skip
    for name in STRENGTHS:
        own = [f for f in found if f.strength == name]
        print(
            f"limits of {name}: {len(own)} plans; at {BEYOND} {sum(f.refused for f in own)} refused, "
            f"{sum(f.failed for f in own)} failed in simulation; at {WITHIN} {sum(f.verified for f in own)} verified, "
            f"{sum(f.broken for f in own)} broke, {sum(f.reached for f in own)} reached",
            flush=True,
        )
    held = sum(f.refused or f.failed for f in found), sum(f.broken for f in found)
    tasks = f"{len(found)} plans ({without} tasks without)"
    print(f"limits: {tasks}, {held[0]} refused or failed beyond, {held[1]} broke within", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--assemblies", type=int, default=200)
    parser.add_argument("--loops", type=int, default=200)
    parser.add_argument("--plans", type=int, default=10)
    parser.add_argument("--limits", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="the first of the plans at their limits")
    given = parser.parse_args()
    for part, count in ((statics, given.assemblies), (loops, given.loops), (peaks, given.plans)):
        if count:
            part(count)
    if given.limits:
        limits(given.limits, given.first)


if __name__ == "__main__":
    main()
