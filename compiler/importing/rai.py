"""Scenes of rai (`.g`): frames that hang on each other, of which some are joints, as modules and bodies.

A frame lies at `Q` in its parent, or at `X` in the world; quaternions have their scalar first. A joint moves behind its
`pre`. A `ssBox` has its rounding within its size.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ...langs.source import Span
from ..ir import IDENTITY, Pose, Vec3
from ..poses import about, compose, inverse, make
from .faults import FaultList
from .models import (
    FAR,
    STRAIGHT,
    Form,
    Hinge,
    Models,
    PartWeight,
    RobotModel,
    RobotPart,
    Thing,
    linked,
    plain_ends,
    relative,
)
from .names import STANDARD, GivenNames
from .rai_shapes import RaiShapes

if TYPE_CHECKING:
    from .rai_texts import RaiAttribute, RaiEntry

MOVES: dict[str, tuple[str, Vec3]] = {
    "hingeX": ("revolute", (1.0, 0.0, 0.0)), "hingeY": ("revolute", (0.0, 1.0, 0.0)),
    "hingeZ": ("revolute", (0.0, 0.0, 1.0)), "transX": ("prismatic", (1.0, 0.0, 0.0)),
    "transY": ("prismatic", (0.0, 1.0, 0.0)), "transZ": ("prismatic", (0.0, 0.0, 1.0)),
}  # fmt: skip
LOOSE = ("rigid", "free")


@dataclass(slots=True)
class RaiFrame:
    """A frame of the scene: what says it, its attributes and its parent."""

    name: str
    span: Span
    given: dict[str, RaiAttribute]
    parent: str | None
    place: Pose | None = None
    origin: Pose = IDENTITY
    below: list[str] = field(default_factory=list)


class RaiScene:
    """Makes modules and bodies of the entries of a file and what it includes."""

    def __init__(self) -> None:
        self.frames: dict[str, RaiFrame] = {}
        self.faults = FaultList()
        self.models, self.names, self.shapes = Models(), GivenNames(STANDARD), RaiShapes(self)

    def add(self, entry: RaiEntry) -> None:
        """Take in a frame, a change of one, or the end of one."""
        known = next((n for n in (entry.name, entry.prefix + entry.name) if n in self.frames), None)
        if entry.edits or entry.deletes:
            if known is None:
                self.faults.note(entry.span, f"there is no frame `{entry.name}` to change: rai goes on without")
            elif entry.deletes:
                del self.frames[known]
            else:
                frame = self.frames[known]
                frame.given |= entry.given
                frame.parent = self._parent(entry) if entry.parents else frame.parent
            return
        name = entry.prefix + entry.name
        if name in self.frames:
            self.fault(entry.span, f"two frames are called `{name}`")
            return
        self.frames[name] = RaiFrame(name, entry.span, dict(entry.given), self._parent(entry))

    def _parent(self, entry: RaiEntry) -> str | None:
        if len(entry.parents) > 1:
            self.fault(entry.span, f"`{entry.name}` hangs on {len(entry.parents)} frames; write one in its brackets")
        for parent in entry.parents[:1]:
            known = next((n for n in (entry.prefix + parent, parent) if n in self.frames), None)
            if known is None:
                self.fault(entry.span, f"`{entry.name}` hangs on `{parent}`, which is not there")
            return known
        return None

    def build(self) -> Models:
        """The modules and bodies. Raises SourceError."""
        for frame in self.frames.values():
            if frame.parent is not None and frame.parent not in self.frames:
                self.fault(frame.span, f"`{frame.name}` hangs on `{frame.parent}`, which is not there")
        self.faults.end()
        for name in self.frames:
            self._resolve(name, set())
        self.faults.end()
        for frame in self.frames.values():
            if frame.parent is not None:
                self.frames[frame.parent].below.append(frame.name)
        taken: set[str] = set()
        for frame in self.frames.values():
            if self._moves(frame) and frame.name not in taken:
                taken |= self._robot(frame)
        self._bodies(taken)
        self.faults.end()
        self.models.told += self.faults.told
        return self.models

    def _resolve(self, name: str, way: set[str]) -> Pose:
        frame = self.frames[name]
        if frame.place is not None:
            return frame.place
        if name in way:
            self.fault(frame.span, f"`{name}` hangs on itself")
            frame.place = IDENTITY
            return IDENTITY
        way.add(name)
        parent = IDENTITY if frame.parent is None else self._resolve(frame.parent, way)
        absolute, key = "X" in frame.given, "pose" if "pose" in frame.given else "Q"
        own = compose(inverse(parent), self._pose(frame, "X")) if absolute else self._pose(frame, key)
        frame.origin = self._pose(frame, "pre")
        kind = self._kind(frame)
        if kind in MOVES and "q" in frame.given:
            own = self._motion(kind, self.numbers(frame, "q", 1)[0] * self._sign(frame))
        frame.place = compose(parent, compose(frame.origin, own))
        return frame.place

    def _motion(self, kind: str, value: float) -> Pose:
        turn, (x, y, z) = MOVES[kind]
        if turn == "revolute":
            return make((0.0, 0.0, 0.0), about((x, y, z), value))
        return make((value * x, value * y, value * z), STRAIGHT)

    def _kind(self, frame: RaiFrame) -> str:
        given = frame.given.get("joint")
        return "none" if given is None else str(given.value)

    def _moves(self, frame: RaiFrame) -> bool:
        kind = self._kind(frame)
        if kind in MOVES:
            return frame.parent is not None
        if kind not in ("none", "None", *LOOSE):
            self.leave(frame, f"joint `{frame.name}` is of kind `{kind}`, which has no counterpart, and is held")
            frame.given.pop("joint")
        return False

    def _robot(self, joint: RaiFrame) -> set[str]:
        """The module that a joint belongs to: all that hangs on the frame which carries it."""
        assert joint.parent is not None
        carrier = self.frames[joint.parent]
        own = carrier.parent is not None and self.frames[carrier.parent].parent is not None
        whole = {name for name in self._below(carrier.name)} if own else set()
        moved = [n for n in self._below(joint.name)]
        members = [carrier.name, *(n for n in self.frames if n in (whole or set(moved)) and n != carrier.name)]
        place = carrier.place or IDENTITY
        world = {n: self.frames[n].place or IDENTITY for n in members}
        parts = [self._part(self.frames[n], own or n != carrier.name) for n in members]
        hinges = [h for n in members[1:] for h in self._hinges(self.frames[n], world, parts)]
        name = self.names.fresh(carrier.name if own else joint.name)
        ends = plain_ends(GivenNames(), parts, hinges)
        robot = RobotModel(name, tuple(parts), tuple(hinges), ends, linked(ends))
        self.models.stand(robot, self.names.fresh(f"{name}_1"), place, fixed=True)
        return set(members if own else members[1:])

    def _below(self, name: str) -> Iterator[str]:
        waiting = [name]
        while waiting:
            found = waiting.pop(0)
            yield found
            waiting += self.frames[found].below

    def _hinges(self, frame: RaiFrame, world: dict[str, Pose], parts: list[RobotPart]) -> list[Hinge]:
        assert frame.parent is not None
        own, kind = relative(world, frame.parent, frame.name), self._kind(frame)
        if kind not in MOVES:
            return [Hinge(f"{frame.name}.fixed", "fixed", frame.parent, frame.name, own)]
        turn, axis = MOVES[kind]
        inner = compose(inverse(frame.origin), own)
        if turn == "revolute":
            along = sum(a * b for a, b in zip(axis, inner[3:6], strict=True))
            start = 2 * math.atan2(along, inner[6])
        else:
            start = sum(a * b for a, b in zip(axis, inner[:3], strict=True))
        start = math.remainder(start, 2 * math.pi) if turn == "revolute" else start
        origin = compose(own, inverse(self._motion(kind, start)))
        if any(abs(a - b) > 1e-9 for a, b in zip(origin[:3], frame.origin[:3], strict=True)):
            message = f"joint `{frame.name}` is off its parent by its `Q`, which rai drops when it moves: use `pre`"
            self.leave(frame, message)
        lower, upper = -math.inf, math.inf
        if "limits" in frame.given:
            values = self.numbers(frame, "limits", 2, more=True)
            lower, upper = values[0], values[1]
        if lower >= upper:  # rai takes empty limits for none
            lower, upper = -math.inf, math.inf
        if math.isinf(lower):
            if turn == "prismatic":
                self.leave(frame, f"joint `{frame.name}` has no limits: it moves {FAR:g} m each way")
            lower, upper = (0.0, 0.0) if turn == "revolute" else (-FAR, FAR)
            turn = "continuous" if turn == "revolute" else turn
        leader, sign = self._leader(frame, world), self._sign(frame)
        axis = (sign * axis[0], sign * axis[1], sign * axis[2])
        return [Hinge(frame.name, turn, frame.parent, frame.name, origin, axis, lower, upper, leader=leader)]

    def _sign(self, frame: RaiFrame) -> float:
        """1, or -1 for a joint whose `joint_scale` turns it round."""
        if "joint_scale" not in frame.given:
            return 1.0
        scale = self.numbers(frame, "joint_scale", 1)[0]
        if abs(scale) != 1.0:
            self.fault(frame.span, f"`joint_scale` of `{frame.name}` is {scale:g}: only 1 and -1 are known", "E0020")
        return math.copysign(1.0, scale)

    def _leader(self, frame: RaiFrame, world: dict[str, Pose]) -> tuple[str, float, float] | None:
        """The joint that a `mimic` follows one to one, where its module has it."""
        if "mimic" not in frame.given:
            return None
        wanted = str(frame.given["mimic"].value)
        prefixes = [frame.name[:k] for k in range(len(frame.name) + 1)]
        known = next((p + wanted for p in prefixes if p + wanted in world and p + wanted != frame.name), None)
        if known is None or self._kind(self.frames[known]) not in MOVES:
            self.leave(frame, f"joint `{frame.name}` follows `{wanted}`, which its module lacks: it moves by itself")
            return None
        return known, 1.0, 0.0

    def _part(self, frame: RaiFrame, formed: bool) -> RobotPart:
        forms = tuple(self.shapes.forms(frame)) if formed else ()
        mass = self.numbers(frame, "mass", 1)[0] if "mass" in frame.given and formed else 0.0
        return RobotPart(frame.name, forms, self._weight(frame, mass) if mass > 0 else None)

    def _weight(self, frame: RaiFrame, mass: float) -> PartWeight:
        """A mass with its centre, `com`, and its moments, `inertia`: three, or six in rows."""
        x, y, z = self.numbers(frame, "com", 3) if "com" in frame.given else (0.0, 0.0, 0.0)
        given = frame.given.get("inertia")
        many = 6 if given is not None and len(given.numbers()) == 6 else 3
        values = self.numbers(frame, "inertia", many) if given is not None else (0.0,) * 3
        a, b, c, d, e, f = values if many == 6 else (values[0], 0.0, 0.0, values[1], 0.0, values[2])
        return PartWeight(mass, make((x, y, z), STRAIGHT), (a, b, c, d, e, f))

    def _bodies(self, taken: set[str]) -> None:
        """The bodies of frames that belong to no module: what hangs together on a loose frame is one."""
        for frame in self.frames.values():
            if frame.name in taken:
                continue
            loose, members = self._loose(frame), [frame]
            if loose is not None:
                taken |= {n for n in self._below(loose.name) if self._loose(self.frames[n]) is loose} - taken
                members = [self.frames[n] for n in self._below(loose.name) if self._loose(self.frames[n]) is loose]
            forms = [
                Form(f.kind, f.size, compose(member.place or IDENTITY, f.place))
                for member in members
                for f in self.shapes.forms(member)
            ]
            if not forms:
                continue
            if loose is None:
                self.models.things += [Thing("base", self.names.fresh(frame.name), (form,)) for form in forms]
                continue
            name = self.names.fresh(loose.name)
            mass = sum(self.numbers(m, "mass", 1)[0] for m in members if "mass" in m.given)
            self.models.things.append(Thing("object", name, tuple(forms), mass))
            self.models.facts.append(f"(grippable {name})")

    def _loose(self, frame: RaiFrame) -> RaiFrame | None:
        """The nearest frame up from one, itself among them, that hangs loose on its parent."""
        above: RaiFrame | None = frame
        while above is not None and (above.parent is None or self._kind(above) not in LOOSE):
            above = None if above.parent is None else self.frames[above.parent]
        return above

    def numbers(self, frame: RaiFrame, key: str, count: int, more: bool = False) -> tuple[float, ...]:
        """`count` finite numbers of an attribute, or `more`; ones, and a fault, where it is something else."""
        given = frame.given.get(key)
        values = () if given is None else given.numbers()
        if len(values) < count or (len(values) > count and not more) or not all(map(math.isfinite, values)):
            self.fault(frame.span, f"`{key}` of `{frame.name}` is not {count} finite number{'s' * (count > 1)}")
            return (1.0,) * count
        return values

    def _pose(self, frame: RaiFrame, key: str) -> Pose:
        given = frame.given.get(key)
        if given is None:
            return IDENTITY
        try:
            return given.pose()
        except ValueError as reason:
            self.fault(given.span, f"`{key}` of `{frame.name}` is no pose: {reason}", "E0019")
            return IDENTITY

    def leave(self, frame: RaiFrame, message: str) -> None:
        """Tell what of a frame is left out or becomes something else."""
        self.faults.note(frame.span, message)

    def fault(self, span: Span, message: str, code: str = "E0022") -> None:
        """What keeps the scene from being read."""
        self.faults.add(code, span, message)
