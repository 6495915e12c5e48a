"""The least time of a way, by the limits of a joint alone."""

from __future__ import annotations

import math

from ....compiler.ir import Joint


def least_time(joint: Joint, way: float) -> float:
    """Seconds from rest to rest."""
    speed, acceleration = joint.speed, joint.acceleration
    if way <= 0.0 or math.isinf(speed):
        return 0.0 if way <= 0.0 or math.isinf(acceleration) else 2.0 * math.sqrt(way / acceleration)
    if math.isinf(acceleration):
        return way / speed
    long = way > speed * speed / acceleration
    return way / speed + speed / acceleration if long else 2.0 * math.sqrt(way / acceleration)
