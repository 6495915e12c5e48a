"""Module types from URDF texts: Pinocchio reads the tree of joints and links, the collision shapes come from the text.

The module frame is the root link. Fixed joints vanish into the links that they join.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from ...langs import syntax
from ...langs.source import Source
from .. import ir
from ..checks.context import Context
from ..physics.masses import shape_volume
from ..physics.statements import Stated as Weights
from ..physics.urdf_inertials import UnfitInertia, read_inertials
from ..poses import Quaternion, compose, make, unit
from ..urdf_files import FIRST_WITH_QUATERNIONS, quaternions_count, three, turned
from ..xml_texts import XmlError, read_xml
from .couplings import BadCoupling, Stated, couple
from .joints import DEFAULT_ACCELERATION, DEFAULT_SPEED

if TYPE_CHECKING:
    import pinocchio

KINDS = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}


@dataclass(frozen=True, slots=True)
class End:
    """An effector of the declaration: its type, its place in the frame of the link, and its shape, if given."""

    item: syntax.EffectorItem
    type: str
    place: ir.Pose
    shape: ir.Shape | None
    said: Weights


class _Unfit(Exception):
    """The URDF cannot be a module; the message says why."""

    def __init__(self, code: str, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.code, self.help = code, help


def build_urdf(
    context: Context, module: syntax.ModuleDecl, source: Source, ends: Sequence[End], name: str
) -> ir.ModuleType | None:
    """The module type of a URDF text with the effectors `ends`; None after reporting what is unfit."""
    assert module.urdf is not None
    try:
        robot = _read(source)
        model = _model(robot)
        joints = _coupled(robot, _joints(robot, model))
        frames = _link_frames(model)
        inertials = read_inertials(robot, frames)
        newer, drawn = quaternions_count(robot), robot.findall("link")
        found = [s for link in drawn for s in _shapes(link, frames, newer, link.get("name", "") in inertials)]
    except (_Unfit, UnfitInertia) as mistake:
        context.findings.report(mistake.code, module.urdf.span, f"{source.path}: {mistake}", help=mistake.help)
        return None
    links = [s for s in found if isinstance(s, _LinkShape)]
    _warn(context, module, robot, [s for s in found if isinstance(s, str)])
    placed = [_effector(context, end, frames, links) for end in ends]
    taken = [p[1] for p in placed if p is not None]
    kept = tuple(s.link for s in links if s not in taken)
    weights = tuple(inertials.values())
    effectors = tuple(p[0] for p in placed if p is not None)
    return ir.ModuleType(name, joints, effectors, kept, weights) if len(effectors) == len(ends) else None


def _warn(context: Context, module: syntax.ModuleDecl, robot: ElementTree.Element, bodiless: Sequence[str]) -> None:
    """What is not read as it may have been meant."""
    where = context.findings.word(module.span, module.name)
    told = [f"{s} has no volume and is left out" for s in bodiless]
    if not quaternions_count(robot) and any(e.get("quat_xyzw") for e in robot.iter("origin")):
        version = robot.get("version", "1.0")
        told.append(f'`quat_xyzw` does not count in version {version} of URDF, only in `<robot version="1.1">`')
    if told:
        context.findings.report("W0010", where, "; ".join(told))


# --- the text ------------------------------------------------------------------------------------------------------


def _read(source: Source) -> ElementTree.Element:
    """The checked text: one tree of links by joints of known kinds, with limits."""
    try:
        robot = read_xml(source.text)
    except XmlError as error:
        raise _Unfit("E0513", str(error)) from None
    if robot.tag != "robot":
        raise _Unfit("E0513", f"a URDF is one `robot`, not `{robot.tag}`")
    links = [e.get("name", "") for e in robot.findall("link")]
    joints = robot.findall("joint")
    names = [*links, *(j.get("name", "") for j in joints)]
    for kind, listed in (("link", links), ("joint", names[len(links) :])):
        twice = next((n for n in listed if listed.count(n) > 1), None)
        if twice is not None:
            raise _Unfit("E0514", f"two {kind}s are named `{twice}`")
    children = [_check_joint(j, links, quaternions_count(robot)) for j in joints]
    roots = [n for n in links if n not in children]
    twice = next((n for n in children if children.count(n) > 1), None)
    if twice is not None:
        raise _Unfit("E0514", f"link `{twice}` hangs on two joints")
    if len(roots) != 1:
        listing = ", ".join(f"`{r}`" for r in roots) or "none"
        raise _Unfit("E0514", f"a module has one root link, here there are {len(roots)}: {listing}")
    return robot


def _check_joint(joint: ElementTree.Element, links: Sequence[str], newer: bool) -> str:
    """The child link of a joint, which must be of a known kind, with fitting limits."""
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind not in KINDS:
        raise _Unfit("E0514", f"joint `{name}` is of type `{kind}`", "joints are " + ", ".join(KINDS))
    for end in ("parent", "child"):
        element = joint.find(end)
        link = "" if element is None else element.get("link", "")
        if link not in links:
            raise _Unfit("E0514", f"joint `{name}` has no {end} link `{link}`")
    _three(joint.find("origin"), "xyz")
    _turn(joint.find("origin"), newer)
    axis = joint.find("axis")
    if kind != "fixed" and axis is not None and unit(_three(axis, "xyz")) is None:
        raise _Unfit("E0514", f"the axis of joint `{name}` is zero")
    if KINDS[kind] == "prismatic" or kind == "revolute":
        limit = joint.find("limit")
        if limit is None or not _number(limit, "lower", "0") < _number(limit, "upper", "0"):
            raise _Unfit("E0514", f"joint `{name}` lacks limits with lower < upper")
    return link


def _number(element: ElementTree.Element, name: str, default: str | None = None) -> float:
    text = element.get(name, default)
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _Unfit("E0514", f"`{name}` of a `{element.tag}` is not a number: {text}")
    return value


def _three(element: ElementTree.Element | None, name: str) -> ir.Vec3:
    try:
        found = three(element, name)
    except ValueError:
        found = (math.nan,) * 3
    if not all(map(math.isfinite, found)):
        raise _Unfit("E0514", f"`{name}` of an `origin`, `axis` or `box` is not three numbers")
    return found


def _turn(origin: ElementTree.Element | None, newer: bool) -> Quaternion:
    try:
        found = turned(origin, newer)
    except ValueError as error:
        raise _Unfit("E0514", f"an `origin` is turned by what is no rotation: {error}") from None
    return found


# --- kinematics ----------------------------------------------------------------------------------------------------


def _model(robot: ElementTree.Element) -> pinocchio.Model:
    """Pinocchio's model of the tree; what only draws or weighs is left out."""
    import pinocchio

    bare = ElementTree.Element("robot", name=robot.get("name", "robot"))
    if quaternions_count(robot):
        bare.set("version", FIRST_WITH_QUATERNIONS)
    for element in robot:
        if element.tag == "link":
            bare.append(ElementTree.Element("link", name=element.get("name", "")))
        elif element.tag == "joint":
            bare.append(deepcopy(element))
    for joint in bare.iter("joint"):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
        for limit in joint.iter("limit"):
            limit.attrib = {"effort": "1", "velocity": "0", **limit.attrib}
    try:
        return pinocchio.buildModelFromXML(ElementTree.tostring(bare, encoding="unicode"))
    except (ValueError, RuntimeError) as error:
        raise _Unfit("E0514", f"Pinocchio refuses it: {error}") from None


