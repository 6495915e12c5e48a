"""The shapes of things that move and rest, at every look of a schedule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ....compiler.ir import Problem, Shape
from ....compiler.module_parts import module_parts
from ....compiler.physics.frames import rotation
from ....langs.frozen import dataclass
from ...geometry.exact_distances import Forms, Indices, Posed
from ...geometry.resampling import Linker, between
from ...geometry.transforms import compose, joint_frames
from ...skeleton import Array, Configuration, PhasePath, Skeleton
from .even_splines import between_knots


@dataclass(frozen=True, slots=True)
class SolidFrames:
    """Some solids at some instants: `positions` `(T, n, 3)` and `rotations` `(T, n, 3, 3)` in the world; `solids`
    `(n,)` are their numbers."""

    solids: Indices
    positions: Array
    rotations: Array

    def at(self, instants: slice | Indices) -> SolidFrames:
        return SolidFrames(self.solids, self.positions[instants], self.rotations[instants])

    def of(self, columns: Indices) -> SolidFrames:
        return SolidFrames(self.solids[columns], self.positions[:, columns], self.rotations[:, columns])


class Solids:
    """The shapes of all modules and movable bodies of a problem, numbered; `thing` names what each belongs to."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self.thing: list[str] = []
        self._local: list[tuple[int, Array]] = []
        shapes: list[Shape] = []
        world = problem.world
        for name, module in world.modules.items():
            for part in module_parts(module.type):
                self.thing.append(name)
                self._local.append((part.joint, np.asarray(part.placement)))
                shapes.append(part.shape)
        for name, body in world.bodies.items():
            if body.movable:
                for solid in body.shape.solids:
                    self.thing.append(name)
                    self._local.append((-1, np.asarray(solid.placement)))
                    shapes.append(solid.shape)
        self.forms = Forms(shapes)
        self.of: dict[str, Indices] = {
            name: np.array([k for k, t in enumerate(self.thing) if t == name], dtype=np.intp)
            for name in dict.fromkeys(self.thing)
        }

    def things(self, placed: SolidFrames) -> list[str]:
        return list(dict.fromkeys(self.thing[k] for k in placed.solids))

    def placed(self, modules: Mapping[str, tuple[Array, Array]], bodies: Mapping[str, Array]) -> SolidFrames:
        """Modules by the poses `(T, 7)` of their frames and their joints `(T, n)`, bodies by poses `(T, 7)`."""
        found: list[Array] = []
        numbers: list[int] = []
        for name, (poses, joints) in modules.items():
            frames = joint_frames(self._problem.world.modules[name].type.joints, poses, joints)
            for k in self.of.get(name, np.zeros(0, dtype=np.intp)):
                joint, local = self._local[k]
                found.append(compose(frames[joint + 1], local))
                numbers.append(int(k))
        for name, poses in bodies.items():
            for k in self.of.get(name, np.zeros(0, dtype=np.intp)):
                found.append(poses)
                numbers.append(int(k))
        count = max((len(rows) for rows in found), default=1)
        rows = np.stack(found, axis=1) if found else np.zeros((count, 0, 7))
        return SolidFrames(np.array(numbers, dtype=np.intp), rows[..., :3], rotation(rows[..., 3:]))

    def resting(self, thing: str, at: Configuration) -> SolidFrames:
        """The solids of a thing in a configuration `(1, n)`."""
        if thing in at.modules:
            row = at.modules[thing][None]
            return self.placed({thing: (row[:, :7], row[:, 7:])}, {})
        return self.placed({}, {thing: at.bodies[thing][None]})

    def along(
        self, skeleton: Skeleton, phase: int, path: PhasePath, before: Configuration, moved: Sequence[str], looks: int
    ) -> SolidFrames:  # fmt: skip
        """The solids that a phase moves, at `looks` instants per knot of its path. Poses follow the joints through what
        the mode holds, from what rests; only what nothing holds is interpolated."""
        joints = {m: before.modules[m][None, 7:] for m in before.modules}
        joints |= {m: between_knots(path.modules[m][:, 7:], looks) for m in moved if m in path.modules}
        resting = {m: row[None, :7] for m, row in before.modules.items() if m not in moved}
        resting |= {b: row[None] for b, row in before.bodies.items() if b not in moved}
        even = np.linspace(0.0, 1.0, path.samples)
        count = looks * (path.samples - 1) + 1
        linker = Linker(self._problem, joints, before, resting, count)
        linker.follow(skeleton.phases[phase].mode)

        def poses(name: str, rows: Array) -> Array:
            found = linker.poses.get(name)
            return between(even, rows, np.linspace(0.0, 1.0, count)) if found is None else found

        modules = {m: (poses(m, path.modules[m][:, :7]), joints[m]) for m in moved if m in path.modules}
        return self.placed(modules, {b: poses(b, path.bodies[b]) for b in moved if b in path.bodies})

    def posed(self, placed: SolidFrames, instant: Indices, column: Indices) -> Posed:
        """Solids `(m,)` at instants `(m,)`, as distances want them."""
        return Posed(
            self.forms, placed.solids[column], placed.positions[instant, column], placed.rotations[instant, column]
        )


def travelled(placed: SolidFrames, reach: Array) -> Array:
    """How far points of solids go from one instant to the next `(T - 1, n)`, at most, but for the bend of their way;
    `reach` `(n,)` is that of the sphere around each."""
    shift = np.linalg.norm(np.diff(placed.positions, axis=0), axis=-1)
    turn = np.linalg.norm(np.diff(placed.rotations, axis=0), axis=(-2, -1))
    return np.asarray(shift + reach * turn / np.sqrt(2.0))
