"""The 3-D scene of a solve that found nothing: the start, then the postures that came nearest, with what is missed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..plan import Plan
from ..skeleton import NearestMiss
from .replay import replay_data

FAULT = "#d6271f"
AT_THE_START = "the scene at the start"


def posture_data(plan: Plan, misses: Sequence[NearestMiss]) -> dict[str, Any]:
    """What the player needs of a plan that holds one posture a second. `marks` holds for each the paths of what
    is drawn as at fault, and the names of two things between which something is missing; nothing moves in between."""
    data = replay_data(plan)
    captions = [AT_THE_START, *(f"{miss.action}: {miss.row}" if miss.action else miss.row for miss in misses)]
    marks = [((), ()), *((_paths(plan, data["names"], miss), miss.apart) for miss in misses)]
    return data | {
        "phases": [(float(second), float(second + 1), text, "") for second, text in enumerate(captions)],
        "colours": data["colours"] * len(captions),
        "marks": marks,
        "fault": FAULT,
        "still": True,
    }


def _paths(plan: Plan, names: dict[str, str], miss: NearestMiss) -> list[str]:
    """Where in the scene that is drawn which a miss concerns: of a joint, what it moves."""
    numbers = {module.name: number for number, module in enumerate(plan.modules)}
    paths = [f"module{numbers[name]}" if name in numbers else names[name] for name in miss.marked]
    for module, joint in miss.bent:
        at = [j.name for j in plan.modules[numbers[module]].joints].index(joint)
        paths.append(f"module{numbers[module]}/frame{at + 1}")
    return paths
