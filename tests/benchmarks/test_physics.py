"""The benchmark of physics: statics against Pinocchio on a few assemblies."""

import re
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))


def test_torques_are_those_of_pinocchio() -> None:
    import physics

    from tamplang.compiler.physics.frames import poses
    from tamplang.compiler.physics.statics import drives

    random = np.random.default_rng(1)
    for arms in (1, 2, 3):
        problem = physics.assembly(random, arms)
        rows = physics.posture(problem, random)
        bodies = {n: np.array([b.pose]) for n, b in problem.world.bodies.items()}
        mine = drives(problem, physics.chained(problem), poses(problem, rows, bodies))
        theirs = physics.by_pinocchio(problem, rows)
        assert max(abs(t) for t in theirs.values()) > 0.1
        assert all(abs(float(mine[key][0]) - theirs[key]) < 1e-9 for key in theirs)
        assert re.fullmatch(r"c\d", next(iter(problem.world.modules)))
