"""Whether robots bear themselves."""

from .bearing import asked, borne, exceeded_on, exceeded_switches, slowed, unbearable

__all__ = ["asked", "borne", "exceeded_on", "exceeded_switches", "slowed", "unbearable"]
