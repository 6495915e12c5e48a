"""Where everything that a phase moves is, by its joint values."""

from __future__ import annotations

import numpy as np

from .....compiler.ir import World
from ....geometry.transforms import coupled
from ....skeleton import Array, Configuration
from .batch_kinematics import mounted_poses
from .joint_forest import Mount, PhaseTree, pose_vector


def placed(
    tree: PhaseTree, values: Array, start: Configuration, world: World
) -> tuple[dict[str, Array], dict[str, Array]]:
    """All modules `(times, 7 + joints)`, those that rest in constant rows, and the bodies that are carried
    `(times, 7)`, for joint values `(times, joints)` of a phase that begins at `start`."""
    modules = {m: np.tile(state, (len(values), 1)) for m, state in start.modules.items()}
    for module, links in tree.links.items():
        modules[module][:, :7] = _poses(tree, links[-1], values, start.modules[module])
    for column, (module, joint) in enumerate(tree.variables):
        modules[module][:, 7 + joint] = values[:, column]
    for module in tree.links:
        modules[module][:, 7:] = coupled(world.modules[module].type.joints, modules[module][:, 7:])
    return modules, {b: _poses(tree, mount, values, start.bodies[b]) for b, mount in tree.bodies.items()}


def _poses(tree: PhaseTree, mount: Mount, values: Array, before: Array) -> Array:
    """Poses `(times, 7)` of a mounted frame, with quaternions that do not change sign from one to the next."""
    poses = pose_vector(mounted_poses(tree, mount, values))
    quaternions = np.concatenate([before[None, 3:7], poses[:, 3:]])
    flips = np.cumprod(np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
    return np.concatenate([poses[:, :3], poses[:, 3:] * flips[:, None]], axis=1)
