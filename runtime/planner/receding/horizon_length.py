"""How many actions get their motion in one window: as many as the user says, or as many as seem wise."""

from __future__ import annotations

from dataclasses import dataclass

from .settings import RECEDING


@dataclass(slots=True)
class Horizon:
    """`length` actions get their motion in the next window; where it `adapts`, windows tell how hard they were."""

    length: int
    adapts: bool

    def adapt(self, hard: bool) -> None:
        """Look farther ahead where motion is refused, less far where it is easy."""
        if self.adapts:
            longer, shorter = min(RECEDING.most_length, 2 * self.length), max(RECEDING.least_length, self.length - 1)
            self.length = longer if hard else shorter


def horizon_of(length: int | None) -> Horizon:
    """The horizon of a new run; None for one that adapts."""
    return Horizon(RECEDING.first_length, True) if length is None else Horizon(length, False)
