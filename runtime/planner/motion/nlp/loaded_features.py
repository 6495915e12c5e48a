"""Rows of motion literals that speak of loads, as groups of a program. Those of modes with closed loops, which leave
loads open, are only measured where a plan is checked."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .....compiler.ir import Fact, Problem, Row
from .....compiler.motion.constraints import BodyKind, RestKind
from .....compiler.motion.loaded_rows import LoadedRow, loaded_row, speaks_of_loads
from ....skeleton import Array, Breach
from .row_groups import RowGroup, RowLabel, StageGroup
from .unknowns import UnknownsLayout

LoadedLiteral = tuple[Fact, str, int, int, frozenset[Fact]]
"""A literal, when its rows bind ("switch" or "during"), the slice, the phase, and the mode whose loads count."""


def speaks(problem: Problem, literal: Fact) -> bool:
    """Whether some row of a literal speaks of loads."""
    return any(speaks_of_loads(row) for row in problem.motions[literal[0]].rows)


def loaded_groups(problem: Problem, layout: UnknownsLayout, wanted: Iterable[LoadedLiteral]) -> list[RowGroup]:
    """One group for each row and slice that has something unknown."""
    groups: list[RowGroup] = []
    for literal, when, slice_, phase, mode in dict.fromkeys(wanted):
        motion = problem.motions[literal[0]]
        names = {v.name: o for v, o in zip(motion.variables, literal[1:], strict=True)}
        for row in motion.rows:
            if row.when == when and speaks_of_loads(row):
                made = loaded_row(problem, mode, row, motion.variables, names)
                if made is not None and any(layout.is_unknown(slice_, name) for name in made.slots):
                    groups.append(_group(problem, layout, made, row, literal, slice_, phase))
    return groups


def _group(
    problem: Problem, layout: UnknownsLayout, made: LoadedRow, row: Row, literal: Fact, slice_: int, phase: int
) -> StageGroup:
    places = np.concatenate([layout.slot(slice_, name) for name in made.slots])[None]
    constants: list[Array] = [np.zeros(0)]
    for name, kind in zip(made.objects, made.kinds, strict=True):
        if isinstance(kind, BodyKind | RestKind):
            if isinstance(kind, RestKind):
                constants.append(np.asarray(layout.resting[name]))
            if isinstance(kind.shape, str):
                constants.append(np.array(problem.world.bodies[name].shape.size))
    label = RowLabel(phase, Breach.ROW, literal, ("1",) * row.rows, row.span)
    binds = "inequality" if row.operator in ("<=", ">=") else "equality"
    return StageGroup(binds, made.stage, places, np.concatenate(constants)[None], [label])
