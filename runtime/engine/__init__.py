"""Plans carried out in a physics engine that shares nothing with planner and verifier: MuJoCo."""

from .actor import Simulated
from .conditions import Conditions, NoDisplay
from .playback import carry_out

__all__ = ["Conditions", "NoDisplay", "Simulated", "carry_out"]
