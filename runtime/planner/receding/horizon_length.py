"""How many actions get their motion in one window: as many as the user says, or as many as seem wise."""

from __future__ import annotations

from dataclasses import dataclass

FIRST, LEAST, MOST = 4, 2, 16
"""The adaptive horizon at first, at least, at most."""


@dataclass(slots=True)
class Horizon:
    """`length` actions get their motion in the next window; where it `adapts`, windows tell how hard they were."""

    length: int
    adapts: bool

    def adapt(self, hard: bool) -> None:
        """Look farther ahead where motion is refused, less far where it is easy."""
        if self.adapts:
            self.length = min(MOST, 2 * self.length) if hard else max(LEAST, self.length - 1)


def horizon_of(length: int | None) -> Horizon:
    """The horizon of a new run; None for one that adapts."""
    return Horizon(FIRST, True) if length is None else Horizon(length, False)
