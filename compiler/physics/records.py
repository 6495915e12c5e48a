"""Records of the IR: how ends hold, and the stated inertia of links."""

from __future__ import annotations

import math
from dataclasses import field

from ...langs.frozen import dataclass
from ...langs.source import Span

Vec3 = tuple[float, float, float]
FREE = math.inf
"""What is not stated has no limit."""


@dataclass(frozen=True, slots=True)
class Hold:
    """How an end or a body holds in one `manner`: the force along the normal, N, the `shear` across it, the bending
    `moment` and the `twist` about the normal, N m, and the coefficient of friction. Infinite where nothing is
    stated."""

    manner: str
    force: float = FREE
    shear: float = FREE
    moment: float = FREE
    twist: float = FREE
    friction: float = FREE
    span: Span | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Inertial:
    """A stated mass fixed to the moving frame of `joint` (-1: the module frame): kilograms, its centre there, and the
    inertia (xx, xy, xz, yy, yz, zz) about the centre along the axes of that frame, kg m²."""

    joint: int
    mass: float
    centre: Vec3
    inertia: tuple[float, float, float, float, float, float]


MANNERS = ("bond", "dock", "grip", "pad", "rest")
"""How a kept pair is borne: by box limits (bond, dock, grip), or by contact that presses and rubs (pad, which also
sticks with its `force`, and rest)."""
CONTACTS = ("pad", "rest")
NOTHING = "nothing"
"""Of a pair that is kept, but bears nothing."""


def weaker(first: Hold | None, second: Hold | None, manner: str) -> Hold | None:
    """What a pair bears whose sides hold like this: of each number the smaller one; None where neither states any."""
    known = [h for h in (first, second) if h is not None]
    if not known:
        return None
    span = known[0].span
    if len(known) == 2 and min(known[1].force, known[1].moment) < min(known[0].force, known[0].moment):
        span = known[1].span
    force, shear, moment, twist, friction = (
        min(getattr(h, n) for h in known) for n in ("force", "shear", "moment", "twist", "friction")
    )
    return Hold(manner, force, shear, moment, twist, friction, span)
