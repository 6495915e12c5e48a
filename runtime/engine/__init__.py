"""Plans carried out in a physics engine that shares nothing with planner and verifier: MuJoCo."""

from .playback import Simulated, carry_out

__all__ = ["Simulated", "carry_out"]
