"""Module types from URDF texts: the tree of links becomes joints, shapes and effectors.

The module frame is the root link. Fixed joints vanish into the links that they join. Joints stand in the order in which
other readers have them: from the root on, and by name where a link carries several.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from xml.etree import ElementTree

from ...langs import syntax
from ...langs.frozen import dataclass
from ...langs.source import Source
from .. import ir
from ..checks.context import Context
from ..checks.names import Scope
from ..checks.values import LONGEST
from ..physics.masses import shape_volume
from ..physics.statements import StatedPart
from ..physics.urdf_inertials import UnfitInertia, read_inertial
from ..poses import compose, inverse, make, orientation, part_pose, position, rotate
from ..urdf_files import mesh_name
from .covered_links import covers
from .urdf_joints import JointBuilder
from .urdf_mimics import coupled, settled
from .urdf_reading import Reading, UrdfJoint

SIZES = {"sphere": ("radius",), "cylinder": ("radius", "length"), "capsule": ("radius", "length")}
FIRST_WITH_CAPSULES = "1.1"
ALIGNED = 1.0 - 1e-12
"""The last number of a quaternion from which on it turns nothing."""


@dataclass(frozen=True, slots=True)
class End:
    """An effector of the declaration: its type, its place in the frame of the link, and its shape, if given."""

    item: syntax.EffectorItem
    type: str
    place: ir.Pose
    shape: ir.Shape | None
    said: StatedPart


@dataclass(frozen=True, slots=True)
class _LinkShape:
    """A collision shape of the link `name`."""

    name: str
    link: ir.Link


Frames = Mapping[str, tuple[int, ir.Pose]]
"""The joint that carries each link, -1 for the root, and the link's frame on it."""


def build_urdf(
    context: Context, scope: Scope, module: syntax.ModuleDecl, source: Source, ends: Sequence[End], name: str
) -> ir.ModuleType | None:
    """The module type of a URDF text with the effectors `ends`; None after reporting all that is unfit."""
    reading = Reading(context, module, source)
    robot = reading.root()
    if robot is None:
        return None
    links, declared = reading.tree(robot)
    items = {i.name: i for i in module.items if isinstance(i, syntax.JointItem) and i.kind is None}
    declared = settled(reading, declared, [i.name for i in items.values() if i.lower is not None])
    known = [j.name for j in declared]
    for item in items.values():
        if item.name not in known and reading.sound:
            context.findings.unknown("E0117", "joint", item.name, context.findings.word(item.span, item.name), known)
    builder = JointBuilder(context, scope, reading, items)
    free, frames, complete = _kinematics(builder, next(iter(links), ""), declared)
    joints = coupled(reading, free, declared) if complete else None
    found = {n: _inertial(reading, link, frames) for n, link in links.items() if n in frames}
    weights = {n: inertial for n, inertial in found.items() if inertial is not None}
    whole = {end.item.link.value for end in ends if end.shape is None and end.item.link is not None}
    shapes = [s for n in found for s in _shapes(reading, links[n], frames, n in weights, n in whole)]
    if not reading.sound or joints is None:
        return None
    placed = [_effector(context, end, frames, shapes) for end in ends]
    taken = [shape for p in placed if p is not None for shape in p[1]]
    effectors = tuple(p[0] for p in placed if p is not None)
    if len(effectors) < len(ends):
        return None
    ours = [e for e, end in zip(effectors, ends, strict=True) if end.shape is not None]
    kept = tuple(s.link for s in shapes if s not in taken and not _stood_for(reading, ours, s, links))
    return ir.ModuleType(name, joints, effectors, kept, tuple(weights.values()))


def _inertial(reading: Reading, link: ElementTree.Element, frames: Frames) -> ir.Inertial | None:
    """What a link says of its weight."""
    try:
        return read_inertial(link, frames, reading.newer)
    except UnfitInertia as mistake:
        where = link.find("inertial")
        reading.warn(link if where is None else where, f"{mistake}: it is left out", mistake.help)
        return None


def _kinematics(
    builder: JointBuilder, root: str, declared: Sequence[UrdfJoint]
) -> tuple[list[ir.Joint], dict[str, tuple[int, ir.Pose]], bool]:
    """The joints, the frames of the links as far as they hang on the root, and whether nothing lacks. A joint with a
    fault carries its links as if it were fixed, so that what is wrong with them is told as well."""
    below: dict[str, list[UrdfJoint]] = {}
    for joint in sorted(declared, key=lambda j: j.name, reverse=True):
        below.setdefault(joint.parent, []).append(joint)
    joints: list[ir.Joint] = []
    frames: dict[str, tuple[int, ir.Pose]] = {root: (-1, ir.IDENTITY)}
    complete, waiting = True, list(below.get(root, []))
    while waiting:
        joint = waiting.pop()
        carrier, frame = frames[joint.parent]
        moved = builder.build(joint, carrier, len(joints), frame)
        if moved is None:
            complete = False
            frames[joint.child] = carrier, compose(frame, joint.origin)
        else:
            joints += moved.joints
            frames[joint.child] = (len(joints) - 1 if moved.joints else carrier), moved.frame
        waiting += [j for j in below.get(joint.child, []) if j.child not in frames]
    return joints, frames, complete


# --- shapes --------------------------------------------------------------------------------------------------------


