"""The bound P_seqPath: motions between given switch configurations, phase by phase in joint values.

`joint_forest` reads a phase as a forest of joints and `resting_shapes` tells what rests, `batch_kinematics` moves it,
`collision_spheres` say what can meet, `contact_margins` how much clearance is asked next to contacts,
`phase_geometry` holds it all and `proximity` measures what is close; `phase_batch` stacks phases of one structure,
`penalty` and `smoothing` optimise them, `bearing` has them give way to loads, `exact_check` measures the true shapes,
by which `swept_check` accepts or refuses (`swept_clearance`: all along); `attempts` goes from straight starts over
repair and bent or bumped ones to those of `rrt_connect`, which begin by `withdrawals`, and polishes; `phase_paths` ties
them together, `relief` looks for other ways where something bears too much, `mounted` says where all is by joint
values, `warm_starts` keeps what was found.
"""

from .joint_forest import Reason, UnsupportedPhase
from .phase_paths import polish, solve_sequence_path

__all__ = ["Reason", "UnsupportedPhase", "polish", "solve_sequence_path"]
