"""The elements of one URDF: links, joints and origins, with all that is wrong in them, told at its place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.etree import ElementTree

from ...langs import syntax
from ...langs.frozen import dataclass
from ...langs.source import Source, Span
from .. import ir
from ..checks.context import Context
from ..checks.values import LONGEST
from ..poses import make, unit
from ..urdf_files import at_least_1_1, three, turned
from ..xml_texts import XmlError, read_xml, span_of

KINDS = ("revolute", "continuous", "prismatic", "planar", "floating", "fixed")
BALL = "spherical"
"""A kind of joints that the standard does not know, and Bullet does."""
OTHERS = {
    "sdf": "this is SDF: save the model as URDF",
    "mujoco": "this is MJCF: save the model as URDF",
    "COLLADA": "this is a COLLADA mesh, which a URDF may name",
}
"""Roots of files that are taken for URDFs."""


MAKE = "have it made by `xacro FILE.xacro > FILE.urdf`"
LANGUAGE = frozenset(f"xacro:{word}" for word in ("macro", "include", "property", "arg", "if", "unless", "element"))
"""Elements of xacro itself; others call its macros."""


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """A joint as the file has it: `origin` is its frame in that of the link `parent`, and `axis` has length 1."""

    name: str
    kind: str
    parent: str
    child: str
    origin: ir.Pose
    axis: ir.Vec3
    element: ElementTree.Element


class Reading:
    """Reads a URDF for the declaration `module`. Faults and warnings are reported where they are met; `sound` is false
    once there was a fault."""

    def __init__(self, context: Context, module: syntax.ModuleDecl, source: Source) -> None:
        self.context, self.module, self.source = context, module, source
        self.sound = True
        self.newer = False

    def fault(
        self, where: ElementTree.Element | Span, message: str, help: str | None = None, code: str = "E0514"
    ) -> None:
        """What keeps the file from being a module."""
        self.sound = False
        self._report(code, where, message, help)

    def warn(self, where: ElementTree.Element, message: str, help: str | None = None) -> None:
        """What is not read as it may have been meant."""
        self._report("W0010", where, message, help)

    def _report(self, code: str, where: ElementTree.Element | Span, message: str, help: str | None) -> None:
        assert self.module.urdf is not None
        span = where if isinstance(where, Span) else span_of(self.source, where)
        labels = [(self.module.urdf.span, "read for this module")]
        self.context.findings.report(code, span, message, help=help, labels=labels)

    def root(self) -> ElementTree.Element | None:
        """The element `robot`; None where the text is none."""
        try:
            robot = read_xml(self.source.text)
        except XmlError as error:
            self.fault(error.span(self.source), str(error), code="E0513")
            return None
        if robot.tag != "robot":
            self.fault(robot, f"a URDF is one `robot`, not `{robot.tag}`", OTHERS.get(robot.tag), "E0513")
            return None
        macro, unfilled = next((e for e in robot.iter() if e.tag.startswith("xacro:")), None), _unfilled(robot)
        if macro is not None and unfilled is None and macro.tag not in LANGUAGE:
            self.warn(macro, f"`{macro.tag}` and its like are left out: they call what xacro did not fill in")
        elif macro is not None:
            self.fault(macro, f"`{macro.tag}`: this is a xacro file, of which a URDF can be made", MAKE, "E0513")
            return None
        self._without_commas(robot)
        self.newer = at_least_1_1(robot)
        turned = [e for e in robot.iter("origin") if e.get("quat_xyzw")]
        if turned and not self.newer:
            version = robot.get("version", "1.0")
            where = '`<robot version="1.1">`'
            self.warn(turned[0], f"`quat_xyzw` does not count in version {version} of URDF, only in {where}")
        return robot

    def _without_commas(self, robot: ElementTree.Element) -> None:
        """Takes commas between three numbers for blanks, as Bullet does."""
        told = False
        for element in robot.iter():
            for name in ("xyz", "rpy", "size"):
                text = element.get(name, "")
                if "," in text and len(text.replace(",", " ").split()) == 3:
                    element.set(name, text.replace(",", " "))
                    if not told:
                        self.warn(element, f"the commas in `{name}` of this `{element.tag}` are taken for blanks")
                    told = True

    def tree(self, robot: ElementTree.Element) -> tuple[dict[str, ElementTree.Element], list[UrdfJoint]]:
        """The links by name, the root first, and the joints, of one tree of links."""
        links = self._named(robot.findall("link"), "link")
        self._add_root(robot, links)
        made = [self._joint(j, links) for j in self._named(robot.findall("joint"), "joint").values()]
        joints = [j for j in made if j is not None]
        above: dict[str, UrdfJoint] = {}
        for joint in joints:
            if joint.child in above:
                self.fault(joint.element, f"link `{joint.child}` hangs on two joints")
            above.setdefault(joint.child, joint)
        roots = [n for n in links if n not in above]
        if len(roots) != 1 and len(made) == len(joints):
            listing = ", ".join(f"`{r}`" for r in roots[:8]) or "none"
            where = links[roots[1]] if len(roots) > 1 else robot
            self.fault(where, f"a module has one root link, here there are {len(roots)}: {listing}")
        elif self.sound:
            self._check_ring(above, links, roots[0])
        return ({name: links[name] for name in dict.fromkeys([*roots, *links])}, joints)

    def _add_root(self, robot: ElementTree.Element, links: dict[str, ElementTree.Element]) -> None:
        """Adds the one link that all others hang on where the file only names it, such as `world`, or the arm of a
        gripper: it is empty. Drake does so for `world`. Where a declared link hangs on none, a name is misspelt."""
        joints = robot.findall("joint")
        parents, children = ([_named_end(joint, end) for joint in joints] for end in ("parent", "child"))
        hanging, missing = set(children), set(parents) - links.keys()
        if len(missing) == 1 and "" not in missing | hanging and links and links.keys() == hanging:
            root = missing.pop()
            told = f"link `{root}` is not declared: it is an empty one, on which all others hang"
            self.warn(joints[parents.index(root)], told)
            links[root] = ElementTree.Element("link", name=root)

    def _check_ring(
        self, above: dict[str, UrdfJoint], links: dict[str, ElementTree.Element], root: str
    ) -> None:
        """Every link hangs on the root, if it hangs on none of those below it."""
        reached = {root}
        for name in links:
            way = [name]
            while way[-1] not in reached and len(way) <= len(links):
                way.append(above[way[-1]].parent)
            if way[-1] not in reached:
                self.fault(links[name], f"link `{name}` hangs on itself")
                return
            reached.update(way)

    def _named(self, elements: Sequence[ElementTree.Element], kind: str) -> dict[str, ElementTree.Element]:
        found: dict[str, ElementTree.Element] = {}
        for element in elements:
            name = element.get("name", "")
            if name in found:
                self.fault(element, f"two {kind}s are named `{name}`")
            found.setdefault(name, element)
        return found

    def _joint(self, element: ElementTree.Element, links: dict[str, ElementTree.Element]) -> UrdfJoint | None:
        name, kind = element.get("name", ""), element.get("type", "")
        if kind == BALL:
            told = f"joint `{name}` is of type `{kind}`, which the standard lacks"
            self.warn(element, f"{told}: it turns any way, as Bullet has it")
        elif kind not in KINDS:
            self.fault(element, f"joint `{name}` is of type `{kind}`", "joints are " + ", ".join(KINDS))
            return None
        ends = [self._end(element, name, end, links) for end in ("parent", "child")]
        axis = self.axis(element, name) if kind not in ("fixed", "floating", BALL) else (1.0, 0.0, 0.0)
        origin = self.place(element)
        if ends[0] is None or ends[1] is None or axis is None or origin is None:
            return None
        return UrdfJoint(name, kind, ends[0], ends[1], origin, axis, element)

    def _end(
        self, joint: ElementTree.Element, name: str, end: str, links: dict[str, ElementTree.Element]
    ) -> str | None:
        element, link = joint.find(end), _named_end(joint, end)
        if link not in links:
            self.fault(joint if element is None else element, f"joint `{name}` has no {end} link `{link}`")
            return None
        return link

    def axis(self, joint: ElementTree.Element, name: str) -> ir.Vec3 | None:
        """The axis of a joint, of length 1; None where it is none."""
        element = joint.find("axis")
        if element is None:
            return 1.0, 0.0, 0.0
        given = self.three(element, "xyz")
        axis = None if given is None else unit(given)
        if given is not None and axis is None:
            self.fault(element, f"the axis of joint `{name}` is zero")
        return axis

    def place(self, element: ElementTree.Element) -> ir.Pose | None:
        """The `origin` of an element; None where it is none."""
        origin = element.find("origin")
        if origin is None:
            return ir.IDENTITY
        at = self.three(origin, "xyz")
        try:
            turn = turned(origin, self.newer)
        except ValueError as error:
            self.fault(origin, f"this `origin` is turned by what is no rotation: {error}")
            return None
        return None if at is None else make(at, turn)

    def three(self, element: ElementTree.Element, name: str) -> ir.Vec3 | None:
        """Three finite numbers of an attribute."""
        try:
            found = three(element, name)
        except ValueError:
            found = (math.nan,) * 3
        if not all(map(math.isfinite, found)):
            self.fault(element, f"`{name}` of this `{element.tag}` is not three numbers", _to_make(element.get(name)))
            return None
        if element.tag != "axis" and max(map(abs, found)) > LONGEST:
            self.fault(element, f"`{name}` of this `{element.tag}` is beyond {LONGEST:g} m")
            return None
        return found

    def number(
        self, element: ElementTree.Element, name: str, default: str | None = None, endless: bool = False
    ) -> float | None:
        """A number of an attribute, finite unless it may be `endless`."""
        text = element.get(name, default)
        try:
            value = float(text or "")
        except ValueError:
            value = math.nan
        if math.isnan(value) or (math.isinf(value) and not endless):
            self.fault(element, f"`{name}` of this `{element.tag}` is not a number: {text}", _to_make(text))
            return None
        return value


def _named_end(joint: ElementTree.Element, end: str) -> str:
    """The link that a joint names at one end; nothing where it names none."""
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _to_make(text: str | None) -> str | None:
    """What to do where xacro has left a value as it was."""
    return MAKE if text is not None and ("${" in text or "$(" in text) else None


def _unfilled(robot: ElementTree.Element) -> ElementTree.Element | None:
    """The first element in which xacro would have to fill in something, or that belongs to its language."""
    for element in robot.iter():
        if element.tag in LANGUAGE or any("${" in value or "$(" in value for value in element.attrib.values()):
            return element
    return None