def _pose(placement: pinocchio.SE3) -> ir.Pose:
    import pinocchio

    x, y, z, qx, qy, qz, qw = (float(v) for v in pinocchio.SE3ToXYZQUAT(placement))
    return x, y, z, qx, qy, qz, qw


def _link_frames(model: pinocchio.Model) -> dict[str, tuple[int, ir.Pose]]:
    """The joint that carries each link, -1 for the root, and the link's frame on it."""
    import pinocchio

    body = pinocchio.FrameType.BODY
    return {f.name: (int(f.parentJoint) - 1, _pose(f.placement)) for f in model.frames if f.type == body}


def _joints(robot: ElementTree.Element, model: pinocchio.Model) -> tuple[ir.Joint, ...]:
    declared = {j.get("name", ""): j for j in robot.findall("joint")}
    made = []
    for index in range(1, model.njoints):
        element = declared[model.names[index]]
        kind = KINDS[element.get("type", "")]
        limit = element.find("limit")
        lower, upper = -2 * math.pi, 2 * math.pi
        if element.get("type") != "continuous" and limit is not None:
            lower, upper = _number(limit, "lower", "0"), _number(limit, "upper", "0")
        speed = 0.0 if limit is None else _number(limit, "velocity", "0")
        acceleration = 0.0 if limit is None else _number(limit, "acceleration", "0")
        effort = 0.0 if limit is None else _number(limit, "effort", "0")
        axis = element.find("axis")
        made.append(
            ir.Joint(
                model.names[index],
                kind,
                int(model.parents[index]) - 1,
                _pose(model.jointPlacements[index]),
                (1.0, 0.0, 0.0) if axis is None else unit(_three(axis, "xyz")) or (1.0, 0.0, 0.0),
                lower,
                upper,
                0.0 if lower <= 0 <= upper else (lower + upper) / 2,
                speed if speed > 0 else DEFAULT_SPEED[kind],
                acceleration if acceleration > 0 else DEFAULT_ACCELERATION[kind],
                torque=effort if effort > 0 else math.inf,
            )
        )
    return tuple(made)


