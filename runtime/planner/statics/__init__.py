"""Whether robots bear themselves."""

from .bearing import Unbearable, asked, borne, exceeded_on, exceeded_switches, kept_at_rest, slowed, unbearable

__all__ = ["Unbearable", "asked", "borne", "exceeded_on", "exceeded_switches", "kept_at_rest", "slowed", "unbearable"]
