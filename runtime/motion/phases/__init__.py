"""The bound P_seqPath: motions between given switch configurations, phase by phase in joint values.

`tree` reads a phase as a forest of joints, `kinematics` moves it, `geometry` measures clearances, `penalty` and
`smoothing` optimise, `batch` holds stacked phases and the swept check, `sampling` is the way out when smoothing
fails, and `path` ties them together.
"""

from .path import polish, solve_sequence_path
from .tree import Reason, UnsupportedPhase

__all__ = ["Reason", "UnsupportedPhase", "polish", "solve_sequence_path"]
