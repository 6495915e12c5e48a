"""Which effectors of modules are docked to which, phase by phase."""

from __future__ import annotations

from ...langs.frozen import dataclass
from ..plan import LiteralRecord, Plan
from .motion import Pose, pose_of, poses


@dataclass(frozen=True, slots=True)
class Dock:
    """Effectors `one` and `other`, such as "c[1].A", keep the pose `relative` of the second in the frame of the first
    during `phases`; the number of all phases stands for the time after the last."""

    one: str
    other: str
    relative: Pose
    phases: tuple[int, ...]


def docks(plan: Plan) -> list[Dock]:
    """All docks of the plan, each as it is when it first holds."""
    from ...compiler.poses import compose, inverse

    modes = [*(p.mode for p in plan.phases), plan.final_mode]
    ends = {f"{m.name}.{e.name}" for m in plan.modules for e in m.effectors}
    keeping = _keeping(plan)
    held: dict[tuple[str, str], list[int]] = {}
    for index, mode in enumerate(modes):
        for literal in mode:
            pair = _pair(literal, keeping, ends)
            if pair is not None and pair[::-1] not in held and index not in held.get(pair, []):
                held.setdefault(pair, []).append(index)
    import numpy as np

    starts = [*(p.start for p in plan.phases), plan.times[-1]]
    found = []
    for (one, other), phases in held.items():
        at = np.array([starts[phases[0]]])
        a, b = (pose_of(poses(plan, end, at)[0]) for end in (one, other))
        found.append(Dock(one, other, compose(inverse(a), b), tuple(phases)))
    return found


def _pair(literal: LiteralRecord, keeping: frozenset[str], ends: set[str]) -> tuple[str, str] | None:
    fits = literal.predicate in keeping and len(literal.args) == 2 and ends.issuperset(literal.args)
    return (literal.args[0], literal.args[1]) if fits and _module(literal.args[0]) != _module(literal.args[1]) else None


def _module(end: str) -> str:
    return end.rpartition(".")[0]


def _keeping(plan: Plan) -> frozenset[str]:
    """The motion predicates that keep a pose, as the plan's own texts declare them."""
    from ...compiler.imports import load_sources
    from ...langs import syntax
    from ...langs.source import Source

    sources = [Source(s.path, s.text) for s in plan.task.sources]
    library, _, _ = load_sources(sources, {f.path: f.data for f in plan.task.files})
    return frozenset(
        name
        for name, motion in library.motions.items()
        if any(isinstance(i, syntax.MotionRow) and i.when == "keep" for i in motion.items)
    )
