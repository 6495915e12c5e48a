"""Physics: statics against Pinocchio, and torques predicted against simulated.

    python benchmarks/physics.py [--assemblies N] [--plans N]

Random assemblies are chains of one to three docked arms of random lengths, weights and postures. Predicted peaks are
the verifier's, of plans with inertia; simulated ones those of `tamplang simulate`.
"""

from __future__ import annotations

import argparse
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

from tamplang.compiler import ir
from tamplang.compiler.physics.frames import poses
from tamplang.compiler.physics.statics import drives, loads
from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.engine import carry_out
from tamplang.runtime.planner.lgp import SolveOptions, solve
from tamplang.runtime.verify.inertia import weights

EXAMPLE = Path(__file__).resolve().parent.parent / "examples" / "real_climb.tamp"
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


def peaks(count: int) -> None:
    """Greatest torque ratio of a plan with inertia, predicted and simulated."""
    text = EXAMPLE.read_text(encoding="utf-8").replace("physics = statics", "physics = dynamics")
    for number in range(count):
        n = 1 + number % 3
        problem, _ = compile_text(text, "real_climb.tamp", None, {"n": str(n), "crawlers": "1"}, number)
        outcome = solve(problem, SolveOptions(time=60.0, seed=number))
        print(f"real_climb n={n} seed={number}: ", end="")
        if not outcome.plans:
            print(outcome.status)
            continue
        plan = outcome.plans[0]
        begun = time.process_time()
        carried = carry_out(problem, plan)
        spent = (time.process_time() - begun) / max(carried.seconds, 1e-9)
        simulated = max(peak / most for peak, most in carried.peaks.values())
        predicted = plan.verdict.worst["torque_ratio"] / SAFETY if plan.verdict is not None else float("nan")
        off = 100 * (simulated / predicted - 1)
        print(
            f"torque {predicted:.3f} predicted, {simulated:.3f} simulated ({off:+.1f} %), "
            f"base {1e3 * carried.base:.2f} mm, {'reached' if carried.reached else 'not reached'}, "
            f"{spent:.2f} s per second",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--assemblies", type=int, default=200)
    parser.add_argument("--plans", type=int, default=10)
    given = parser.parse_args()
    statics(given.assemblies)
    peaks(given.plans)


if __name__ == "__main__":
    main()
