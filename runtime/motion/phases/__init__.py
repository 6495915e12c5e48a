"""The bound P_seqPath: motions between given switch configurations, phase by phase in joint values.

`tree` reads a phase as a forest of joints, `kinematics` moves it, `balls` and `shapes` say what can meet, `shares` how
much clearance is asked next to contacts, `geometry` holds it all and `near` measures what is close; `batch` stacks
phases of one structure, `penalty` and `smoothing` optimise them, `swept` accepts or refuses; `attempts` goes from
straight starts over repair and bent or bumped ones to those of `sampling`, and polishes; `path` ties them together.
"""

from .path import polish, solve_sequence_path
from .tree import Reason, UnsupportedPhase

__all__ = ["Reason", "UnsupportedPhase", "polish", "solve_sequence_path"]
