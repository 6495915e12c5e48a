"""The optional mechanisms of the planner, and how each is switched off."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from tamplang.compiler.settings import override

NEVER = 10**9
PLANNER = "tamplang.runtime.planner"
SEARCH, KEYFRAMES = f"{PLANNER}.search.settings:SEARCH", f"{PLANNER}.motion.keyframes.settings:KEYFRAMES"
BOUNDS = f"{PLANNER}.bounds.settings:BOUNDS"
PHASES, RECEDING = f"{PLANNER}.motion.phases.settings:PHASES", f"{PLANNER}.receding.settings:RECEDING"


@dataclass(frozen=True)
class Mechanism:
    """`changes` are (place, name, value): a settings record, a class or a module, and what it gets instead.
    `arguments` are given to the command beside. One that is off as a rule is switched on instead (`on`)."""

    name: str
    text: str
    changes: Sequence[tuple[str, str, Any]]
    arguments: Sequence[str] = ()
    on: bool = False


def _nothing_expected(*_: object) -> list[tuple[int, int, bool]]:
    return []


def _unpolished(make: Any) -> Any:
    return partial(make, polish=False)


MECHANISMS = {
    m.name: m
    for m in (
        Mechanism("slack", "slack maximisation among plans of one cost", [(SEARCH, "slack_width", 0)]),
        Mechanism("penalties", "learned penalties on strained actions",
                  [(SEARCH, "penalty_first", 0.0), (SEARCH, "penalty_most", 0.0), (RECEDING, "least_penalty", 0.0)]),
        Mechanism("nogoods", "generalised no-goods: refusals expected of what is alike",
                  [(f"{PLANNER}.conflicts.nogoods:GeneralisedNoGoods", "expected_refusals", _nothing_expected)]),
        Mechanism("renaming", "states that are alike up to names of modules met once",
                  [("tamplang.compiler.symbolic.settings:SYMBOLIC", "renamed_from", NEVER)]),
        Mechanism("repair", "local repair of switches around phases without a path",
                  [(f"{PLANNER}.bounds.solves", "MENDS", ()), (f"{PLANNER}.bounds.solves", "QUICK_MENDS", ())]),
        Mechanism("redraws", "all switches drawn anew where a phase has no path",
                  [(BOUNDS, "redraws", 0), (BOUNDS, "redrawn_phases", 0)]),
        Mechanism("places", "placement samples: many things laid out on a base", [(KEYFRAMES, "laid_out_from", NEVER)]),
        Mechanism("postures", "sampled postures near the target",
                  [(KEYFRAMES, "postures_anywhere", 0), (KEYFRAMES, "postures_turned", 0)]),
        Mechanism("sweeps", "swept test of prismatic motion", [(KEYFRAMES, "sweep_moved", float("inf"))]),
        Mechanism("alone", "phases that span the most tried alone before windows", [(KEYFRAMES, "most_stretched", 0)]),
        Mechanism("gaits", "windows started from the switch one gait period back", [(KEYFRAMES, "gait_period", NEVER)]),
        Mechanism("bumps", "bumped starts of phases", [(PHASES, "levels", ())]),
        Mechanism("trees", "sampled trees for phases without a smooth start",
                  [(PHASES, "quick_rounds", 0), (PHASES, "rounds", 0)]),
        Mechanism("pushing", "paths that nearly keep clear pushed away once more", [(PHASES, "repaired", -1e9)]),
        Mechanism("giving up", "phases given up in which things have passed each other", [(PHASES, "stuck", 1e9)]),
        Mechanism("warm paths", "paths of phases kept whose switches stay", [(PHASES, "made", -1.0)]),
        Mechanism("polish", "feasible motions made cheaper", [(f"{PLANNER}.lgp", "MotionSettings", _unpolished)]),
        Mechanism("speculation", "bounds asked ahead by a second process (--jobs 2)", [], ("--jobs", "2"), on=True),
    )
}  # fmt: skip


def switch(name: str) -> None:
    """Switch a mechanism off for the rest of this process."""
    for place, attribute, value in MECHANISMS[name].changes:
        home, _, inner = place.partition(":")
        module: Any = importlib.import_module(home)
        target = getattr(module, inner) if inner else module
        old = getattr(target, attribute)
        if inner.isupper():
            override(target, **{attribute: value})
        else:
            setattr(target, attribute, _unpolished(old) if value is _unpolished else value)
