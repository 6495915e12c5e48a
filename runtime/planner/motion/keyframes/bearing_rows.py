"""Rows of P_seq that keep loads at switches within strengths, before and after each."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .....compiler.ir import Fact, Problem
from .....compiler.physics.safety import safety_of
from .....compiler.physics.stages import rows_of
from .....compiler.physics.structure import structure
from ....geometry.attachments import next_mode
from ....skeleton import Breach, Skeleton
from ...statics.settings import STATICS
from ..nlp.loop_rows import LoopGroup
from ..nlp.row_groups import RowGroup, RowLabel, StageGroup
from ..nlp.unknowns import UnknownsLayout


def bearing_rows(
    skeleton: Skeleton, layout: UnknownsLayout, phases: range, free: bool, loops: bool = True
) -> list[RowGroup]:
    """What keeps loads before and after each switch, and where the state before is `free`, in that."""
    wanted = {(0, phases[0], skeleton.phases[phases[0]].mode)} if free else set()
    for slice_, phase in enumerate(phases, start=1):
        wanted |= {(slice_, phase, skeleton.phases[phase].mode), (slice_, phase, next_mode(skeleton, phase))}
    return bearing_groups(skeleton.problem, layout, wanted, loops)


def bearing_groups(
    problem: Problem, layout: UnknownsLayout, wanted: Iterable[tuple[int, int, frozenset[Fact]]], loops: bool = True
) -> list[RowGroup]:
    """Rows at slices, each with its phase and mode, where something that bears is unknown: one group for each slice
    and mode, and with `loops` one for all slices of a mode in which loops leave loads open. Brakes are left out: what
    moves begins and ends with its drive alone."""
    safety = safety_of(problem.options) / STATICS.room
    groups: list[RowGroup] = []
    shared: dict[frozenset[Fact], list[tuple[int, RowLabel]]] = {}
    for slice_, phase, mode in sorted(wanted, key=lambda w: (w[0], w[1], sorted(w[2]))):
        built = structure(problem, mode)
        if built.loops:
            names = sorted({edge.child[0] for edge in built.edges})
            if loops and any(layout.is_unknown(slice_, name) for name in names):
                label = RowLabel(phase, Breach.TORQUE, (names[0], ""), ("1",))
                shared.setdefault(mode, []).append((slice_, label))
            continue
        rows = rows_of(problem, mode, safety, still=False)
        if rows is None or not any(layout.is_unknown(slice_, name) for name in rows.slots):
            continue
        index = np.concatenate([layout.slot(slice_, name) for name in rows.slots])[None]
        units = ("1",) * rows.stage.rows
        label = RowLabel(phase, Breach.TORQUE, (rows.slots[0], ""), units)
        groups.append(StageGroup("inequality", rows.stage, index, np.zeros((1, 0)), [label]))
    for mode, instances in shared.items():
        slices, labels = [t for t, _ in instances], [label for _, label in instances]
        groups.append(LoopGroup(problem, mode, layout, slices, safety, labels))
    return groups
