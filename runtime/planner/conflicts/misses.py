"""What of a refusal can be drawn: the posture that comes nearest, and what meets or misses there."""

from __future__ import annotations

from ....compiler.ir import Problem
from ...skeleton import Breach, NearestMiss, Violation, start_configuration
from ..bounds.verdicts import Conflict
from ..motion.keyframes.causes import Cause, Why
from .shortfall import Lack


def miss_of(
    problem: Problem, action: str, message: str, row: str, conflict: Conflict, cause: Cause | None
) -> NearestMiss | None:
    """What can be drawn of a conflict, whose `cause` says more where there is one; None without a posture."""
    if not conflict.violations:
        return None
    worst = conflict.violations[0]
    if cause is None:
        switches = conflict.switches[worst.phase - conflict.first + 1 :]
        return NearestMiss(action, message, row, *_marks(problem, worst), (), switches[0]) if switches else None
    if cause.why == Why.IN_THE_WAY:
        return NearestMiss(action, message, row, *_marks(problem, cause.at[0]), (), cause.nearest)
    bent = tuple((v.names[0], v.names[1]) for v in cause.at) if cause.why == Why.LIMIT else ()
    return NearestMiss(action, message, row, *_marks(problem, worst), bent, cause.nearest)


def lack_of(problem: Problem, message: str, lack: Lack) -> NearestMiss:
    """What can be drawn of a thing that is too far from all that robots come to: the scene at the start."""
    between = (lack.support, lack.name)
    return NearestMiss("", message, str(lack), between, between, (), start_configuration(problem))


def _marks(problem: Problem, violation: Violation) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The modules, effectors and bodies among the names of a violation; and the two of a row, if these are two."""
    world = problem.world
    named = (n for n in violation.names if n in world.modules or n in world.bodies or world.effector(n) is not None)
    marked = tuple(dict.fromkeys(named))
    return marked, marked if violation.kind == Breach.ROW and len(marked) == 2 else ()
