"""Plans carried out in a physics engine that shares nothing with planner and verifier: MuJoCo."""

from .playback import Carried, carry_out

__all__ = ["Carried", "carry_out"]
