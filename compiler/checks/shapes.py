"""Shapes of bodies, effectors and links."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ...langs import syntax
from ...langs.diagnostics import did_you_mean
from .. import ir
from ..foreign import beside
from .context import Context
from .kinds import LENGTH
from .names import Scope
from .values import number, vector

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

SHAPES: Mapping[str, tuple[str, ...]] = {
    ir.ShapeKind.BOX: ("x", "y", "z"),
    ir.ShapeKind.SPHERE: ("radius",),
    ir.ShapeKind.CAPSULE: ("radius", "length"),
    ir.ShapeKind.CYLINDER: ("radius", "length"),
}
SAME_SHAPES = {
    "box": ("cube", "cuboid", "block", "rect", "plate"),
    "sphere": ("ball", "circle", "round"),
    "cylinder": ("tube", "disc", "disk", "rod", "pipe"),
    "capsule": ("pill", "stadium"),
}
"""What other tools call a shape."""
SMALLEST = 1e-6
"""Metres: no shape is smaller."""
HULLS: Mapping[str, str] = {
    "hull": "hull((x, y, z), …)", "mesh": 'mesh("file.stl")', "union": "union(box(…) at (x, y, z), …)",
}  # fmt: skip
LINK_SHAPES: Mapping[str, tuple[str, ...]] = {
    ir.ShapeKind.BOX: ("x", "y"),
    ir.ShapeKind.SPHERE: ("radius",),
    ir.ShapeKind.CAPSULE: ("radius",),
    ir.ShapeKind.CYLINDER: ("radius",),
}


def shape(
    context: Context, scope: Scope, call: syntax.Call, shapes: Mapping[str, tuple[str, ...]] = SHAPES
) -> ir.Shape | None:
    """The shape with its sizes in metres, or None where they are not known yet or wrong."""
    if shapes is SHAPES and call.function in HULLS:
        return (_union if call.function == "union" else _convex)(context, scope, call)
    return context.repeated.shape(call, scope.entries, lambda: _simple(context, scope, call, shapes))


def _simple(
    context: Context, scope: Scope, call: syntax.Call, shapes: Mapping[str, tuple[str, ...]]
) -> ir.Shape | None:
    findings = context.findings
    where = findings.word(call.span, call.function)
    form = shapes.get(call.function)
    if form is None:
        forms = [f"{name}({', '.join(sizes)})" for name, sizes in shapes.items()]
        forms += HULLS.values() if shapes is SHAPES else ()
        names = [*shapes, *(HULLS if shapes is SHAPES else ())]
        same = next((s for s, others in SAME_SHAPES.items() if call.function in others), None)
        help = f"did you mean `{same}`?" if same else did_you_mean(call.function, names)
        help = help or f"shapes are {', '.join(forms)}"
        findings.report("E0509", where, f"unknown shape `{call.function}`", help=help)
        return None
    if len(call.args) != len(form):
        wanted = f"{len(form)} size{'s' * (len(form) != 1)}"
        help = _sizes_help(context, call, form)
        findings.report("E0509", call.span, f"`{call.function}` has {wanted}, not {len(call.args)}", help=help)
        return None
    sizes = []
    for name, arg in zip(form, call.args, strict=True):
        value = number(context, scope, arg, LENGTH, f"the {name} of `{call.function}`", lenient=True)
        if value is not None and value <= 0:
            findings.report("E0509", arg.span, f"the {name} of `{call.function}` must be positive, not {value:g} m")
            value = None
        elif value is not None and value < SMALLEST:
            message = f"the {name} of `{call.function}` is less than {SMALLEST:g} m: {value:g} m"
            findings.report("E0509", arg.span, message)
            value = None
        sizes.append(value)
    return None if None in sizes else ir.Shape(ir.ShapeKind(call.function), tuple(s for s in sizes if s is not None))


def end_shape(context: Context, scope: Scope, call: syntax.Call) -> ir.Shape | None:
    """The shape of an effector; the parts of a `union` are at their places in the effector's frame."""
    return _union(context, scope, call, in_place=True) if call.function == "union" else shape(context, scope, call)


