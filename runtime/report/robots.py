"""Which modules form which robot in each phase, and what they hold, from the plan's motion literals."""

from __future__ import annotations

from collections.abc import Iterable

from ...langs.frozen import dataclass
from ..plan import LiteralRecord, Plan

PALETTE = ("#3f7fd0", "#e08a2c", "#2f9e77", "#a65fc4", "#c9506b", "#3aa6b9", "#8a9a2e", "#8d6e5a")
ACCENT = "#e2b714"
FIXED = "#9aa0a8"
BY_ITSELF = "#1fb5a8"


@dataclass(frozen=True, slots=True)
class Robot:
    """Modules, by index, that are joined in a phase; `hue` is the colour of the first of them."""

    modules: tuple[int, ...]
    hue: str


def effector_owners(plan: Plan) -> dict[str, int]:
    """Effector object to index of its module."""
    return {f"{m.name}.{e.name}": i for i, m in enumerate(plan.modules) for e in m.effectors}


def group_modules(plan: Plan, mode: Iterable[LiteralRecord]) -> list[Robot]:
    """The groups of modules that the literals of `mode` connect, effector to effector."""
    owners = effector_owners(plan)
    root = list(range(len(plan.modules)))

    def find(index: int) -> int:
        while root[index] != index:
            index = root[index]
        return index

    for literal in mode:
        joined = sorted({find(owners[a]) for a in literal.args if a in owners})
        for other in joined[1:]:
            root[other] = joined[0]
    groups: dict[int, list[int]] = {}
    for index in range(len(root)):
        groups.setdefault(find(index), []).append(index)
    return [Robot(tuple(g), PALETTE[g[0] % len(PALETTE)]) for _, g in sorted(groups.items())]


def module_colours(plan: Plan, robots: list[Robot]) -> list[str]:
    """One colour per module: the hue of its robot, lighter for every further module of the same robot."""
    colours = [FIXED] * len(plan.modules)
    for robot in robots:
        for rank, index in enumerate(robot.modules):
            colours[index] = lighten(robot.hue, 0.28 * (rank % 3))
    return colours


def lighten(colour: str, share: float) -> str:
    """`colour` (#rrggbb) mixed with `share` of white."""
    channels = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return "#" + "".join(f"{round(c + (255 - c) * share):02x}" for c in channels)


def literal_text(literal: LiteralRecord, motion: bool) -> str:
    """A literal in the notation of the language."""
    left, right = ("[", "]") if motion else ("(", ")")
    return f"{left}{' '.join([literal.predicate, *literal.args])}{right}"