def _coupled(robot: ElementTree.Element, joints: tuple[ir.Joint, ...]) -> tuple[ir.Joint, ...]:
    """The joints with those that `mimic` others; where 0 is outside what followers leave a joint, it starts in the
    middle of that."""
    stated, kinds = {}, {j.get("name", ""): j.get("type") for j in robot.findall("joint")}
    for element in robot.findall("joint"):
        name, mimic = element.get("name", ""), element.find("mimic")
        if mimic is None or kinds[name] == "fixed":
            continue
        leader, factor = mimic.get("joint", ""), _number(mimic, "multiplier", "1")
        if leader not in kinds or kinds[leader] == "fixed":
            what = "there is no such joint" if leader not in kinds else "which is fixed"
            raise _Unfit("E0521", f"joint `{name}` follows `{leader}` by `mimic`: {what}", "give it the type fixed")
        if factor == 0:
            raise _Unfit("E0521", f"joint `{name}` follows `{leader}` 0 times", "give it the type fixed")
        stated[name] = Stated(leader, factor, _number(mimic, "offset", "0"))
    try:
        made = couple(joints, stated)
        homes = [j if j.lower <= j.home <= j.upper else replace(j, home=(j.lower + j.upper) / 2) for j in made]
        return couple([h if j.follows is None else j for h, j in zip(homes, made, strict=True)], {})
    except BadCoupling as mistake:
        raise _Unfit("E0521", str(mistake), mistake.help) from None


# --- shapes --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _LinkShape:
    """A collision shape of the link `name`."""

    name: str
    link: ir.Link


def _shapes(
    link: ElementTree.Element, frames: Mapping[str, tuple[int, ir.Pose]], newer: bool, weighed: bool
) -> Iterator[_LinkShape | str]:
    """The collision shapes of a link; of those without a body, such as a box without height, what they are. Those of a
    link that is `weighed` by its inertial have no weight of their own."""
    name = link.get("name", "")
    joint, frame = frames[name]
    for collision in link.findall("collision"):
        place = make(_three(collision.find("origin"), "xyz"), _turn(collision.find("origin"), newer))
        geometry = collision.find("geometry")
        forms = [] if geometry is None else list(geometry)
        if len(forms) != 1:
            raise _Unfit("E0514", f"a collision element of link `{name}` has no shape")
        shape = _shape(name, forms[0])
        if shape.kind != "convex" and min(shape.size) == 0:
            yield f"the {shape.kind} of link `{name}`"
        else:
            yield _LinkShape(name, ir.Link(joint, compose(frame, place), shape, 0.0 if weighed else None))


def _shape(link: str, form: ElementTree.Element) -> ir.Shape:
    if form.tag == "convex":
        return ir.Shape("convex", tuple(map(float, form.get("points", "").split())))
    if form.tag == "box":
        size: tuple[float, ...] = _three(form, "size")
    elif form.tag in ("sphere", "capsule", "cylinder"):
        size = tuple(_number(form, n) for n in ("radius", "length")[: 1 if form.tag == "sphere" else 2])
    elif form.tag == "mesh":
        raise _Unfit("E0515", f"the mesh of link `{link}` was not found")
    else:
        raise _Unfit("E0514", f"link `{link}` has a collision shape `{form.tag}`")
    if min(size) < 0:
        raise _Unfit("E0514", f"the {form.tag} of link `{link}` has a size of {min(size):g} m")
    return ir.Shape(form.tag, size)


def _effector(
    context: Context, end: End, frames: Mapping[str, tuple[int, ir.Pose]], shapes: Sequence[_LinkShape]
) -> tuple[ir.Effector, _LinkShape | None] | None:
    """The effector, and the shape of its link that it takes over where it has none of its own."""
    link = end.item.link
    assert link is not None
    if link.value not in frames:
        context.findings.unknown("E0117", "link", link.value, link.span, frames)
        return None
    joint, frame = frames[link.value]
    own = ir.Effector(
        end.item.name, end.type, joint, compose(frame, end.place), end.shape, end.said.mass, end.said.holds
    )
    if end.shape is not None:
        return replace(own, mass=end.said.weight(shape_volume(end.shape))), None
    candidates = [s for s in shapes if s.name == link.value]
    if len(candidates) != 1 or end.item.at is not None or end.item.normal is not None:
        help = f'write `effector {end.item.name}: "{link.value}" sphere(4 cm)`'
        message = f"this effector needs a shape: link `{link.value}` has {len(candidates)} collision shapes"
        if len(candidates) == 1:
            message = "an effector with a place or normal of its own needs a shape of its own"
        context.findings.report("E0509", end.item.span, message, help=help)
        return None
    only = candidates[0]
    mass = end.said.weight(shape_volume(only.link.shape))
    mass = only.link.mass if mass is None else mass
    return replace(own, placement=only.link.placement, shape=only.link.shape, mass=mass), only