def _sizes_help(context: Context, call: syntax.Call, form: Sequence[str]) -> str:
    """A comma for a decimal point, else the sizes that the shape has."""
    written = context.findings.text(call.span)
    point = re.sub(r"(\d),(\d)", r"\1.\2", written)
    if point != written and point.count(",") == len(form) - 1:
        return f"write `{point}`"
    along = ": its length is that of the link" if len(form) < len(SHAPES.get(call.function, ())) else ""
    return f"it has the form `{call.function}({', '.join(form)})`{along}"


def _convex(context: Context, scope: Scope, call: syntax.Call) -> ir.Shape | None:
    """The hull of the points in the text, or of a mesh in a file, which may be followed by the length of its unit."""
    from ..hulls import HullError, convex_shape
    from ..unions import union

    named = bool(call.args) and isinstance(call.args[0], syntax.Text)
    if not named and call.function == "mesh":
        context.findings.report("E0509", call.span, "`mesh` names a file", help='write `mesh("file.stl")`')
        return None
    hulls = _mesh_parts(context, scope, call) if named else _listed_points(context, scope, call)
    if hulls is None:
        return None
    try:
        made = [convex_shape(points) for points in hulls]
    except HullError as error:
        context.findings.report("E0509", call.span, f"`{call.function}` is no body: {error}")
        return None
    if any(simpler for _, _, simpler in made):
        message = "this body has many corners, and is replaced by a simpler one around it"
        context.findings.report("W0006", call.span, message)
    return union([(middle, shape) for shape, middle, _ in made])[0]


def _union(context: Context, scope: Scope, call: syntax.Call, in_place: bool = False) -> ir.Shape | None:
    """Shapes at places in one frame, as one shape, whose frame is this one or in the middle of the box around it."""
    from ..hulls import HullError
    from ..unions import union, union_in_place

    parts: list[tuple[ir.Vec3, ir.Shape] | None] = [_placed(context, scope, arg) for arg in call.args]
    if not parts:
        help = "write `union(box(…) at (x, y, z), …)`"
        context.findings.report("E0509", call.span, "`union` has no parts", help=help)
    if not parts or None in parts:
        return None
    found = [part for part in parts if part is not None]
    try:
        return union_in_place(found) if in_place else union(found)[0]
    except HullError as error:
        context.findings.report("E0509", call.span, f"`union` is no body: {error}")
        return None


def _placed(context: Context, scope: Scope, arg: syntax.Term) -> tuple[ir.Vec3, ir.Shape] | None:
    """A part of a union, and where its middle is."""
    inner, place = arg.args if isinstance(arg, syntax.Call) and arg.function == "at" else (arg, None)
    if not isinstance(inner, syntax.Call):
        help = "write `union(box(…) at (x, y, z), …)`"
        context.findings.report("E0509", arg.span, "a part of `union` is a shape", help=help)
        return None
    form = shape(context, scope, inner)
    at = (0.0, 0.0, 0.0) if place is None else vector(context, scope, place, 3, LENGTH, "the place of a part")
    return None if form is None or at is None else ((at[0], at[1], at[2]), form)


def _listed_points(context: Context, scope: Scope, call: syntax.Call) -> list[ArrayLike] | None:
    found = [vector(context, scope, arg, 3, LENGTH, "a corner of a hull") for arg in call.args]
    return None if None in found else [[p for p in found if p is not None]]


def _mesh_parts(context: Context, scope: Scope, call: syntax.Call) -> list[ArrayLike] | None:
    """The corners of the hull of a mesh, or of its convex parts."""
    from ..mesh_solids import parts_of

    name, *rest = call.args
    assert isinstance(name, syntax.Text)
    unit: float | None = 1.0
    if len(rest) > 1:
        help = f'write `{call.function}("{name.value}", 1 mm)`'
        message = f"`{call.function}` takes a file and the length of its unit"
        context.findings.report("E0509", call.span, message, help=help)
        return None
    if rest:
        unit = number(context, scope, rest[0], LENGTH, "the unit of a mesh", lenient=True)
    if unit is not None and unit <= 0:
        context.findings.report("E0509", rest[0].span, f"the unit of a mesh must be positive, not {unit:g} m")
        return None
    path = beside(call.span.file, name.value)
    source = next((s for s in context.library.models if s.path == path), None)
    if source is None or unit is None:
        return None
    whole, *parts = parts_of(source.text)
    return [unit * corners for corners in parts if call.function == "mesh"] or [unit * whole]
