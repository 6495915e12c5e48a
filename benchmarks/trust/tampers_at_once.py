"""Changes of plans whose robots move at once: motions at another time, robots that meet, and formats that are mixed."""

from __future__ import annotations

import numpy as np

from .checker.frames import Spline
from .draft import Draft, span
from .kinds import kind, need
from .tampers_motion import crowded

FIRST = "tamplang-plan/1"


def _second(draft: Draft) -> bool:
    return bool(draft.data["format"] != FIRST)


@kind()
def spline_at_another_time(draft: Draft) -> None:
    """A robot sets out later, by the rest that its spline ends with."""
    need(_second(draft) and draft.data["splines"])
    spline = draft.chance.choice(draft.data["splines"])
    knots, values = np.array(spline["knots"]), np.array(spline["values"])
    moving = np.flatnonzero(np.abs(values - values[-1]).max(axis=1) > 1e-9)
    need(len(moving))
    rest = knots[-1] - knots[min(moving[-1] + 1, len(knots) - 1)]
    by = min(rest, draft.chance.uniform(0.05, 0.5))
    need(by > 1e-3)
    old = Spline(spline["knots"], spline["values"])
    rows = old(np.clip(knots - by, knots[0], None))
    spline["values"] = [[round(float(v), 10) for v in row] for row in rows]
    for phase in range(span(spline)[0], span(spline)[1] + 1):
        draft.derive(phase)


@kind()
def two_robots_meet_between_samples(draft: Draft) -> None:
    """Both swing out and back within a phase, slowly, and no sample is where they are near each other."""
    phase = draft.phase(0.3)
    modules = [m for m in draft.data["modules"] if m["joints"]]
    need(len(modules) > 1)
    for module in draft.chance.sample(modules, 2):
        need(span(draft.spline(module["name"], phase)) == (phase, phase))
        joint = draft.chance.randrange(len(module["joints"]))
        by = draft.chance.choice([-1, 1]) * draft.chance.uniform(0.5, 2.0)
        draft.bump(module["name"], phase, joint, by, 0.1, 0.9)
    draft.faster(phase, 0.1)
    crowded(draft, phase)


@kind(false=True)
def formats_mixed(draft: Draft) -> None:
    """Splines as one format has them in a plan that says to be of the other."""
    need(draft.data["splines"])
    if not _second(draft):
        for spline in draft.data["splines"]:
            spline["from"] = spline["until"] = spline.pop("phase")
        return
    if draft.chance.random() < 0.5:
        draft.data["format"] = FIRST
        return
    spline = draft.chance.choice(draft.data["splines"])
    spline["phase"] = spline.pop("from")
    del spline["until"]
