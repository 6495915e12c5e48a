"""Models and worlds of SDF: models with joints that move become modules, all others bodies.

Poses are relative to the model, or to what `relative_to` names; a joint lies at its child's frame unless it says
otherwise; an axis is given in the frame of its joint (before SDF 1.5 of its model), or of what `expressed_in` names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from ...langs.source import Source
from ..ir import IDENTITY, Pose, Vec3
from ..poses import compose, inverse, orientation, rotate, unit
from .models import (
    FAR,
    Form,
    Hinge,
    Models,
    PartWeight,
    RobotModel,
    RobotPart,
    Thing,
    linked,
    plain_ends,
)
from .names import STANDARD, GivenNames
from .sdf_includes import MODEL_FRAME, SdfIncludes
from .sdf_shapes import SdfShapes, pose_of
from .xml_trees import Element, XmlFaults

SPOKEN = 1e15
"""From here on a limit stands for none: files say 1e16."""
SILENT = frozenset(("light", "physics", "scene", "gui", "gravity", "magnetic_field", "atmosphere", "wind", "audio"))
KNOWN = frozenset((
    "pose", "link", "joint", "frame", "static", "model", "self_collide", "allow_auto_disable", "enable_wind",
))  # fmt: skip
KINDS = {"revolute": "revolute", "continuous": "continuous", "prismatic": "prismatic", "fixed": "fixed"}


@dataclass(slots=True)
class _Frame:
    """A frame of a model: the element, its own pose, what that is relative to, and what it is called there."""

    element: Element
    relative: str
    pose: Pose
    place: Pose | None = None
    open: bool = False


@dataclass(slots=True)
class _Model:
    """A model with those nested in it, whose names have `OTHER::` in front."""

    element: Element
    links: dict[str, Element] = field(default_factory=dict)
    joints: dict[str, Element] = field(default_factory=dict)
    frames: dict[str, _Frame] = field(default_factory=dict)
    scopes: dict[str, str] = field(default_factory=dict)


def import_sdf(source: Source) -> Models:
    """The modules and bodies of a file. Raises SourceError."""
    return _SdfReading(XmlFaults(source)).all()


class _SdfReading:
    def __init__(self, faults: XmlFaults) -> None:
        self.faults, self.models, self.names = faults, Models(), GivenNames(STANDARD)
        self.shapes = SdfShapes(faults)

    def all(self) -> Models:
        root = self.faults.root()
        if root.tag not in ("sdf", "gazebo"):
            self.faults.fault(root, f"an SDF file is one `sdf`, not `{root.tag}`", code="E0019")
        SdfIncludes(self.faults).put_in(root)
        for element in root:
            if element.tag == "world":
                for inner in element:
                    self._top(inner)
            else:
                self._top(element)
        self.faults.end()
        self.models.told += sorted(self.faults.told, key=lambda d: d.span.start if d.span is not None else 0)
        return self.models

    def _top(self, element: Element) -> None:
        if element.tag == "model":
            self._model(element)
        elif element.tag not in SILENT:
            self.faults.leave(element, f"`{element.tag}` is left out")

    def _model(self, element: Element) -> None:
        model = _Model(element)
        self._collect(model, element, "")
        place = pose_of(self.faults, element.find("pose"))
        if place is None or self.faults.found:
            return
        for name in model.frames:
            self._resolve(model, name)
        if self.faults.found:
            return
        static = (element.findtext("static") or "").strip() in ("true", "1")
        moving = any(j.get("type") != "fixed" for j in model.joints.values())
        if static or not moving:
            self._things(model, place, static)
        elif self._check_tree(model):
            self._robot(model, place)

    def _collect(self, model: _Model, element: Element, scope: str) -> None:
        """All links, joints and frames of a model and of those nested in it."""
        for child in sorted(element, key=lambda e: e.tag == "joint"):
            name = scope + child.get("name", "")
            if child.tag == "joint" and name in model.frames and name not in model.joints:
                told = f"joint `{name}` is called as another part is, and becomes `{name}_joint`"
                self.faults.leave(child, told)
                name += "_joint"
            if child.tag in ("link", "joint", "frame", "model"):
                if not child.get("name") or '"' in name:
                    self.faults.fault(child, f"a `{child.tag}` has no name, or one with quotes in it")
                elif name in model.frames:
                    self.faults.fault(child, f"`{name}` is declared twice")
                self._frame(model, child, name, scope)
            if child.tag == "link":
                model.links.setdefault(name, child)
            elif child.tag == "joint":
                model.joints.setdefault(name, child)
                model.scopes[name] = scope
            elif child.tag == "model":
                self._collect(model, child, f"{name}::")
            elif child.tag not in KNOWN:
                self.faults.leave(child, f"`{child.tag}` of model `{element.get('name', '')}` is left out")

    def _frame(self, model: _Model, child: Element, name: str, scope: str) -> None:
        pose = child.find("pose")
        relative = "" if pose is None else pose.get("relative_to", "")
        if not relative and child.tag == "joint":
            relative = (child.findtext("child") or "").strip()
        if not relative and child.tag == "frame":
            relative = child.get("attached_to", "")
        within = _frame_of(scope, relative) if relative else ""
        found = pose_of(self.faults, pose)
        if found is not None:
            model.frames[name] = _Frame(child, within or scope.removesuffix("::"), found)

    def _resolve(self, model: _Model, name: str) -> Pose:
        """Where a frame is in the model's own."""
        if name == "":
            return IDENTITY
        frame = model.frames.get(name)
        if frame is None:
            return IDENTITY
        if frame.place is None:
            if frame.open:
                self.faults.fault(frame.element, f"the place of `{name}` is given by itself")
                return IDENTITY
            frame.open = True
            if frame.relative and frame.relative not in model.frames:
                message = f"the pose of `{name}` is relative to `{frame.relative}`, which is not there"
                self.faults.fault(frame.element, message)
            frame.place = compose(self._resolve(model, frame.relative), frame.pose)
        return frame.place

    def _end(self, model: _Model, name: str, end: str) -> str:
        """The link that an end of a joint names, or on which the frame or model that it names lies; the name where
        there is none."""
        scope, told = model.scopes[name], (model.joints[name].findtext(end) or "").strip()
        if told == "world":
            return scope + "world"
        now, way = _frame_of(scope, told), set[str]()
        while now not in model.links and now not in way and now in model.frames:
            way.add(now)
            element = model.frames[now].element
            if element.tag == "model":
                now = next((link for link in model.links if link.startswith(f"{now}::")), now)
            else:
                within = now.rpartition("::")[0]
                key = element.get("attached_to") if element.tag == "frame" else element.findtext("child")
                now = _frame_of(f"{within}::" if within else "", (key or "").strip()) if key else within
        return now if now in model.links else scope + told

    def _check_tree(self, model: _Model) -> bool:
        """Whether links hang on each other as a tree; what closes a loop is left out."""
        above: dict[str, str] = {}
        for name, joint in list(model.joints.items()):
            scope = model.scopes[name]
            ends = [self._end(model, name, end) for end in ("parent", "child")]
            for end in ends:
                if end not in model.links and end != f"{scope}world":
                    self.faults.fault(joint, f"joint `{name}` names the link `{end}`, which is not there")
            if ends[1] in above:
                self.faults.leave(joint, f"joint `{name}` closes a loop, and is left out")
                del model.joints[name]
                continue
            way = ends[0]
            while way in above and way != ends[1]:
                way = above[way]
            if way == ends[1]:
                self.faults.fault(joint, f"link `{ends[1]}` hangs on itself")
            above[ends[1]] = ends[0]
        return not self.faults.found

    def _robot(self, model: _Model, place: Pose) -> None:
        names, given = GivenNames(), model.element.get("name", "robot")
        places = {name: self._resolve(model, name) for name in model.links}
        hangs: dict[str, tuple[str, str]] = {}
        for name in model.joints:
            parent, child = (self._end(model, name, end) for end in ("parent", "child"))
            hangs[child] = (name, parent if parent in model.links else "world")
        roots = [n for n in model.links if n not in hangs]
        grounded = any(p == "world" for _, p in hangs.values())
        tops = [*(["world"] if grounded else []), *roots]
        for top in tops:
            reached = [top]
            for link in reached:
                reached += [c for c, (_, p) in hangs.items() if p == link]
            base = IDENTITY if top == "world" else places[top]
            parts: list[RobotPart] = []
            hinges: list[Hinge] = []
            frames = {top: base}
            for link in reached:
                if link != top:
                    self._hinge(model, hangs[link], link, frames, places, parts, hinges)
                else:
                    frames[link] = base
                if link == "world":
                    parts.append(RobotPart("world"))
                else:
                    parts.append(self._part(model, link, compose(inverse(frames[link]), places[link])))
            if len(tops) > 1 and not hinges:
                self._things_of(model, [top], place, "base")
                continue
            name = self.names.fresh(given)
            ends = plain_ends(names, parts, hinges)
            robot = RobotModel(name, tuple(parts), tuple(hinges), ends, linked(ends))
            self.models.stand(robot, self.names.fresh(f"{name}_1"), compose(place, base), fixed=top == "world")

    def _hinge(
        self, model: _Model, hang: tuple[str, str], link: str, frames: dict[str, Pose], places: dict[str, Pose],
        parts: list[RobotPart], hinges: list[Hinge],
    ) -> None:  # fmt: skip
        """The joint above a link, whose frame in the URDF is that of the link; a frame between lies at the joint."""
        name, parent = hang
        joint = model.joints[name]
        kind = joint.get("type", "")
        at = self._resolve(model, name)
        frames[link] = places[link]
        up = inverse(frames[parent])
        if kind not in KINDS:
            if kind == "ball":
                self.faults.leave(joint, f"joint `{name}` is a ball, and becomes three joints, yaw, pitch and roll")
                self._three(name, parent, link, compose(up, at), compose(inverse(at), places[link]), parts, hinges)
                return
            self.faults.leave(joint, f"joint `{name}` is of type `{kind}`, which has no counterpart, and is held")
            kind = "fixed"
        if kind == "fixed":
            hinges.append(Hinge(name, "fixed", parent, link, compose(up, places[link])))
            return
        axis = self._axis(model, joint, name, at)
        if axis is None:
            return
        lower, upper, speed, effort, kind = self._limits(joint, name, kind)
        middle = f"{link}_{name}"
        parts.append(RobotPart(middle))
        leader = self._mimic(model, joint, name)
        hinges.append(Hinge(name, kind, parent, middle, compose(up, at), axis, lower, upper, speed, effort, leader))
        hinges.append(Hinge(f"{name}_to_{link}", "fixed", middle, link, compose(inverse(at), places[link])))

    def _three(
        self, name: str, parent: str, link: str, first: Pose, last: Pose, parts: list[RobotPart], hinges: list[Hinge]
    ) -> None:
        for word, axis in zip(("yaw", "pitch", "roll"), ((0, 0, 1.0), (0, 1.0, 0), (1.0, 0, 0)), strict=True):
            below = f"{link}_{name}.{word}"
            parts.append(RobotPart(below))
            hinges.append(Hinge(f"{name}.{word}", "revolute", parent, below, first, axis, -math.pi, math.pi))
            parent, first = below, IDENTITY
        hinges.append(Hinge(f"{name}_to_{link}", "fixed", parent, link, last))

    def _axis(self, model: _Model, joint: Element, name: str, at: Pose) -> Vec3 | None:
        given = joint.find("axis/xyz")
        values = self.faults.numbers(joint, "0 0 1" if given is None else given.text, 3, f"the axis of `{name}`")
        axis = None if values is None else unit((values[0], values[1], values[2]))
        if values is not None and axis is None:
            self.faults.fault(joint, f"the axis of joint `{name}` is the zero vector")
        if axis is None or given is None:
            return axis
        old = (joint.findtext(f"axis/{MODEL_FRAME}") or "").strip() in ("true", "1")
        frame = "__model__" if old else given.get("expressed_in", "")
        if not frame:
            return axis
        scope = model.scopes[name]
        known = _frame_of(scope, frame)
        if known and known not in model.frames:
            self.faults.fault(given, f"the axis of joint `{name}` is expressed in `{frame}`, which is not there")
            return None
        turned = rotate(orientation(self._resolve(model, known)), axis)
        return rotate(orientation(inverse(at)), turned)

    def _limits(self, joint: Element, name: str, kind: str) -> tuple[float, float, float, float, str]:
        def value(key: str, default: float) -> float:
            text = joint.findtext(f"axis/limit/{key}")
            if text is None:
                return default
            try:
                return float(text)
            except ValueError:
                shown = f"`{key}` of joint `{name}` is not a number: `{text.strip()[:40]}`"
                self.faults.fault(joint, shown, code="E0019")
                return default

        lower, upper = value("lower", -math.inf), value("upper", math.inf)
        speed, effort = (v if 0 < v < SPOKEN else 0.0 for v in (value("velocity", 0.0), value("effort", 0.0)))
        if kind == "revolute" and (lower < -SPOKEN or upper > SPOKEN):
            return 0.0, 0.0, speed, effort, "continuous"
        if kind == "prismatic" and (lower < -SPOKEN or upper > SPOKEN):
            self.faults.leave(joint, f"joint `{name}` has no limits: it moves {FAR:g} m each way")
            lower, upper = max(lower, -FAR), min(upper, FAR)
        if lower > upper or math.isnan(lower) or math.isnan(upper):
            self.faults.fault(joint, f"the limits of joint `{name}` are empty: {lower:g} .. {upper:g}")
        return lower, upper, speed, effort, kind

    def _mimic(self, model: _Model, joint: Element, name: str) -> tuple[str, float, float] | None:
        mimic = joint.find("axis/mimic")
        if mimic is None:
            return None
        leader = model.scopes[name] + mimic.get("joint", "")
        if leader not in model.joints:
            self.faults.fault(mimic, f"joint `{name}` follows `{leader}`, which is not there")
            return None
        found = []
        for key, default in (("multiplier", "1"), ("offset", "0"), ("reference", "0")):
            values = self.faults.numbers(mimic, mimic.findtext(key) or default, 1, f"`{key}` of `{name}`")
            found.append(0.0 if values is None else values[0])
        return leader, found[0], found[1] - found[0] * found[2]

    def _part(self, model: _Model, link: str, shift: Pose) -> RobotPart:
        element = model.links[link]
        forms = tuple(Form(f.kind, f.size, compose(shift, f.place)) for f in self._forms(model, link))
        return RobotPart(link, forms, self._weight(element, shift))

    def _weight(self, link: Element, shift: Pose) -> PartWeight | None:
        element = link.find("inertial")
        if element is None or element.find("mass") is None:
            return None
        mass = self.faults.numbers(element, element.findtext("mass"), 1, "`mass`")
        place = pose_of(self.faults, element.find("pose"))
        moments = [
            self.faults.numbers(element, element.findtext(f"inertia/{key}") or default, 1, f"`{key}`")
            for key, default in zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "100101", strict=True)
        ]
        if mass is None or place is None or mass[0] <= 0:
            return None
        a, b, c, d, e, f = (0.0 if m is None else m[0] for m in moments)
        return PartWeight(mass[0], compose(shift, place), (a, b, c, d, e, f))

    def _things(self, model: _Model, place: Pose, static: bool) -> None:
        self._things_of(model, list(model.links), place, "base" if static else "object")

    def _things_of(self, model: _Model, links: Sequence[str], place: Pose, kind: str) -> None:
        """Bodies of links; what moves freely is one body of all its shapes."""
        found = [
            Form(f.kind, f.size, compose(place, compose(self._resolve(model, n), f.place)))
            for n in links
            for f in self._forms(model, n)
        ]
        name = model.element.get("name", "body")
        if kind == "base":
            self.models.things += [Thing(kind, self.names.fresh(name), (form,)) for form in found]
        elif found:
            weights = [self._weight(model.links[link], IDENTITY) for link in links]
            fresh = self.names.fresh(name)
            mass = sum(weight.mass for weight in weights if weight is not None)
            self.models.things.append(Thing(kind, fresh, tuple(found), mass))
            self.models.facts.append(f"(grippable {fresh})")

    def _forms(self, model: _Model, link: str) -> list[Form]:
        """The shapes of a link in its frame."""
        scope = link.rpartition("::")[0]

        def frame(name: str) -> Pose | None:
            known = _frame_of(f"{scope}::" if scope else "", name)
            if known and known not in model.frames:
                return None
            return compose(inverse(self._resolve(model, link)), self._resolve(model, known))

        return self.shapes.forms(model.links[link], frame)


def _frame_of(scope: str, name: str) -> str:
    """What a frame named in the model `scope` is called in the outermost one, which itself is nothing."""
    return scope.removesuffix("::") if name == "__model__" else scope + name.removesuffix("::__model__")