def _shapes(
    reading: Reading, link: ElementTree.Element, frames: Frames, weighed: bool, whole: bool
) -> Iterator[_LinkShape]:
    """The collision shapes of a link. Those that have no volume, or are unknown, are left out with a warning; those of
    a link that is `weighed` by its inertial have no weight of their own. An effector takes a mesh as a `whole`, with
    all its parts."""
    name = link.get("name", "")
    joint, frame = frames[name]
    for collision in link.findall("collision"):
        forms = [form for geometry in collision.findall("geometry") for form in geometry]
        place = reading.place(collision)
        if place is None:
            continue
        if not forms:
            reading.warn(collision, f"a collision element of link `{name}` has no shape and is left out")
            continue
        for shape, middle in _made(reading, name, forms[0], whole):
            shift, own = make(middle, (0.0, 0.0, 0.0, 1.0)), 0.0 if weighed else None
            yield _LinkShape(name, ir.Link(joint, compose(frame, compose(place, shift)), shape, own))


def _made(
    reading: Reading, link: str, form: ElementTree.Element, whole: bool
) -> Sequence[tuple[ir.Shape, ir.Vec3]]:
    """The shapes of an element: of a hollow mesh its parts, as one shape where it is taken as a `whole`."""
    body = reading.context.library.meshes.get(mesh_name(reading.source.path, form)) if form.tag == "mesh" else None
    if body is not None and body.parts:
        from ..unions import union

        parts = [(ir.Shape(ir.ShapeKind.CONVEX, size), middle) for size, middle in body.parts]
        return [union([(middle, shape) for shape, middle in parts])] if whole else parts
    made = _shape(reading, link, form)
    return () if made is None else (made,)


def _shape(reading: Reading, link: str, form: ElementTree.Element) -> tuple[ir.Shape, ir.Vec3] | None:
    """A shape and where its frame is in that of the element."""
    origin = (0.0, 0.0, 0.0)
    if form.tag == "convex":  # what files of plans of format 1 have in place of meshes
        return ir.Shape(ir.ShapeKind.CONVEX, tuple(map(float, form.get("points", "").split()))), origin
    if form.tag == "mesh":
        body = reading.context.library.meshes.get(mesh_name(reading.source.path, form))
        return None if body is None else (ir.Shape(ir.ShapeKind.CONVEX, body.size), body.middle)
    if form.tag == "capsule" and not reading.newer:
        reading.warn(form, f"`capsule` does not count before version {FIRST_WITH_CAPSULES} of URDF and is left out")
        return None
    if form.tag == "box":
        size: tuple[float | None, ...] | None = reading.three(form, "size")
    elif form.tag in SIZES:
        size = tuple(reading.number(form, n) for n in SIZES[form.tag])
    else:
        reading.warn(form, f"link `{link}` has a collision shape `{form.tag}`, which is left out")
        return None
    if size is None or None in size:
        return None
    sizes = tuple(s for s in size if s is not None)
    if min(sizes) < 0:
        reading.fault(form, f"the {form.tag} of link `{link}` has a size of {min(sizes):g} m")
    elif max(sizes) > LONGEST:
        reading.fault(form, f"the {form.tag} of link `{link}` is larger than {LONGEST:g} m")
    elif min(sizes) == 0:
        reading.warn(form, f"the {form.tag} of link `{link}` has no volume and is left out")
    else:
        return ir.Shape(ir.ShapeKind(form.tag), sizes), origin
    return None


def _stood_for(
    reading: Reading, effectors: Sequence[ir.Effector], shape: _LinkShape, links: Mapping[str, ElementTree.Element]
) -> bool:
    """Whether one of these effectors, which have shapes of their own, is in place of the shape."""
    for effector in effectors:
        if covers(effector, shape.link):
            where = f"a collision shape of link `{shape.name}` lies in the effector `{effector.name}`"
            reading.warn(links[shape.name], f"{where}, which stands for it")
            return True
    return False


def _effector(
    context: Context, end: End, frames: Frames, shapes: Sequence[_LinkShape]
) -> tuple[ir.Effector, Sequence[_LinkShape]] | None:
    """The effector, and the shapes of its link that it takes over where it has none of its own: one with its frame,
    unless the effector states where it is, several as they lie around the effector's."""
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
        return replace(own, mass=end.said.weight(shape_volume(end.shape))), ()
    found = [s for s in shapes if s.name == link.value]
    if not found:
        help = f'write `effector {end.item.name}: "{link.value}" sphere(4 cm)`'
        message = f"this effector needs a shape: link `{link.value}` has 0 collision shapes"
        context.findings.report("E0509", end.item.span, message, help=help)
        return None
    shape, place = found[0].link.shape, found[0].link.placement
    if len(found) > 1 or end.item.at is not None or end.item.normal is not None:
        from ..hulls import HullError
        from ..unions import union_in_place

        place = own.placement
        try:
            shape = union_in_place([part for s in found for part in _seen_from(place, s.link)])
        except HullError as error:
            message = f"the collision shapes of link `{link.value}` are no body: {error}"
            context.findings.report("E0509", end.item.span, message)
            return None
    mass = end.said.weight(shape_volume(shape))
    mass = found[0].link.mass if mass is None else mass
    return replace(own, placement=place, shape=shape, mass=mass), found


def _seen_from(frame: ir.Pose, link: ir.Link) -> Iterator[tuple[ir.Vec3, ir.Shape]]:
    """The convex parts of a link's shape, turned like a frame, and where they are in it: what is turned otherwise, and
    is no ball, as the body around it."""
    from ..hulls import convex_shape, corners_around

    at = compose(inverse(frame), link.placement)
    for part in link.shape.solids:
        pose = part_pose(at, part)
        if part.shape.kind == ir.ShapeKind.SPHERE or abs(at[6]) > ALIGNED:
            yield position(pose), part.shape
        else:
            turned = [rotate(orientation(pose), corner) for corner in corners_around(part.shape).tolist()]
            shape, middle, _ = convex_shape([[a + b for a, b in zip(c, position(pose), strict=True)] for c in turned])
            yield middle, shape
