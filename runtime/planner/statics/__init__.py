"""Whether robots bear themselves."""

from .bearing import asked, borne, exceeded_on, exceeded_switches, kept_at_rest, slowed, unbearable

__all__ = ["asked", "borne", "exceeded_on", "exceeded_switches", "kept_at_rest", "slowed", "unbearable"]
