"""The verdict of the second checker on the object of a plan file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from tamplang.compiler import ir
from tamplang.compiler.pipeline import UsageError
from tamplang.langs.diagnostics import SourceError

from .form import upgraded
from .lengths import Lengths
from .motion import Recording
from .replay import replay
from .scene import compiled, differences
from .touch import parts_of
from .watch import watch


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong: `amount` and `limit` where it is measured (SI)."""

    kind: str
    message: str
    amount: float = math.inf
    limit: float = 0.0


def judge(plan: Any) -> list[Finding]:
    """All that is wrong with a plan; empty for a good one. A plan that cannot be read is wrong, too."""
    found: list[Finding] = []
    try:
        for kind, message, amount, limit in _findings(plan):
            found.append(Finding(kind, message, amount, limit))
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, StopIteration, RecursionError) as error:
        found.append(Finding("structure", f"{type(error).__name__}: {error}"))
    except (OverflowError, ZeroDivisionError, FloatingPointError, AssertionError) as error:
        found.append(Finding("structure", f"{type(error).__name__}: {error}"))
    return found


def _findings(plan: Any) -> Iterator[tuple[str, str, float, float]]:
    plan = upgraded(plan)
    try:
        problem = compiled(plan["task"])
    except (SourceError, UsageError) as error:
        yield "source", str(error)[:200], math.inf, 0.0
        return
    different = list(differences(problem, plan))
    for what in different[:5]:
        yield "scene", what, math.inf, 0.0
    if different:
        return
    recording = Recording(plan, problem)
    yield from replay(problem, plan, recording, lambda sample: lengths(problem, recording, sample))
    yield from watch(problem, plan, recording)


def lengths(problem: ir.Problem, recording: Recording, sample: int) -> Lengths:
    """What conditions measure, in the scene at a sample."""
    shapes: dict[str, list[Any]] = {}
    stored = recording.stored(sample)
    for name in recording.bodies:
        solid = recording.solid(name)
        shapes[name] = [] if solid is None else [(solid, stored(name)[0])]
    for name, chain in recording.chains.items():
        frames = chain.frames(recording.joints[name][sample : sample + 1])
        base = recording.bases[name][sample]
        shapes[name] = [(solid, base @ frames[joint][0] @ at) for _, joint, at, solid in parts_of(chain)]
        for end in chain.ends:
            solid = recording.solid(f"{name}.{end}")
            place = stored(f"{name}.{end}")[0]
            shapes[f"{name}.{end}"] = [] if solid is None else [(solid, place)]
    return Lengths(problem.world, shapes)
