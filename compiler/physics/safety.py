"""How much stronger than its loads everything must be."""

from __future__ import annotations

from .. import ir
from ..options import OPTIONS


def safety_of(options: ir.Options) -> float:
    """How many times its load everything must bear."""
    return float(OPTIONS["safety"].default if options.safety is None else options.safety)


def weighed(options: ir.Options) -> bool:
    """Whether the task asks for forces."""
    return options.physics not in (None, "none")
